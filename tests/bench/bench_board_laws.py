"""Every law on the board at its highest rate: jitter and processor load, as counted in simavr."""

import sys
import tempfile
from pathlib import Path

import numpy as np

from hapkit_studio import environments
from hapkit_studio.haptics.board_plan import BoardPlanner, PlanRequest
from hapkit_studio.laws.machine import ARENA
from hapkit_studio.protocol.messages import Estimator, Telemetry
from tests.bench.frame import Row, without_board
from tests.firmware.board_runs import render
from tests.firmware.vb import QUANTUM

NAME, ORDER = "board_laws", 42
SECONDS = 0.4
MOST = 0.80  # limit of the processor load of a law with telemetry, as a fraction
SWEEP = ("0.02 hand 0.02 300 4 0.05 0.2", "0.3 hand -0.03 300 4 0.05 0.1", "0.45 hand 0.03 300 4 0.05 0.05")
# the most expensive choices, and those with a promised rate; other laws have their defaults
CHOICES: dict[str, tuple[str, tuple[str, ...]]] = {
    "friction": ("model", ("karnopp", "tether", "lugre")),
    "texture": ("kind", ("bands", "grating", "sandpaper")),
    "bump_valley": ("profile", ("gaussian", "cosine")),
    "mass_spring_damper": ("integrator", ("semi_implicit", "verlet", "exact", "rk4")),
    "puck": ("integrator", ("semi_implicit", "verlet", "exact", "rk4")),
}


def run() -> list[Row]:
    """Return three rows per law and choice, or none without the virtual board."""
    found: list[Row] = []
    if without_board():
        return found
    for key in environments.discover():
        name, options = CHOICES.get(key, ("", ("",)))
        for option in options:
            found += _rows(key, {name: option} if name else {})
    return found


def jitter(shown: list[Telemetry], rate: int) -> float:
    """Return the largest difference in µs between the samples' intervals by time and by tick count."""
    ticks = np.diff([row.seq for row in shown]) & 0xFFFF
    apart = np.diff([row.time_us for row in shown])
    return float(np.abs(apart - ticks * 1e6 / rate).max())


def _rows(key: str, given: dict[str, str]) -> list[Row]:
    """Return the rows of a law with these choices at its highest rate, while the handle moves."""
    what, environment = f"{', '.join([key, *given.values()])} on the board", environments.named(key)
    way = BoardPlanner(ARENA).plan(PlanRequest(environment, environment.values(given), "kalman", QUANTUM))
    if isinstance(way, str):
        print(f"  {what}: {way}", file=sys.stderr)
        return []
    filter = Estimator(way.estimator), way.first, way.second
    with tempfile.TemporaryDirectory() as folder:
        run = render(Path(folder), way.program, way.rate, SECONDS, SWEEP, filter)
    what, off = f"{what} at {way.rate:,.0f} Hz", run.summary["interrupts_off_cycles"]
    skipped = f" ({run.skipped} ticks skipped)" if run.skipped else ""
    reached = run.share <= MOST and not run.skipped
    share, most = 100.0 * run.share, f"≤ {100 * MOST:.0f} %"
    return [
        Row(f"{what}: processor{skipped}", share, "%", target=most, ok=reached),
        Row(f"{what}: jitter of the sampling", jitter(run.telemetry, way.rate), "µs"),
        Row(f"{what}: interrupts off at most", off, "cycles", target="≤ 250", ok=off <= 250),
    ]
