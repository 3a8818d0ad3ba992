"""Kits that are hard to measure: a noisy sensor, a dead band, friction that sticks. Intervals stay true."""

from dataclasses import replace

import pytest

from hapkit_studio.analysis.calibrate import motor, paddle
from hapkit_studio.analysis.calibrate.motor import judge_pulses
from hapkit_studio.devices.profiles import default, full_force
from hapkit_studio.errors import ParameterError
from tests.analysis.calibrate import student
from tests.devices.paddle_kit import PaddleKit

KITS = {
    "small dead band": {"dead": 25, "noise": 0.7, "coulomb": 0.10, "mass": 0.057, "torque": 0.0176},
    "great dead band": {"dead": 79, "noise": 1.1, "coulomb": 0.17, "mass": 0.090, "torque": 0.0218},
    "sticks": {"noise": 0.4, "coulomb": 0.23, "viscous": 0.77, "mass": 0.037, "torque": 0.0174},
}


@pytest.mark.parametrize("name", KITS)
def test_what_is_stated_holds_the_truth(name):
    kit = PaddleKit(**KITS[name])
    work = student.whole(kit)
    assert work.board.dead_band == pytest.approx(kit.dead, abs=paddle.BAND_SURE)
    found = work.strength
    assert full_force(work.board) == pytest.approx(kit.full, rel=found.half / found.ratio)
    assert found.half < 0.05 * found.ratio
    truth = {"mass": kit.mass, "viscous": kit.viscous, "coulomb": kit.coulomb}
    part = work.sweep_result.part
    assert [key for key, value in truth.items() if not part[key].holds(value)] == []


def test_a_weight_on_a_handle_that_sticks_says_how_little_it_knows():
    kit = PaddleKit(coulomb=0.5)
    work = student.session(kit)
    work.direction = judge_pulses([(0.3, 0.01), (-0.3, -0.01)])
    student.let_go(kit, work)
    kit.weight, kit.hand = -9.81 * 0.05, 0.0
    begin = kit.time
    kit.student = lambda k: setattr(k, "hand", 0.0 if k.time < begin + 1.2 else None)
    work.carry(0.05)
    force, half = motor.carrying_force(work.carried[-1][1], work.board)
    assert half > 0.1
    assert abs(force - 9.81 * 0.05) <= kit.coulomb


def test_a_weight_that_is_too_heavy_for_the_motor_is_not_measured():
    board = replace(default().board, pulley_radius=0.010, quantum=2.0 * default().board.quantum)
    kit = PaddleKit(board, pulley=0.010, torque=0.74 * 0.0183, coulomb=0.174)
    work = student.session(kit)
    work.direction = judge_pulses([(0.3, 0.01), (-0.3, -0.01)])
    with pytest.raises(ParameterError, match="Hang less on"):
        student.weigh(kit, work, (0.1,))
    assert work.carried == []
    student.weigh(kit, work, (0.0, 0.05))
    assert work.strength.ratio == pytest.approx(0.74, rel=work.strength.half / work.strength.ratio)


@pytest.mark.parametrize("direction", [1, -1])
def test_friction_beyond_the_strongest_pulse_still_tells_the_direction(direction):
    kit = PaddleKit(coulomb=0.30, direction=direction)
    work = student.session(kit)
    assert work.try_direction().key == "no motion"
    assert max(map(abs, kit.forces)) <= 0.3
    student.let_go(kit, work)
    found = work.find_dead_band()
    assert found.good
    assert "friction holds the handle up to 0.3" in found.words
    assert work.direction.agrees
    assert work.board.direction == direction
    assert work.board.dead_band == 0
