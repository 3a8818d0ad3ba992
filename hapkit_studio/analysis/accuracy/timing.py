"""What compiled work costs: the shortest of several turns, all candidates in the same turns.

Other programs share the machine and only ever make work longer, so the shortest turn is the nearest to the
work itself. A turn goes once round all candidates, so a slow moment meets them all alike. A candidate's work
should last a tenth of a millisecond at least: a call from Python takes up to 5 µs.
"""

import time
from collections.abc import Callable, Sequence

Work = Callable[[], object]
Prepare = Callable[[], Work]

LEAST_TURNS, MOST_TURNS = 20, 80
# Turns end once so many in a row made no candidate shorter by more than this.
QUIET_TURNS, SHORTER = 8, 0.01


def shortest(prepares: Sequence[Prepare]) -> list[float]:
    """Return the ns of each candidate's work; a candidate makes its work ready outside of the time."""
    for prepare in prepares:
        prepare()()
    best = [_once(prepare()) for prepare in prepares]
    turns = quiet = 1
    while turns < MOST_TURNS and (turns < LEAST_TURNS or quiet < QUIET_TURNS):
        spent = [_once(prepare()) for prepare in prepares]
        shorter = any(new < (1.0 - SHORTER) * old for new, old in zip(spent, best, strict=True))
        best = [min(pair) for pair in zip(spent, best, strict=True)]
        turns, quiet = turns + 1, 0 if shorter else quiet + 1
    return best


def _once(work: Work) -> float:
    begin = time.perf_counter_ns()
    work()
    return float(time.perf_counter_ns() - begin)
