"""Bode diagram of the rendered impedance, with stiffness, damping and mass over frequency."""

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hapkit_studio.analysis.bode import LINEAR
from hapkit_studio.charts.style import (
    DASH,
    DOT,
    TICK,
    Colors,
    legend,
    number_ticks,
    save,
    style_axes,
    unbroken,
)
from hapkit_studio.formatting import hertz, with_unit

if TYPE_CHECKING:
    from hapkit_studio.analysis.bode.result import Bode, Curve, Response
    from hapkit_studio.dynamics.loop_settings import LoopSettings

_SIZE = (1000, 640)
_HUES = "position", "applied", "velocity", "asked"
_STIFFNESS, _DAMPING, _MASS = 2, 3, 4  # panel indices
_ROOM = 1.3  # factor on the axis limits, to leave room for labels
_LONGEST_BAR = 2.0  # largest length of an error bar, as a multiple of the range of the dampings
_AXIS_FACTOR = 4.0  # the axis extends from the measured range by this factor below and above


def bode_figure(found: "Bode", path: str | Path) -> None:
    """Write the diagram with a description of each loop and with the conditions."""
    key = "Filled dots: measured", "hollow dots: measured, not proportional to the motion", "lines: theory"
    caption = unbroken([*key, found.driven, *conditions(found)])
    save(lambda figure, c: draw(figure, c, found), path, _SIZE, "", f"{found.sentence}\n{caption}")


def conditions(found: "Bode") -> list[str]:
    """Return the conditions of the measurement."""
    s = found.curves[0].setting
    own = f"handle {with_unit(1e3 * s.mass, 'g')}, {with_unit(s.viscous, 'N·s/m')}"
    delays = [f"{curve.name}: delay {with_unit(1e6 * curve.setting.delay, 'µs')}" for curve in found.curves]
    return [own, *delays]


def draw(figure: Any, c: Colors, found: "Bode") -> None:
    """Draw six quantities over frequency, and the frequency up to which each curve acts as a wall."""
    grid = figure.add_gridspec(3, 2, height_ratios=(3, 3, 2))
    first = figure.add_subplot(grid[0, 0], xscale="log")
    # grid positions of the quantities of _values after the first one, and of the coherence
    places = (1, 0), (0, 1), (1, 1), (2, 1), (2, 0)
    panels = [first, *(figure.add_subplot(grid[place], sharex=first) for place in places)]
    names = "|Z|, N/m", "phase of Z, °", "stiffness, N/m", "damping, N·s/m", "mass, g", "coherence"
    for axes, name in zip(panels, names, strict=True):
        lowest = axes in panels[-2:]
        style_axes(axes, c, "frequency, Hz" if lowest else "", name)
        axes.tick_params(labelbottom=lowest)
        axes.locator_params(axis="y", nbins=5)
    for curve, hue in zip(found.curves, _HUES, strict=False):
        _curve(panels, curve, getattr(c, hue), c)
    _handle(panels, c, found.curves[0].setting)
    for row, (curve, hue) in enumerate(zip(found.curves, _HUES, strict=False)):
        _mark(panels, curve, getattr(c, hue), row)
    legend(first, c)


def _curve(panels: list, curve: "Curve", color: str, c: Colors) -> None:
    """Draw theory as lines and measurements as dots; a dot is hollow if the response at it is nonlinear."""
    if curve.theory is not None:
        for axes, values in zip(panels, _values(curve.theory), strict=False):
            axes.plot(curve.theory.frequency, values, color=color, linewidth=2.2, alpha=0.5)
    sure, frequency = curve.coherence >= LINEAR, curve.measured.frequency
    for axes, values in zip(panels, [*_values(curve.measured), curve.coherence], strict=True):
        axes.plot(frequency[sure], values[sure], "o", color=color, markersize=4.5, label=curve.name)
        axes.plot(frequency[~sure], values[~sure], "o", color=color, markersize=4.5, markerfacecolor=c.plot)
    damping, wide = curve.measured.damping, curve.damping_interval
    # omit the error bars at the lowest frequencies, where the quantisation error exceeds the damping force
    seen = wide < _LONGEST_BAR * np.ptp(damping)
    panels[_DAMPING].errorbar(
        frequency[seen], damping[seen], wide[seen], fmt="none", ecolor=color, elinewidth=1.0, capsize=2.0
    )


def _mark(panels: list, curve: "Curve", color: str, row: int) -> None:
    """Mark the frequency up to which a curve acts as a wall; ``row`` is the row of the label."""
    if math.isnan(curve.ends):
        return
    for axes in panels:
        axes.axvline(curve.ends, color=color, linewidth=1.4, linestyle=DASH)
    soft = curve.ends == curve.softens
    text = f"{hertz(curve.ends)}: {'stiffness only 71 %' if soft else 'loop adds energy'}"
    # the label goes towards the middle of the axis
    near = curve.ends < math.sqrt(math.prod(panels[0].get_xlim()))
    panels[_STIFFNESS if soft else _DAMPING].annotate(
        text, (curve.ends, 1.0), (5 if near else -5, -5 - 1.3 * TICK * row), va="top",
        xycoords=("data", "axes fraction"), textcoords="offset points", ha="left" if near else "right",
        size=TICK, color=color, weight="bold",
    )  # fmt: skip


def _values(response: "Response") -> tuple[np.ndarray, ...]:
    """Return magnitude, phase in degrees, stiffness in N/m, damping in N·s/m, and mass in g."""
    z = response.impedance
    phase = np.where(z, np.degrees(np.unwrap(np.angle(z))), math.nan)
    return np.where(z, np.abs(z), math.nan), phase, response.stiffness, response.damping, 1e3 * response.mass


def _handle(panels: list, c: Colors, setting: "LoopSettings") -> None:
    """Draw mass and damping of the handle as dotted lines, which do not affect the axis limits."""
    style = {"color": c.ink2, "linestyle": DOT, "linewidth": 1.6}
    panels[_DAMPING].axhline(-setting.viscous, **style)
    panels[_MASS].axhline(1e3 * setting.mass, **style)
    panels[_STIFFNESS].axhline(0.0, color=c.line, linewidth=1.0)
    for axes in panels[1:]:
        low, high = axes.get_ylim()
        axes.set_ylim(low, low + _ROOM * (high - low))
    low, high = panels[0].get_ylim()
    panels[0].set_ylim(max(low, 0.01 * high) / _AXIS_FACTOR, high * _AXIS_FACTOR)
    panels[0].set_yscale("log")
    number_ticks(panels[0].yaxis)
    panels[_MASS].set_ylim(bottom=0.0)
    panels[-1].set_ylim(0.0, 1.1)
    left, right = panels[0].get_xlim()
    turn = 2.0 * math.pi * np.geomspace(left, right, 300)
    inertia, frequency = setting.mass * turn**2, turn / (2.0 * math.pi)
    for axes in panels:
        axes.autoscale(False)
    panels[0].plot(frequency, np.hypot(inertia, setting.viscous * turn), label="handle alone", **style)
    panels[_STIFFNESS].plot(frequency, inertia, **style)
