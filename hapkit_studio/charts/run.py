"""A run: position, velocity and force over time, and force over position."""

from pathlib import Path
from typing import Any

from hapkit_studio.charts.style import APPLIED, ASKED, GRID, POSITION, VELOCITY
from hapkit_studio.figures import new_figure


def run_figure(run: Any, path: str | Path) -> None:
    """Write a Run's position, velocity and force over time and its force over position.

    The path's ending picks the format. Raise ParameterError for an ending that is no format of pictures.
    """
    figure = new_figure(path, (11, 6))
    grid = figure.add_gridspec(3, 2, width_ratios=(3, 2))
    upper, middle, lower = (figure.add_subplot(grid[i, 0]) for i in range(3))
    upper.plot(run.time, 1e3 * run.position, color=POSITION)
    upper.set_ylabel("position, mm")
    middle.plot(run.time, 1e3 * run.velocity, color=VELOCITY)
    middle.set_ylabel("velocity, mm/s")
    lower.plot(run.time, run.force, color=ASKED, dashes=(5, 3.5), label="asked", zorder=3)
    lower.plot(run.time, run.applied_force, color=APPLIED, label="applied")
    lower.set_ylabel("force, N")
    lower.set_xlabel("time, s")
    lower.legend(frameon=False, ncols=2)
    loop = figure.add_subplot(grid[:, 1])
    loop.plot(1e3 * run.position, run.applied_force, color=APPLIED)
    loop.set_xlabel("position, mm")
    loop.set_ylabel("force applied, N")
    for axes in (upper, middle, lower, loop):
        axes.grid(color=GRID)
        axes.spines[["top", "right"]].set_visible(False)
    figure.suptitle(_caption(run.settings), fontsize=10)
    figure.savefig(path, dpi=110)


def _caption(settings: dict) -> str:
    units = settings.get("units", {})
    parameters = ", ".join(
        f"{k} {v}" if isinstance(v, str) else f"{k} {v:g} {units.get(k, '')}".rstrip()
        for k, v in settings.get("parameters", {}).items()
    )
    estimator = settings.get("estimator")
    words = [settings.get("environment", ""), parameters, f"hand: {settings.get('hand')}"]
    words += [
        f"{settings.get('rate_Hz', 0):g} Hz",
        f"delay {1e3 * settings.get('delay_s', 0):g} ms",
        str(estimator),
    ]
    return " · ".join(w for w in words if w)
