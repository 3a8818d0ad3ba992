"""Plays the student: moves the handle from end to end, holds it at marks, lets go, hangs weights on it."""

import math

from hapkit_studio.analysis.calibrate.calibration import Calibration
from hapkit_studio.devices.board_runner import BoardRunner
from tests.devices.paddle_kit import PaddleKit

MARKS = (0.0, -0.02, 0.02, 0.0)


def session(kit: PaddleKit) -> Calibration:
    """Return a calibration on a kit, its runner open."""
    runner = BoardRunner(kit)
    runner.open()
    return Calibration(runner)


def end_to_end(kit, work: Calibration, seconds=5.0, reach=0.048):
    """Move the handle from the left end to the right end and back, twice; return the result."""
    walk(kit, work, -reach, 0.4)
    begin = kit.time

    def moving(k):
        k.hand = -reach * math.cos(2.0 * math.pi * 2.0 * (k.time - begin) / seconds)

    kit.student = moving
    track = work.runner.record(seconds)
    kit.student = lambda k: None
    return work.check_sensor(track)


def walk(kit, work, place, seconds=0.2):
    """Lead the handle to a place in m, and hold it there."""
    begin, start = kit.time, kit.x

    def moving(k):
        k.hand = start + (place - start) * min((k.time - begin) / seconds, 1.0)

    kit.student = moving
    work.runner.record(seconds + 0.01)
    kit.student, kit.hand = (lambda k: None), place


def hold_at_marks(kit, work, marks=MARKS, off=0.0, slip_at=None):
    """Hold the handle at marks; slip_at: the cable slips 200 counts before that one. Return the scale."""
    work.forget_marks()
    for number, place in enumerate(marks):
        if number == slip_at:
            kit.slipped += 200.0
        walk(kit, work, place + off)
        work.take_mark(place)
    let_go(kit, work)
    return work.measure_scale()


def let_go(kit, work):
    """Lead the handle to the middle and leave it there, free."""
    kit.weight = 0.0
    walk(kit, work, 0.0)
    kit.hand, kit.v = None, 0.0


def weigh(kit, work, masses=(0.0, 0.05, 0.1)):
    """Hang masses in kg at the handle, one after the other; return the strength."""
    for mass in masses:
        let_go(kit, work)
        kit.weight, kit.hand = -9.81 * mass, 0.0
        begin = kit.time

        def lets_go(k, begin=begin):
            k.hand = 0.0 if k.time < begin + 1.2 else None

        kit.student = lets_go
        work.carry(mass)
        kit.student = lambda k: None
    let_go(kit, work)
    return work.use_weights()


def whole(kit, seconds=6.0):
    """Run every step, the sweep for some s; return the calibration."""
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
