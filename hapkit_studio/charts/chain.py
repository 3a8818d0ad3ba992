"""Speed and accuracy: the error of each way to render a scene as a stacked bar, by component.

Below the bars, where there is room: the method's own part of the error over the processor cycles it takes.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hapkit_studio.analysis import chain as analysis
from hapkit_studio.analysis.scene_error import COMPONENTS, DELAY, LIMIT, METHOD, SAMPLING, SENSOR, VELOCITY
from hapkit_studio.charts.accuracy import marker_and_color
from hapkit_studio.charts.style import (
    DASH,
    TEXT,
    TICK,
    Colors,
    Label,
    legend,
    save,
    style_axes,
    write_labels,
)
from hapkit_studio.haptics.board_plan import CLOCK
from hapkit_studio.haptics.engine import BOARD

if TYPE_CHECKING:
    from hapkit_studio.analysis.chain import Candidate, Chain

_KEY = (
    "Error against the scene itself in just-noticeable differences (JND), split by component; a part left of "
    "zero makes up for another. The black line in a bar is its total. Shaded: recommended. Ring: the default."
)
_LOOK = {
    METHOD: ("ink", ""),
    SAMPLING: ("position", "////"),
    DELAY: ("velocity", "..."),
    VELOCITY: ("energy", "\\\\\\\\"),
    SENSOR: ("hold", "||||"),
    LIMIT: ("lecture", "xxxx"),
}
"""Colour token and hatching of each component: they differ in grey, too."""
_CLIPPED = 20.0  # JND: longer bars end there, their number beside them
_LEAST = 0.05  # JND: a component with smaller parts is not in the legend
_RATE_AT, _LIMIT_AT = 66.0, 156.0  # points right of the axes where the columns end
_LINE = 21.0  # points that a row takes at least
_AROUND_BARS = 96.0  # points for legend, scale and title of the bars
_BELOW, _SHARE = 620.0, 0.62  # points of height that both charts need; share of the bars
_FLOOR, _CEILING = 1e-2, 1e2  # JND of the small chart
_PANEL, _SCENE, _BOTH = 860, 420, 720  # points of a picture


def chain_figure(chains: "Sequence[Chain]", path: str | Path) -> None:
    """Write the bars of each scene, a panel each."""
    columns = 1 if len(chains) <= 3 else 2
    rows = -(-len(chains) // columns)
    height = _BOTH if len(chains) == 1 else rows * _SCENE

    def paint(figure: Any, c: Colors) -> None:
        panels = figure.subfigures(rows, columns, squeeze=False).flat
        below = []
        for panel, chain in zip(panels, chains, strict=False):
            panel.suptitle(
                chain.question.environment.title, x=0.01, ha="left", size=TEXT, weight="bold", color=c.ink
            )
            below.append(_panels(panel, c, chain))
        figure.draw_without_rendering()
        for axes, chain in zip(below, chains, strict=True):
            _names(axes, c, chain)

    said = [
        f"{ch.question.environment.title}: {' '.join(filter(None, ch.sentences(p.name)))}"
        for ch in chains
        for p in ch.question.places
    ]
    save(paint, path, (columns * _PANEL, height), caption="\n".join((_KEY, *said)))


def draw(figure: Any, c: Colors, chain: "Chain") -> None:
    """Draw a scene's bars, and the small chart where there is room."""
    axes = _panels(figure, c, chain)
    figure.draw_without_rendering()
    _names(axes, c, chain)


def look(candidate: "Candidate", chain: "Chain") -> tuple[str, str]:
    """Return marker and colour token of a candidate: its method's, or its estimator's."""
    first = chain.question.choices[0] if chain.question.choices else None
    key = first.text(candidate.options[0][1]) if first else candidate.estimator
    return marker_and_color(key)


def shown(chain: "Chain", place: str, most: int) -> "list[Candidate]":
    """Return the candidates of a place with the smallest error, by error; never without those marked.

    Marked are the recommended one, the default and the one in use.
    """
    every = sorted(chain.compared(place), key=lambda one: (one.error, one.work))
    marked = (chain.recommendation(place).best, chain.default(place), chain.in_force(place))
    kept = [one for one in every if one in marked]
    kept += [one for one in every if one not in marked][: max(most - len(kept), 0)]
    return [one for one in every if one in kept]


