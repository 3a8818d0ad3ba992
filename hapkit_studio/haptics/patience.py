"""End a headless run early if its law takes too long or the user presses Ctrl+C.

Reading a clock takes longer than a tick. Therefore work is counted in ticks and in loop iterations of the
law, and the clock is read after some tenths of a millisecond of work, or after a few ticks if iterations are
slow.
"""

from hapkit_studio.dynamics.jit import compiled, inlined, internal
from hapkit_studio.errors import LawError
from hapkit_studio.formatting import on_screen
from hapkit_studio.haptics import arrays, clib, clock
from hapkit_studio.haptics.arrays import LoopArrays
from hapkit_studio.haptics.clib import load_acquire, store_release
from hapkit_studio.haptics.health import SIMPLIFY
from hapkit_studio.haptics.tick import note_law_time
from hapkit_studio.laws.native import INTERPRETED
from hapkit_studio.laws.translate import FUEL

LONGEST = 1e-3
"""s: longest processor time of a call of a law in a headless run, even if a period is shorter.

Reference runs use rates that no computer achieves.
"""
# work as a number of loop iterations of a law: the work of one tick, and the work between two clock readings
_WORK_OF_A_TICK, _CHECK_AFTER = 20, 50_000
_PEEK = 2


@internal
def interrupted(r: LoopArrays) -> bool:
    """Return True if a signal arrived that Python has not handled yet."""
    socket = r.tick.signals
    return socket >= 0 and clib.recv(socket, clib.word_pair(), 1, _PEEK) & 0xFFFFFFFF == 1


@compiled
def check_time(r: LoopArrays) -> None:
    """Cancel the run if its law takes too long or the user cancels it."""
    t = r.tick
    ticks, before = t.ticks_done, t.clock_read_at
    t.work_done = t.ticks_done = 0
    if INTERPRETED:
        return
    now = t.clock_read_at = clock.thread_time()
    limit = max(r.settings.period, LONGEST)
    if (before > 0.0 and note_law_time(r, now, now - before, limit, ticks)) or interrupted(r):
        store_release(r.control.quit, 0, 1)


@internal
def begin(r: LoopArrays) -> None:
    """Restart the measurement of the law's time, because other work was done in between."""
    r.tick.clock_read_at = 0.0
    r.tick.work_done = r.tick.ticks_done = 0


@inlined
def goes_on(r: LoopArrays) -> bool:
    """Return True if the run continues after one more call of the law."""
    t = r.tick
    t.ticks_done += 1
    t.work_done += _WORK_OF_A_TICK
    if r.fault[0] == 0:
        t.work_done += FUEL - r.fault[1]
    if t.work_done >= _CHECK_AFTER:
        check_time(r)
    return load_acquire(r.control.quit, 0) == 0


def check(r: LoopArrays, title: str) -> None:
    """Raise LawError if a slow law ended the run, and KeyboardInterrupt if the user ended it."""
    if r.control.fault[0] == arrays.SLOW_LAW:
        taken, limit = float(r.tick.fault_value), float(r.tick.fault_position)
        raise LawError(
            f"The law of {title} takes {on_screen(taken, 's', 3)} for one sample, the limit is "
            f"{on_screen(limit, 's', 3)}. {SIMPLIFY}"
        )
    if r.control.quit[0]:
        raise KeyboardInterrupt
