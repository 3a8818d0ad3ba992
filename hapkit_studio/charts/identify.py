"""Figure of an identification: partial residuals with fit and confidence band, residuals below."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hapkit_studio.analysis.identify.texts import conditions
from hapkit_studio.charts.style import DOT, TEXT, TICK, Colors, save, style_axes, unbroken

if TYPE_CHECKING:
    from hapkit_studio.analysis.identify import Identified, Part, Points

# for each term, the label of the x axis, and the number of its display units per SI unit
AXES = {
    "stiffness": ("position, mm", 1e3),
    "damping": ("velocity, mm/s", 1e3),
    "damping_in": ("velocity into the wall, mm/s", 1e3),
    "damping_out": ("velocity out of the wall, mm/s", 1e3),
    "friction": ("direction of motion", 1.0),
    "mass": ("acceleration, m/s²", 1.0),
    "viscous": ("velocity, mm/s", 1e3),
    "coulomb": ("direction of motion", 1.0),
}
TITLES = {"rendered": "Properties of the scene", "handle": "Properties of the handle"}
_MOST_PANELS = 3
_SIZE = (1080, 500)
# pt: smallest height with enough room for the residuals
_BOTH = 270.0
_STEPS = 60


def identify_figure(found: "Identified", path: str | Path, source: Sequence[tuple[str, str]] = ()) -> None:
    """Write the charts of the rendered impedance and of the handle, each with residuals and sentences below.

    The settings are at the bottom. ``source`` describes the device or file as pairs of name and value.
    """
    parts = [part for part in (found.rendered, found.handle) if part.points is not None] or [found.rendered]

    def paint(figure: Any, c: Colors) -> None:
        for row, part in zip(figure.subfigures(len(parts), 1, squeeze=False)[:, 0], parts, strict=True):
            lines = [line for line in found.sentences(part) if not line.startswith("  ")]
            row.suptitle(TITLES[part.key], size=TEXT + 3, color=c.ink, weight="bold")
            row.supxlabel("\n".join(lines), size=TICK, color=c.ink, x=0.04, ha="left")
            draw(row, c, part, 0.0)

    pairs = [*source, *conditions(found.setup, found.handle.released)]
    caption = f"{found.force_known}\n" + unbroken([f"{name} {value}".rstrip() for name, value in pairs])
    save(paint, path, (_SIZE[0], _SIZE[1] * len(parts)), caption=caption)


def draw(figure: Any, c: Colors, part: "Part", end: float) -> None:
    """Draw a part's terms side by side, with residuals below; ``end`` is the origin of the time axis in s."""
    names = [name for name in part.points.names if name in AXES][:_MOST_PANELS] if part.points else []
    if part.points is None or not names:  # without motion, only a constant force is fitted
        return
    high = 72.0 * figure.get_figheight() if hasattr(figure, "get_figheight") else _BOTH
    rows = (3, 1) if high >= _BOTH else (1,)
    grid = figure.add_gridspec(len(rows), len(names), height_ratios=rows)
    for column, name in enumerate(names):
        axes = figure.add_subplot(grid[0, column])
        _term(axes, c, part, name)
        axes.set_ylabel("force of this term, N" if column == 0 else "", size=TICK, color=c.axis)
    if len(rows) > 1:
        _residuals(figure.add_subplot(grid[1, :]), c, part.points, end)


def _term(axes: Any, c: Colors, part: "Part", name: str) -> None:
    """Draw a term's partial residuals, fit, confidence band and set value."""
    points, estimate = part.points, part[name]
    assert points is not None
    label, scale = AXES[name]
    own, force = points.share(name)
    sign = -1.0 if part.key == "rendered" else 1.0
    across = np.linspace(own.min(), own.max(), _STEPS)
    fit, half = points.line(name, across)
    axes.plot(scale * own, sign * force, ".", markersize=3, color=c.applied, alpha=0.6)
    axes.fill_between(
        scale * across, sign * (fit - half), sign * (fit + half), color=c.theory, edgecolor=c.edge, zorder=1
    )
    axes.plot(scale * across, sign * fit, color=c.ink, linewidth=2)
    if estimate.asked is not None:
        middle = 0.5 * (across[0] + across[-1]) if name == "stiffness" else 0.0
        through = np.interp(middle, across, fit) if name == "stiffness" else 0.0
        asked = sign * (through + estimate.asked * (across - middle))
        axes.plot(scale * across, asked, color=c.hold, linestyle=DOT, linewidth=2)
    axes.set_title(estimate.term.label, size=TEXT, color=c.ink, loc="left")
    style_axes(axes, c, label, "")
    axes.locator_params(nbins=5)


def _residuals(axes: Any, c: Colors, points: "Points", end: float) -> None:
    axes.plot(points.time - end, 1e3 * points.fit.residual, ".", markersize=2.5, color=c.applied)
    axes.axhline(0.0, color=c.ink2, linewidth=1)
    style_axes(axes, c, "time, s (residual: the force that no term explains)", "mN")
    axes.locator_params(axis="y", nbins=4)