def _panels(figure: Any, c: Colors, chain: "Chain") -> Any:
    """Draw the charts; return the axes of the small one, None without it."""
    height = figure.bbox.height / figure.dpi * 72.0
    both = height >= _BELOW and any(one.parts.get(METHOD) for one in chain.compared(BOARD))
    if not both:
        _bars(figure.add_subplot(), c, chain, height)
        return None
    grid = figure.add_gridspec(2, 1, height_ratios=(_SHARE, 1.0 - _SHARE))
    _bars(figure.add_subplot(grid[0]), c, chain, _SHARE * height)
    below = figure.add_subplot(grid[1])
    _own_part(below, c, chain)
    return below


# the bars


def _bars(axes: Any, c: Colors, chain: "Chain", height: float) -> None:
    places = [place.name for place in reversed(chain.question.places) if chain.compared(place.name)]
    sizes = [len(chain.compared(place)) for place in places]
    lines = int((height - _AROUND_BARS) / _LINE) - len(places)
    fits = (most for most in range(max(sizes), 1, -1) if sum(min(most, size) for size in sizes) <= lines)
    most = next(fits, 1)
    groups = {place: shown(chain, place, most) for place in places}
    every = [one for group in groups.values() for one in group]
    end, begin = _scale(every)
    at, ticks = 0.0, []
    for place, group in groups.items():
        hidden = len(chain.compared(place)) - len(group)
        more = f" (and {hidden} more)" if hidden else ""
        ticks.append((at, place.capitalize() + more, c.ink3, "bold"))
        if place == places[0]:
            _cell(axes, "Rate", at, _RATE_AT, c.ink3)
            _cell(axes, "Stiffness limit", at, _LIMIT_AT, c.ink3)
        for one in group:
            at += 1.0
            ticks.append(_row(axes, c, chain, one, at, end))
        at += 1.0
    for key, name in COMPONENTS.items():
        if any(abs(one.parts.get(key, 0.0)) >= _LEAST for one in every):
            token, hatch = _LOOK[key]
            axes.bar(0.0, 0.0, color=getattr(c, token), hatch=hatch, edgecolor=c.plot, label=name)
    style_axes(axes, c, "error against the scene itself, JND: shorter is better", "")
    axes.set(xlim=(begin, end), ylim=(at + 0.3, -0.6))
    axes.axvline(0.0, color=c.axis, linewidth=1.0, zorder=5)
    axes.axvline(analysis.UNFELT, color=c.danger, linewidth=1.6, linestyle=DASH, zorder=6)
    axes.annotate(
        "felt from here", (analysis.UNFELT, at - 0.15), (5.0, 0.0), textcoords="offset points", va="center",
        size=TICK, color=c.danger, weight="bold", zorder=7,
    )  # fmt: skip
    axes.grid(visible=False, axis="y")
    axes.tick_params(axis="y", length=0, pad=20)
    axes.set_yticks([tick[0] for tick in ticks], [tick[1] for tick in ticks])
    for label, (_, _, color, weight) in zip(axes.get_yticklabels(), ticks, strict=True):
        label.set(color=color, weight=weight)
    legend(axes, c)


def _scale(every: "list[Candidate]") -> tuple[float, float]:
    """Return where the scale ends, with room for a number, and where it begins."""
    ends = [_ends(one) for one in every if one.error <= _CLIPPED]
    longest = max((right for _, right in ends), default=0.0)
    if any(one.error > _CLIPPED for one in every):
        longest = min(1.3 * longest, _CLIPPED) or _CLIPPED
    longest = max(longest, 2.0 * analysis.UNFELT)
    least = min((left for left, _ in ends), default=0.0)
    return 1.22 * longest, 1.1 * max(least, -longest)


def _ends(one: "Candidate") -> tuple[float, float]:
    """Return where a bar begins and ends."""
    parts = one.parts.values() or (one.error,)
    return sum(p for p in parts if p < 0.0), sum(p for p in parts if p > 0.0)


