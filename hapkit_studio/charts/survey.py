"""Figure of a survey: median and lowest decile of the stiffness limit over rate and over delay."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hapkit_studio.charts.accuracy import marker_and_color
from hapkit_studio.charts.style import DASH, Colors, legend, save, style_axes
from hapkit_studio.dynamics.estimators import ESTIMATORS
from hapkit_studio.formatting import compact

if TYPE_CHECKING:
    from hapkit_studio.analysis.survey import Axes

_SIZE = (936, 432)
_PANELS = (1, "rate, Hz", 1.0), (2, "delay, ms", 1e3)
_NEWTONS = 1.0, 1e5  # axis range in N/m
_FEWEST = 5  # smallest number of points for a median


def survey_figure(found: "tuple[Axes, np.ndarray]", path: str | Path) -> None:
    """Write the stiffness limits over rate and over delay; cells that are not computed yet are ignored."""
    axes, limits = found
    known = np.mean(~np.isnan(limits))
    title = f"What rate buys and delay costs: {compact(100.0 * known, 3)} % of {limits.size:,} loops computed"
    caption = f"{axes.text}. Lines: median over all others. Dashed: the softest tenth."
    save(lambda figure, c: draw(figure, c, axes, limits), path, _SIZE, title, caption)


def draw(figure: Any, c: Colors, axes: "Axes", limits: np.ndarray) -> None:
    """Draw the limit in N/m over rate and over delay."""
    panels = figure.subplots(1, 2, sharey=True)
    for panel, (which, across, scale) in zip(panels, _PANELS, strict=True):
        values = scale * np.array((axes.rates, axes.delays)[which - 1])
        for number, key in enumerate(axes.estimators):
            marker, color = marker_and_color(key)
            middle, low = _quantiles(np.moveaxis(limits[number], which - 1, 0))
            style = {"color": getattr(c, color), "markersize": 4.5}
            panel.plot(values, middle, marker, linestyle="-", label=ESTIMATORS[key].label, **style)
            panel.plot(values, low, linestyle=DASH, linewidth=1.2, **style)
        panel.set(yscale="log", ylim=_NEWTONS, xscale="log" if which == 1 else "linear")
        style_axes(panel, c, across, "stiffness limit, N/m" if which == 1 else "")
    legend(panels[0], c)


def _quantiles(limits: np.ndarray) -> np.ndarray:
    """Return median and lowest decile (2, n) of limits (n, ...); NaN with fewer than _FEWEST limits."""
    found = np.full((2, len(limits)), np.nan)
    for column, each in enumerate(limits):
        known = each[~np.isnan(each)]
        if known.size >= _FEWEST:
            found[:, column] = np.quantile(known, (0.5, 0.1))
    return np.where(found > 0.0, found, np.nan)
