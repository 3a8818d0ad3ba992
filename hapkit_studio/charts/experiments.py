"""Charts of experiments with people: time over difficulty, and the staircase with its fitted function."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from hapkit_studio.analysis.discrimination import CONVERGES, Threshold, right_share
from hapkit_studio.analysis.pointing import Interval, Line
from hapkit_studio.charts.style import DASH, DASH_DOT, DOT, Colors, legend, number_ticks, save, style_axes
from hapkit_studio.columns import Column
from hapkit_studio.formatting import interval, number, on_screen, with_unit

_SIZE = (760, 460)
_HUES = "position", "applied", "velocity", "asked", "ok", "warn", "ink2", "danger"
_MARKS, _DASHES = "osD^vP*X", ("solid", DASH, DOT, DASH_DOT)
_SLOPE = 1.3  # slope with which the Weibull function best describes comparisons of noisy impressions


def interval_text(found: Interval, decimals: int, factor: float = 1.0) -> str:
    """Format an estimate with half of its 95 % interval; a missing estimate gives a dash."""
    if not math.isfinite(found.value):
        return "–"
    if not math.isfinite(found.half):
        return number(factor * found.value, decimals)
    return interval(factor * found.value, factor * found.half, decimals)


def pointing_columns() -> tuple[Column, ...]:
    """Return the columns of a table of conditions."""
    return (
        Column("Condition", lambda r: r.condition, right=False),
        Column("Friction", lambda r: number(r.force, 1), unit="N"),
        Column("Trials", lambda r: str(r.count)),
        Column("a", lambda r: interval_text(r.intercept, 0, 1e3), unit="ms"),
        Column("b", lambda r: interval_text(r.slope, 0, 1e3), unit="ms/bit"),
        Column("r²", lambda r: number(r.fit, 2) if math.isfinite(r.fit) else "–"),
        Column("Throughput", lambda r: interval_text(r.throughput, 1), unit="bit/s"),
        Column("Missed", lambda r: number(100.0 * r.missed / r.count, 0), unit="%"),
        Column(
            "Time", lambda r: interval_text(r.change, 0, 100.0), unit="% more"
        ),
    )  # fmt: skip


def pointing_figure(found: Sequence[Line], path: str | Path) -> None:
    """Write the movement times over the index of difficulty."""
    caption = (
        "Points: mean of the trials with the same distance and width. Lines: fit of movement time = a + b · "
        "index of difficulty (how difficult a target is)"
    )
    save(lambda figure, c: draw_pointing(figure, c, found), path, _SIZE, caption=caption)


def draw_pointing(figure: Any, c: Colors, found: Sequence[Line]) -> None:
    """Draw each condition's mean times and its line."""
    axes = figure.add_subplot()
    style_axes(axes, c, "index of difficulty of the target, bit", "movement time, s")
    for at, line in enumerate(found):
        color, mark = getattr(c, _HUES[at % len(_HUES)]), _MARKS[at % len(_MARKS)]
        x = np.array([cell.difficulty for cell in line.cells])
        axes.plot(x, [cell.seconds for cell in line.cells], mark, color=color, label=line.condition)
        if math.isfinite(line.slope.value):
            ends = np.array([x.min(), x.max()])
            dash = _DASHES[at % len(_DASHES)]
            axes.plot(ends, line.intercept.value + line.slope.value * ends, color=color, linestyle=dash)
    axes.set_ylim(bottom=0.0)
    legend(axes, c)


def threshold_text(found: Threshold) -> str:
    """Return the threshold, the Weber fraction and their intervals as one sentence."""
    value, low, high = (on_screen(one, found.unit, 3) for one in found.threshold)
    weber = [number(100.0 * one, 0) for one in found.weber]
    name = found.parameter.replace("_", " ")
    turned = math.isfinite(found.reversals)
    mean = f", mean of the last reversals {on_screen(found.reversals, found.unit, 3)}" if turned else ""
    return (
        f"{name.capitalize()} {on_screen(found.base, found.unit)}: threshold {value} ({low} to {high}), "
        f"Weber fraction {weber[0]} % ({weber[1]} to {weber[2]} %), "
        f"{found.right} of {len(found.answers)} correct{mean}."
    )


def threshold_figure(found: Threshold, path: str | Path) -> None:
    """Write the figure with the staircase and the fractions of right answers."""
    right = with_unit(100.0 * CONVERGES, "%")
    note = f"In brackets: 95 % intervals. At the threshold, {right} of the answers are correct."
    caption = f"{threshold_text(found)} {note}"
    save(lambda figure, c: draw_threshold(figure, c, found), path, _SIZE, caption=caption)


def draw_threshold(figure: Any, c: Colors, found: Threshold) -> None:
    """Draw the step of every answer, and the fraction of right answers over the step."""
    left, right = figure.subplots(1, 2)
    steps = np.round(100.0 * np.array([one.step for one in found.answers]) / found.base, 6)
    good, low, high = np.array([one.right for one in found.answers]), *found.weber[1:]
    turns, value = np.arange(1, len(steps) + 1), 100.0 * found.weber.value
    style_axes(left, c, "answer", "step, % of the base")
    left.plot(turns, steps, color=c.line, drawstyle="steps-mid", linewidth=1.0)
    left.plot(turns[good], steps[good], "o", color=c.position, label="correct")
    left.plot(turns[~good], steps[~good], "X", color=c.danger, label="wrong")
    left.axhline(value, color=c.ink2, linestyle=DASH, label="threshold")
    left.axhspan(100.0 * low, 100.0 * high, color=c.stable, linewidth=0.0)
    left.set_yscale("log")
    _plain_ticks(left.yaxis)
    legend(left, c)
    style_axes(right, c, "step, % of the base", "correct answers, %")
    levels, places, counts = np.unique(steps, return_inverse=True, return_counts=True)
    share = np.bincount(places, good) / counts
    right.scatter(levels, 100.0 * share, s=12.0 * counts, color=c.position, zorder=3)
    across = np.geomspace(min(levels[0], value) / 1.5, max(levels[-1], value) * 1.5, 200)
    right.plot(across, 100.0 * right_share(across, value, _SLOPE), color=c.ink2)
    right.axvline(value, color=c.ink2, linestyle=DASH)
    right.set_xscale("log")
    _plain_ticks(right.xaxis)
    right.set_ylim(0.0, 105.0)


def _plain_ticks(axis: Any) -> None:
    """Put ticks at 1, 2 and 5 times the powers of ten of a logarithmic axis."""
    from matplotlib.ticker import LogLocator, NullLocator

    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_minor_locator(NullLocator())
    number_ticks(axis)