def _row(axes: Any, c: Colors, chain: "Chain", one: "Candidate", at: float, end: float) -> tuple:
    """Draw a candidate; return where its name stands, the name, its colour and weight."""
    from matplotlib.transforms import blended_transform_factory, offset_copy

    best = one is chain.recommendation(one.place).best
    if best:
        across = blended_transform_factory(axes.figure.transSubfigure, axes.transData)
        band = axes.fill_between(
            (0.003, 0.997), at - 0.5, at + 0.5, transform=across, color=c.accentsoft, clip_on=False,
            zorder=0.2, linewidth=0.0,
        )  # fmt: skip
        band.set_in_layout(False)
    edge = end / 1.22
    left = right = 0.0
    for key, part in (one.parts or {METHOD: one.error}).items():
        token, hatch = _LOOK[key]
        start = right if part > 0.0 else left
        stop = min(start + part, edge)
        axes.barh(
            at, stop - start, 0.64, left=start, color=getattr(c, token), hatch=hatch, edgecolor=c.plot,
            linewidth=0.7, zorder=3,
        )  # fmt: skip
        right, left = (stop, left) if part > 0.0 else (right, stop)
    if left <= -_LEAST:
        axes.plot((one.error,) * 2, (at - 0.42, at + 0.42), color=c.ink, linewidth=2.5, zorder=6)
    clipped = _ends(one)[1] > 1.001 * edge
    total = ("→ " if clipped else "") + analysis.jnd(one.error)
    axes.annotate(
        total, (max(right, analysis.UNFELT), at), (5.0, 0.0), va="center",  # not on the line
        textcoords="offset points", size=TICK, weight="bold" if best else "normal", color=c.ink, zorder=7,
    )  # fmt: skip
    marker, token = look(one, chain)
    beside = offset_copy(axes.get_yaxis_transform(), axes.figure, x=-10.0, units="points")
    sign = {"transform": beside, "clip_on": False, "zorder": 6}
    axes.plot(0.0, at, marker, markersize=7, color=getattr(c, token), **sign)
    default = one is chain.default(one.place, one.estimator)
    if default:
        axes.plot(
            0.0, at, "o", markersize=14, markerfacecolor="none", markeredgecolor=c.accent,
            markeredgewidth=1.8, **sign,
        )  # fmt: skip
    weight = "bold" if best else "normal"
    _cell(axes, f"{one.rate:,.0f} Hz", at, _RATE_AT, c.ink, weight)
    _cell(axes, analysis.stiffness_words(one.limit), at, _LIMIT_AT, c.ink, weight)
    used = one is chain.in_force(one.place)
    words = ", ".join(
        filter(None, (one.name, "default" if default else "", "in use" if used and not default else ""))
    )
    return at, words, c.accent if best else c.ink, weight


def _cell(axes: Any, text: str, at: float, where: float, color: str, weight: str = "normal") -> None:
    """Write a cell of a column right of the axes; where: points from the axes to its right end."""
    axes.annotate(
        text, (1.0, at), (where, 0.0), axes.get_yaxis_transform(), textcoords="offset points", ha="right",
        va="center", size=TICK, color=color, weight=weight, annotation_clip=False,
    )  # fmt: skip


# the small chart


def _point(one: "Candidate") -> tuple[float, float]:
    """Return million cycles per second, and the method's own part of the error within the chart."""
    own = abs(one.parts.get(METHOD, 0.0))
    return one.cost * one.rate / 1e6, min(max(own, _FLOOR), _CEILING)


def _own_part(axes: Any, c: Colors, chain: "Chain") -> None:
    for one in chain.compared(BOARD):
        marker, token = look(one, chain)
        axes.plot(*_point(one), marker, markersize=8, color=getattr(c, token), zorder=4)
    has = CLOCK / 1e6
    axes.axvline(has, color=c.ink, linewidth=1.4)
    axes.axhline(analysis.UNFELT, color=c.danger, linewidth=1.6, linestyle=DASH, zorder=2)
    axes.set(yscale="log", ylim=(0.6 * _FLOOR, 1.7 * _CEILING), xlim=(0.0, 1.3 * has))
    axes.axvspan(has, 1.3 * has, facecolor=c.contact, edgecolor=c.grid, hatch="//", zorder=0.5)
    axes.text(1.15 * has, 0.3, "more than\nthe board has", size=TICK, color=c.ink2, ha="center", va="center")
    axes.set_yticks([_FLOOR, 0.1, 1.0, 10.0, _CEILING], ["≤ 0.01", "0.1", "1", "10", "≥ 100"], size=TICK)
    axes.minorticks_off()
    style_axes(axes, c, "processor cycles per second on the board, millions", "method's part, JND")


def _names(axes: Any, c: Colors, chain: "Chain") -> None:
    if axes is None:
        return
    # bold: the words cover no other sign
    labels = [
        Label(*_point(one), one.name, getattr(c, look(one, chain)[1]), bold=True)
        for one in chain.compared(BOARD)
    ]
    write_labels(axes, c, labels)
