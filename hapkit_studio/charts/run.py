"""A run: position, velocity and force over time, and force over position."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hapkit_studio.charts.style import TICK, Colors, legend, save, style_axes, unbroken
from hapkit_studio.sessions import settings as settings_of
from hapkit_studio.settings_log import Log

_SIZE = (792, 450)
_LETTER = 0.016  # of the time axis: what a letter of a mark's words takes there
_MOST_CHANGES = 4  # lines of a caption
_ROOM = 0.25  # of the range: what is left free above the lines for words

Mark = tuple[float, str]
"""When something was changed, in s, and in words what."""


@dataclass(frozen=True)
class Past:
    """A stretch to compare with, (n,) each in SI: its words, token of its colour, dash in line widths."""

    words: str
    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    force: np.ndarray
    token: str
    dash: Sequence[float]


def run_figure(run: Any, path: str | Path, marks: Sequence[Mark] = (), past: Sequence[Past] = ()) -> None:
    """Write a Run's position, velocity and force over time and its force over position.

    The caption has the settings at the start, and below them each change with its time.
    """
    caption = "\n".join([_caption(run.log[0][1]), *_changes(run.log)])
    save(lambda figure, c: draw(figure, c, run, marks, past), path, _SIZE, caption=caption)


def draw(figure: Any, c: Colors, run: Any, marks: Sequence[Mark] = (), past: Sequence[Past] = ()) -> None:
    """Draw three quantities below one another, force over position beside them; what is past lies below."""
    grid = figure.add_gridspec(3, 2, width_ratios=(3, 2))
    upper, middle, lower = (figure.add_subplot(grid[i, 0]) for i in range(3))
    loop = figure.add_subplot(grid[:, 1])
    for was in past:
        look = {"color": getattr(c, was.token), "dashes": was.dash}
        upper.plot(was.time, 1e3 * was.position, label=was.words, **look)
        middle.plot(was.time, 1e3 * was.velocity, **look)
        lower.plot(was.time, was.force, **look)
        loop.plot(1e3 * was.position, was.force, **look)
    for name, place in run.moves.items():
        upper.plot(run.time, 1e3 * place, color=c.objline, dashes=(4, 2.5), label=name)
    upper.plot(run.time, 1e3 * run.position, color=c.position, label="handle")
    middle.plot(run.time, 1e3 * run.velocity, color=c.velocity)
    lower.plot(run.time, run.force, color=c.asked, dashes=(5, 3.5), label="asked", zorder=3)
    lower.plot(run.time, run.applied_force, color=c.applied, label="applied")
    loop.plot(1e3 * run.position, run.applied_force, color=c.applied)
    style_axes(upper, c, "", "position, mm")
    style_axes(middle, c, "", "velocity, mm/s")
    style_axes(lower, c, "time, s", "force, N")
    style_axes(loop, c, "position, mm", "force applied, N")
    begin, end = np.nanmin(run.time), np.nanmax(run.time)
    for axes in (upper, middle, lower):
        axes.set_xlim(begin, end if end > begin else None)
        for when, _ in marks:
            axes.axvline(when, color=c.ink3, linewidth=1, dashes=(3, 3), zorder=1)
    _write_marks(upper, c, marks, begin, end)
    legend(lower, c)
    if past or run.moves:
        legend(upper, c)


def _write_marks(axes: Any, c: Colors, marks: Sequence[Mark], begin: float, end: float) -> None:
    """Write the marks' words along the top; an older one gives way to a newer."""
    right, (low, high) = end, axes.get_ylim()
    axes.set_ylim(low, high + _ROOM * (high - low) * bool(marks))
    for when, words in reversed(marks):
        wide = _LETTER * len(words) * (end - begin)
        if when + wide <= right or right == end:
            axes.annotate(
                words, (max(min(when, end - wide), begin), 0.97), (4, 0), ("data", "axes fraction"),
                textcoords="offset points", va="top", size=TICK - 1, color=c.ink2, zorder=5,
                bbox={"facecolor": c.plot, "alpha": 0.85, "edgecolor": "none", "pad": 1.0},
            ).set_in_layout(False)  # fmt: skip
        right = min(right, when)


def _changes(log: Log) -> list[str]:
    """Return a line for each change, another environment with all its values; count the last of many."""
    found = [
        f"At {when:.2f} s: {words if before.get('environment') == now.get('environment') else _caption(now)}"
        for (_, before), (_, now), (when, words) in zip(log, log[1:], settings_of.words(log), strict=False)
    ]
    more = len(found) - _MOST_CHANGES
    return (
        found if more <= 0 else [*found[:_MOST_CHANGES], f"and {more} more, the last at {log[-1][0]:.2f} s"]
    )


def _caption(settings: Mapping) -> str:
    units, device = settings.get("units", {}), settings.get("device")
    words = [settings.get("environment", "")] + [
        f"{k} {v}" if isinstance(v, str) else f"{k} {v:,g} {units.get(k, '')}".rstrip()
        for k, v in settings.get("parameters", {}).items()
    ]
    words += [device if isinstance(device, str) else "Simulated Hapkit", f"hand: {settings.get('hand')}"]
    words += [f"{settings.get('rate_Hz', 0):,g} Hz", f"delay {1e3 * settings.get('delay_s', 0):g} ms"]
    words += [str(settings.get("estimator"))]
    return unbroken([w for w in words if w])
