"""A simulated student moves the handle, holds it at marks, releases it, and hangs weights on it."""

import math

from hapkit_studio.analysis.calibrate.calibration import Calibration
from hapkit_studio.devices.board_runner import BoardRunner
from tests.devices.paddle_kit import PaddleKit

MARKS = (0.0, -0.02, 0.02, 0.0)


# functions for tests that run the kit without a calibration


def lead(kit, place, seconds=0.2):
    """Move the handle to a position in m and hold it there."""
    start, begin = kit.x, kit.time
    kit.student = lambda k: setattr(k, "hand", start + (place - start) * min((k.time - begin) / seconds, 1.0))


def swing(kit, seconds=5.0, reach=0.048):
    """Move the handle from the left end to the right end and back, twice in ``seconds``."""
    begin = kit.time
    turn = 4.0 * math.pi / seconds
    kit.student = lambda k: setattr(k, "hand", -reach * math.cos(turn * (k.time - begin)))


def hang(kit, mass):
    """Hold the handle with a mass in kg on it, and release it 1.2 s after the motor has started to push."""
    kit.weight, kit.hand, begin = -9.81 * mass, 0.0, []

    def lets_go(k):
        if k.forces and k.forces[-1] != 0.0 and not begin:
            begin.append(k.time)
        k.hand = None if begin and k.time > begin[0] + 1.2 else 0.0

    kit.student = lets_go


def leave(kit):
    """Release the handle."""
    kit.student, kit.hand = (lambda k: None), None


# functions for tests with a calibration, whose runner runs the kit


def session(kit: PaddleKit) -> Calibration:
    """Return a calibration on a kit, with its runner open."""
    runner = BoardRunner(kit)
    runner.open()
    return Calibration(runner)


def end_to_end(kit, work: Calibration, seconds=5.0, reach=0.048):
    """Move the handle from the left end to the right end and back, twice; return the result."""
    walk(kit, work, -reach, 0.4)
    swing(kit, seconds, reach)
    return work.check_sensor(work.runner.record(seconds))


def walk(kit, work, place, seconds=0.2):
    """Move the handle to a position in m and hold it there."""
    lead(kit, place, seconds)
    work.runner.record(seconds + 0.01)


def hold_at_marks(kit, work, slip_at=None):
    """Hold the handle at the marks; return the scale.

    The cable slips by 200 counts before the mark with the index ``slip_at``.
    """
    work.forget_marks()
    for number, place in enumerate(MARKS):
        if number == slip_at:
            kit.slipped += 200.0
        walk(kit, work, place)
        work.take_mark(place)
    let_go(kit, work)
    return work.measure_scale()


def let_go(kit, work):
    """Move the handle to the middle and release it."""
    kit.weight = 0.0
    walk(kit, work, 0.0)
    leave(kit)
    kit.v = 0.0


def weigh(kit, work, masses=(0.0, 0.05, 0.1)):
    """Hang masses in kg on the handle in turn; return the strength."""
    for mass in masses:
        let_go(kit, work)
        hang(kit, mass)
        work.carry(mass)
    let_go(kit, work)
    return work.use_weights()


def whole(kit, seconds=6.0):
    """Run every step, with a sweep of ``seconds`` seconds; return the calibration."""
    work = session(kit)
    end_to_end(kit, work)
    hold_at_marks(kit, work)
    work.use_scale()
    work.try_direction()
    if not work.direction.agrees:
        let_go(kit, work)
        work.find_dead_band()
    weigh(kit, work)
    work.sweep(seconds)
    work.store("test")
    return work
