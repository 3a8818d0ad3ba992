"""What compiled work costs: the shortest of several turns, all candidates in the same turns.

What counts is the thread's own time on its core, where its clock is fine enough: another program that takes
the core costs nothing. One that shares caches or the core's other half makes work longer, by up to half,
never shorter, so the shortest turn is the nearest to the work itself, and turns go on until every candidate
was as short several times. A turn goes once round all candidates, each time from the next one on, so that a
slow moment meets them all alike. Work should last a tenth of a millisecond: calling it takes up to 5 µs.
"""

import time
from collections.abc import Callable, Sequence

Work = Callable[[], object]
Prepare = Callable[[], Work]
Clock = Callable[[], int]

LEAST_TURNS, MOST_TURNS = 40, 400
# The shortest is believed once so many turns came as near to it as this, or after so many ns of work.
HITS, NEAR = 8, 1.03
ENOUGH_NS = 500_000_000
# A clock is fine enough that moves on within so many ns, and by less.
_FINE_NS, _LOOKS = 10_000, 5


def clock() -> Clock:
    """Return the thread's own time in ns, the wall's where that moves on in long steps, as on Windows."""
    return time.thread_time_ns if any(_fine() for _ in range(_LOOKS)) else time.perf_counter_ns


def _fine() -> bool:
    begin, until = time.thread_time_ns(), time.perf_counter_ns() + _FINE_NS
    while time.perf_counter_ns() < until:
        if time.thread_time_ns() != begin:
            return time.thread_time_ns() - begin < _FINE_NS
    return False


def shortest(prepares: Sequence[Prepare], now: Clock | None = None) -> list[float]:
    """Return the ns of each candidate's work; a candidate makes its work ready outside of the time."""
    now = now or clock()
    for prepare in prepares:
        prepare()()
    turns: list[list[float]] = [[] for _ in prepares]
    spent = 0.0
    for turn in range(MOST_TURNS):
        for place in range(len(prepares)):
            candidate = (turn + place) % len(prepares)
            lasted = _once(prepares[candidate](), now)
            turns[candidate].append(lasted)
            spent += lasted
        if turn + 1 >= LEAST_TURNS and (spent > ENOUGH_NS or all(map(_believed, turns))):
            break
    return [min(found) for found in turns]


def _believed(found: list[float]) -> bool:
    limit = NEAR * min(found)
    return sum(lasted <= limit for lasted in found) >= HITS


def _once(work: Work, now: Clock) -> float:
    begin = now()
    work()
    return float(now() - begin)
