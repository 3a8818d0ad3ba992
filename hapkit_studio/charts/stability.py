"""The map of damping and stiffness: boundaries, regions, and the rendered impedance."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from hapkit_studio.analysis.stability import kb_plane
from hapkit_studio.analysis.stability.kb_plane import Cells, Plane, Points
from hapkit_studio.analysis.stability.margin import factor, hand_text
from hapkit_studio.charts import style
from hapkit_studio.formatting import number

_SIZE = (972, 700)
# colour tokens of the classes DECAYS, BUZZES, GROWS
_TOKENS = ("stable", "warnsoft", "unstable")
_GROWS = 2
_FAINT = "40"  # an opacity of 25 %, as the last two digits of a colour
_HANDS = {"released": "-", "light": style.DASH, "medium": style.DASH_DOT, "firm": style.DOT}
# pt: smallest distance between dot and boundary at which the arrow has room for its label
_ROOM_FOR_WORDS = 40.0


@dataclass(frozen=True)
class Map:
    """A plane, its latest measurement, and further layers of the drawing.

    ``others`` are boundaries that were measured earlier. ``hands`` contains the exact boundary (n,) of every
    hand over the plane's damping. ``outdated`` is True if the measurement belongs to other conditions.
    ``dotted`` is True if the impedance can be shown as a dot.
    """

    plane: Plane
    others: Sequence[Points] = ()
    hands: Mapping[str, np.ndarray] = field(default_factory=dict)
    outdated: bool = False
    dotted: bool = True

    @property
    def particular(self) -> Cells | None:
        """Return the measured cells if they include dry friction or passivity control, else None."""
        cells = None if self.outdated else self.plane.cells
        return cells if cells is not None and (cells.real or cells.controller) else None

    @property
    def boundaries(self) -> tuple[Points, ...]:
        """Return every measured boundary; the newest one is last."""
        return (*self.others, *([self.plane.points] if self.plane.points is not None else []))

    def lines(self) -> dict[str, tuple[str, str]]:
        """Return name and meaning of the available lines, by key."""
        plane = self.plane
        there = {
            "exact": plane.setting.linear,
            "friction": plane.setting.coulomb > 0.0 and bool((plane.friction < plane.top).any()),
            "measured": bool(self.boundaries),
            "simple": True,
            "passive": bool(plane.edge.any()),
            "people": plane.family is not None,
            "coulomb": plane.coulomb < plane.top,
        }
        return {key: kb_plane.line_texts(plane, key) for key, on in there.items() if on}


def stability_figure(
    plane: Plane, path: str | Path, device: str = "", dampings: Mapping[str, float] = MappingProxyType({})
) -> None:
    """Write the plane with its verdict above and the conditions below; ``device`` is the device's name.

    ``dampings`` contains each hand's limit in N·s/m for scenes without stiffness.
    """
    shown = Map(plane)
    real = any(found is not None and found.real for found in (plane.cells, plane.points))
    unit, digits, found = ("N·s/m", 1, dampings) if dampings else ("N/m", 0, plane.hands)
    limits = [(f"Limit, {hand_text(h)}", f"{number(k, digits)} {unit}") for h, k in found.items() if k == k]
    own = [("Device", device)] if device else []
    pairs = [*own, *kb_plane.conditions(plane.setting, real), *limits]
    title = "Without the passivity controller: " if plane.setting.controller else ""
    style.save(
        lambda figure, c: draw(figure, c, shown),
        path,
        _SIZE,
        title + plane.text,
        style.unbroken([f"{name}: {text}" for name, text in shown.lines().values()])
        + "\n"
        + style.unbroken([" ".join(pair) for pair in pairs]),
    )


def draw(figure: Any, c: style.Colors, shown: Map) -> "Dot":
    """Draw regions, lines and measurements; return the movable dot."""
    plane, axes = shown.plane, figure.add_subplot()
    measured = style.pale(c) if shown.outdated else c
    style.style_axes(axes, c, "damping b, N·s/m", "stiffness k, N/m")
    axes.set_xlim(0.0, plane.width)
    axes.set_ylim(0.0, plane.top)
    axes.locator_params(nbins=6)
    axes.tick_params(axis="y", pad=7)  # leave room for the dot at zero damping, next to the tick labels
    _lines(axes, c, shown)
    _measured(axes, measured, shown)
    _regions(axes, c, measured, shown)
    style.legend(axes, c)
    figure.draw_without_rendering()  # labels can avoid artists only after these have positions
    for label in axes.texts:
        style.keep_clear(label, axes.lines)
    dot = Dot(axes, c)
    dot.place(plane, shown.dotted)
    return dot


def _lines(axes: Any, c: style.Colors, shown: Map) -> None:
    plane, names = shown.plane, {key: name for key, (name, _) in shown.lines().items()}
    if plane.setting.linear:
        axes.plot(plane.damping, plane.exact, color=c.ink, linewidth=3, label=names["exact"])
    if "friction" in names:
        name = names["friction"]
        axes.plot(plane.damping, plane.friction, color=c.ink2, linewidth=2, linestyle=style.DASH, label=name)
    for hand, limits in shown.hands.items():
        inside = np.flatnonzero(limits < plane.top)
        if hand != plane.setting.hand and len(inside):
            axes.plot(plane.damping, limits, color=c.ink2, linewidth=1.6, linestyle=_HANDS.get(hand, "-"))
            axes.annotate(
                hand_text(hand), (plane.damping[inside[-1]], limits[inside[-1]]), (-4, 9), va="center",
                textcoords="offset points", size=style.TICK, color=c.ink, path_effects=style.text_outline(c),
                annotation_clip=False,
            ).set_in_layout(False)  # fmt: skip
    axes.plot(
        plane.damping, plane.simple, color=c.asked, linewidth=2, linestyle=style.DOT, label=names["simple"]
    )
    if "passive" in names:
        name = names["passive"]
        axes.plot(
            plane.edge_damping,
            plane.edge,
            color=c.velocity,
            linewidth=2,
            linestyle=style.DASH_DOT,
            label=name,
        )
    if plane.family is not None:
        family = plane.family
        axes.plot(family.damping, family.people, color=c.lecture, linewidth=2.4, label=names["people"])
    if "coulomb" in names:
        axes.axhline(plane.coulomb, color=c.warn, linewidth=2, linestyle=(0, (6, 3)), label=names["coulomb"])


def _measured(axes: Any, c: style.Colors, shown: Map) -> None:
    """Draw measured boundaries; points outside the frame do not change the layout."""
    plane = shown.plane
    for points in shown.boundaries:
        seen = (points.stiffness <= plane.top) & (points.damping <= plane.width)
        color = c.applied if points.controller else c.position
        axes.plot(
            points.damping[seen], points.stiffness[seen], "o", markersize=8, color=color,
            clip_on=not seen.any(), markerfacecolor=c.plot, markeredgewidth=2, zorder=5,
            label=points.name if seen.any() else f"{points.name}: beyond this map",
        )  # fmt: skip


def _regions(axes: Any, c: style.Colors, measured: style.Colors, shown: Map) -> None:
    from matplotlib.patches import Rectangle

    plane, cells = shown.plane, shown.plane.cells
    hand = hand_text(plane.setting.hand)
    whose = hand if shown.particular or not plane.setting.controller else "without controller"
    named = dict.fromkeys(("stable", "unstable"), whose) if plane.setting.linear else {}
    friction = plane.setting.linear and plane.setting.coulomb > 0.0 and cells is None
    if friction:
        named["warnsoft"] = whose
        if not (plane.friction < plane.top).any():
            del named["unstable"]
    if plane.setting.linear and shown.particular is None:
        axes.fill_between(
            plane.damping,
            plane.exact,
            10.0 * plane.top,
            zorder=0.1,
            linewidth=0.0,
            **_unstable_style(c, plane),
        )
        axes.fill_between(plane.damping, 0.0, plane.friction, color=c.warnsoft, linewidth=0.0, zorder=0.25)
        axes.fill_between(plane.damping, 0.0, plane.exact, color=c.stable, linewidth=0.0, zorder=0.26)
        axes.fill_between(plane.damping, *plane.again, color=c.stable, linewidth=0.0, zorder=0.26)
    if cells is not None:
        _cells(axes, measured, cells, _unstable_style(measured, plane))
        named |= {_TOKENS[kind]: hand for kind in np.unique(cells.classes)}
    if plane.edge.any():
        axes.fill_between(plane.edge_damping, 0.0, plane.edge, color=c.passive, linewidth=0.0, zorder=0.4)
        sample = Rectangle((0, 0), 0, 0, color=c.passive, label="passive: stable in any hand")
        axes.add_patch(sample)
    kinds = kb_plane.class_descriptions(cells is not None and cells.controller)
    for token, kind in zip(_TOKENS, kinds, strict=True):
        if token in named:
            grows = "grows after a small push" if friction else "grows"
            exact = {
                "stable": "stable",
                "unstable": "grows if attached to the spring" if plane.pushes else grows,
            }
            exact |= {"warnsoft": "stable for small pushes"} if friction else {}
            word = kind if shown.particular is not None else exact.get(token, kind)
            attached = token == "unstable" and plane.pushes
            label = word if attached or token == "warnsoft" else f"{word}, {named[token]}"
            patch_style = (
                _unstable_style(c, plane) if token == "unstable" else {"facecolor": getattr(c, token)}
            )
            axes.add_patch(Rectangle((0, 0), 0, 0, label=label, **patch_style))


def _unstable_style(c: style.Colors, plane: Plane) -> dict[str, Any]:
    """Return the style of the unstable region; it is mild if the scene only pushes the handle out."""
    ground, hatch = (c.contact, c.ink3) if plane.pushes else (c.unstable, c.danger)
    return {"facecolor": ground, "edgecolor": hatch + _FAINT, "hatch": "//"}


def _cells(axes: Any, c: style.Colors, cells: Cells, beyond: dict[str, Any]) -> None:
    from matplotlib.colors import ListedColormap

    axes.pcolormesh(
        cells.damping, cells.stiffness, cells.classes, shading="nearest", vmin=-0.5, vmax=2.5,
        cmap=ListedColormap([c.stable, c.warnsoft, beyond["facecolor"]]), rasterized=True, zorder=0.3,
    )  # fmt: skip
    if (cells.classes == _GROWS).any():
        hatched = axes.contourf(
            cells.damping, cells.stiffness, cells.classes, levels=[1.5, 2.5], colors="none",
            hatches=[beyond["hatch"]], zorder=0.35,
        )  # fmt: skip
        hatched.set(edgecolor=beyond["edgecolor"], linewidth=0.0)


class Dot:
    """The rendered impedance with its values, and an arrow to the boundary; ``artists`` are drawn last."""

    def __init__(self, axes: Any, c: style.Colors):
        self._c, self._names = c, list(axes.texts)
        font = {
            "textcoords": "offset points", "size": style.TEXT, "weight": "bold", "va": "center", "zorder": 8,
            "path_effects": style.text_outline(c), "annotation_clip": False,
        }  # fmt: skip
        (self._feet,) = axes.plot([], [], linewidth=1.4, linestyle=":")
        (self._dot,) = axes.plot([], [], "o", markersize=15, color=c.accent, clip_on=False, zorder=8)
        self._arrow = axes.annotate(
            "", (0, 0), (0, 0), zorder=7,
            arrowprops={"arrowstyle": "-|>", "linewidth": 2.2, "mutation_scale": 18, "shrinkB": 0},
        )  # fmt: skip
        self.label = axes.annotate("", (0, 0), (0, 0), **font)
        self._factor = axes.annotate("", (0, 0), (0, 0), **font)
        self.artists = (self._feet, self._arrow, self._dot, self.label, self._factor)
        for artist in self.artists:
            artist.set_in_layout(False)

    def place(self, plane: Plane, dotted: bool = True) -> None:
        """Move the dot to a plane's impedance; show it if ``dotted`` is true."""
        margin, c = plane.margin, self._c
        bad = not plane.verdict.calm if plane.verdict else not margin.stable and plane.setting.linear
        warned = bad and plane.verdict is not None and plane.verdict.sign[1] == "warn"
        color = c.warn if warned else c.danger if bad else c.accent
        x, y = margin.damping, margin.stiffness
        self._feet.set(data=([0.0, x, x], [y, y, 0.0]), color=color)
        self._dot.set(data=([x], [y]), markeredgecolor=color if bad else c.plot, markeredgewidth=2)
        bound = y > 0.0 and margin.limit > 0.0 and not margin.island
        tip = min(margin.limit, 0.98 * plane.top) if bound else math.nan
        self._arrow.xy, self._arrow.xyann = (x, tip), (x, y)
        self._arrow.arrow_patch.set_color(color)
        high = 0.75 * 72.0 * self._dot.figure.get_figheight()
        far = abs(tip - y) * high > _ROOM_FOR_WORDS * plane.top
        middle, ratio = (0.5 * (tip + y), factor(margin.ratio)) if far else (y, "")
        for label, height, text in (
            (self.label, y, f"{y:,.0f} N/m, {x:.1f} N·s/m"),
            (self._factor, middle, ratio),
        ):
            label.set(text=text, color=color)
            label.xy = x, height
            lines = [line for line in label.axes.lines if line is not self._dot]
            taken = [*self._names, *([self.label] if label is self._factor else [])]
            style.keep_clear(label, lines, [other.get_window_extent() for other in taken])
        for artist in self.artists:
            artist.set_visible(dotted)
        self._arrow.set_visible(dotted and abs(tip - y) > 0.03 * plane.top)
