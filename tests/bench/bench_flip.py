"""Position errors of two algorithms that count the jumps ("flips") of the sensor's saw-tooth signal.

One is the firmware's, the other the class template's. The speed at which each misses a flip is measured, too.
"""

import shutil
import sys

from tests.bench.frame import Row
from tests.firmware import flips

NAME, ORDER = "flip", 45
MAGNETS = range(0, flips.COUNTS, 37)  # positions of the magnet, as counts at the middle of the travel


def worst_millimetres(tracker, rate: float) -> float:
    """Return the largest error in mm over a sine of 40 mm and 2 Hz, for the worst position of the magnet."""
    counts = max(flips.worst_error(tracker, flips.sine(rate, magnet)) for magnet in MAGNETS)
    return 1e3 * flips.QUANTUM * counts


def error_row(rate: int) -> Row:
    """Return the row of the error at a rate in Hz."""
    found, reference = (worst_millimetres(tracker, rate) for tracker in (flips.ours, flips.template))
    count = 1e3 * flips.QUANTUM
    what = f"flip tracker: largest error, 40 mm, 2 Hz, {rate:,} Hz"
    return Row(what, found, "mm", "class template", reference, target="≤ 0.021 mm", ok=found <= count)


def speed_row(rate: float) -> Row:
    """Return the row of the lowest handle speed at which flips are lost."""
    metres = flips.QUANTUM * rate
    found, reference = (metres * flips.fastest(tracker) for tracker in (flips.ours, flips.template))
    limit = metres * flips.LIMIT
    what = f"flip tracker: loses flips from, {rate:,.0f} Hz"
    target = f"{limit:.2f} m/s ± 1 %"
    ok = abs(found / limit - 1.0) <= 0.01
    return Row(what, found, "m/s", "class template", reference, found / reference, target, ok)


def run() -> list[Row]:
    """Return the errors at three rates and the speed at one; no rows without g++."""
    if shutil.which("g++") is None:
        print("  no g++ to build the firmware's tracker with", file=sys.stderr)
        return []
    return [*(error_row(rate) for rate in (1000, 500, 230)), speed_row(1000.0)]
