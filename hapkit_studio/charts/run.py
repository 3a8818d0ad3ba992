"""A run: position, velocity and force over time, and force over position."""

from pathlib import Path
from typing import Any

from hapkit_studio.charts.style import Colors, legend, save, style_axes, unbroken

_SIZE = (792, 450)


def run_figure(run: Any, path: str | Path) -> None:
    """Write a Run's position, velocity and force over time and its force over position."""
    save(lambda figure, c: draw(figure, c, run), path, _SIZE, caption=_caption(run.settings))


def draw(figure: Any, c: Colors, run: Any) -> None:
    """Draw three quantities below one another, force over position beside them."""
    grid = figure.add_gridspec(3, 2, width_ratios=(3, 2))
    upper, middle, lower = (figure.add_subplot(grid[i, 0]) for i in range(3))
    upper.plot(run.time, 1e3 * run.position, color=c.position)
    middle.plot(run.time, 1e3 * run.velocity, color=c.velocity)
    lower.plot(run.time, run.force, color=c.asked, dashes=(5, 3.5), label="asked", zorder=3)
    lower.plot(run.time, run.applied_force, color=c.applied, label="applied")
    loop = figure.add_subplot(grid[:, 1])
    loop.plot(1e3 * run.position, run.applied_force, color=c.applied)
    style_axes(upper, c, "", "position, mm")
    style_axes(middle, c, "", "velocity, mm/s")
    style_axes(lower, c, "time, s", "force, N")
    style_axes(loop, c, "position, mm", "force applied, N")
    legend(lower, c)


def _caption(settings: dict) -> str:
    units = settings.get("units", {})
    parameters = ", ".join(
        f"{k} {v}" if isinstance(v, str) else f"{k} {v:,g} {units.get(k, '')}".rstrip()
        for k, v in settings.get("parameters", {}).items()
    )
    words = [settings.get("environment", ""), parameters, f"hand: {settings.get('hand')}"]
    words += [f"{settings.get('rate_Hz', 0):,g} Hz", f"delay {1e3 * settings.get('delay_s', 0):g} ms"]
    words += [str(settings.get("estimator"))]
    return unbroken([w for w in words if w])
