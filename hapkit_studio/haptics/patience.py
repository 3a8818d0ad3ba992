"""When a headless run ends early: its law takes too long, or a person presses Ctrl+C.

Clocks cost more than a tick. So work is counted, ticks and passes of the law's loops, and the clock is read
once that comes to some tenths of a millisecond; where a pass takes long, to a few ticks.
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
"""s of processor time that a law may take in a headless run, or a period where that is longer: references run
at rates that no machine keeps."""
_WORK_OF_A_TICK, _LOOK_AFTER = 20, 50_000  # in passes of a law's loops
_PEEK = 2  # MSG_PEEK


@internal
def interrupted(r: LoopArrays) -> bool:
    """Return whether a signal has come that Python has not handled yet."""
    socket = r.tick.signals
    return socket >= 0 and clib.recv(socket, clib.word_pair(), 1, _PEEK) & 0xFFFFFFFF == 1


@compiled
def look(r: LoopArrays) -> None:
    """Tell the run to quit where its law takes too long, or a person wants it to."""
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
    """Forget when the clock was read last: other things have taken time since."""
    r.tick.clock_read_at = 0.0
    r.tick.work_done = r.tick.ticks_done = 0


@inlined
def goes_on(r: LoopArrays) -> bool:
    """Return whether to go on after one more call of the law."""
    t = r.tick
    t.ticks_done += 1
    t.work_done += _WORK_OF_A_TICK
    if r.fault[0] == 0:
        t.work_done += FUEL - r.fault[1]
    if t.work_done >= _LOOK_AFTER:
        look(r)
    return load_acquire(r.control.quit, 0) == 0


def check(r: LoopArrays, title: str) -> None:
    """Raise LawError where a run was ended as its law takes too long, KeyboardInterrupt for a person."""
    if r.control.fault[0] == arrays.SLOW_LAW:
        taken, limit = float(r.tick.fault_value), float(r.tick.fault_position)
        raise LawError(
            f"The law of {title} takes {on_screen(taken, 's', 3)} for one sample, the limit is "
            f"{on_screen(limit, 's', 3)}. {SIMPLIFY}"
        )
    if r.control.quit[0]:
        raise KeyboardInterrupt
