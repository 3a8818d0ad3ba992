"""The calibration finds the fault of a kit, and corrects the kit's position and force."""

from dataclasses import replace

import numpy as np
import pytest

from hapkit_studio.analysis.calibrate import motor, paddle
from hapkit_studio.analysis.calibrate.motor import judge_pulses
from hapkit_studio.devices.board_runner import AbortedError
from hapkit_studio.devices.profiles import default, full_force
from hapkit_studio.errors import ParameterError
from hapkit_studio.protocol.messages import Force, Origin
from tests.analysis.calibrate import student
from tests.devices.paddle_kit import PaddleKit
from tests.wide import wide

DIAMETER = replace(default().board, pulley_radius=0.010, quantum=2.0 * default().board.quantum)
KITS = {
    "magnet turned": {"sense": -1, "direction": -1, "magnet": 777.0},
    "diameter": {"board": DIAMETER, "torque": 0.7 * 0.0183},
    "great dead band": {"dead": 60},
    "range": {"counts": 902, "torque": 1.3 * 0.0183},
}


def place_error(kit, work, place=0.03):
    """Return the relative error of the position that the board measures at a place in m."""
    student.walk(kit, work, place)
    return kit.position / place - 1.0


def force_errors(kit, forces=(0.4, 0.8, 1.5, -1.0)):
    """Return the relative errors (n,) of the motor's true force for commanded forces in N."""
    errors = []
    for force in forces:
        kit.send_messages(Force(1, 0, force))
        errors.append(kit.motor_force(kit.next_pwm) / force - 1.0)
    return np.array(errors)


@pytest.mark.slow
@pytest.mark.parametrize("name", wide(KITS, lambda name: name == "magnet turned"))
def test_each_fault_is_corrected(name):
    kit = PaddleKit(**KITS[name])
    work = student.whole(kit)
    assert abs(place_error(kit, work)) < 0.01
    assert np.abs(force_errors(kit)).max() < 0.05
    assert work.direction.agrees
    part = work.sweep_result.part
    assert part["mass"].holds(kit.mass)
    # the intervals include the uncertainty of force and length scale
    assert part["mass"].half >= 0.01 * part["mass"].value
    student.walk(kit, work, 0.004)
    kit.restart()
    assert kit.stored.label == "test"
    assert work.runner.settings.origin == Origin.STORED
    assert abs(place_error(kit, work)) < 0.01


def test_missing_supply_is_found_and_ends_the_calibration():
    kit = PaddleKit(supply=0.0)
    work = student.session(kit)
    assert work.try_direction().key == "no motion"
    assert max(np.abs(kit.forces)) <= 0.3
    with pytest.raises(AbortedError, match="step Direction"):
        work.sweep()
    with pytest.raises(AbortedError, match="step Direction"):
        work.carry(0.05)
    with pytest.raises(AbortedError, match="supply"):
        work.find_dead_band()


def test_undo_restores_and_saves_the_boards_settings():
    kit = PaddleKit(sense=-1, direction=-1)
    before = kit.settings_now
    work = student.session(kit)
    student.hold_at_marks(kit, work)
    work.use_scale()
    work.try_direction()
    work.store("test")
    assert kit.settings_now != before
    work.undo()
    assert kit.settings_now == before
    assert kit.stored == before


def test_a_kitchen_scale_measures_the_strength():
    kit = PaddleKit(torque=0.7 * 0.0183)
    work = student.session(kit)
    student.let_go(kit, work)
    work.try_direction()
    student.let_go(kit, work)
    kit.hand = 0.0
    track = work.push_on_scale(1.0, 2.0, lambda: False)
    pushed = kit.motor_force(int(track.pwm[-1]))
    found = work.use_reading(pushed / 9.81)
    assert found.ratio == pytest.approx(0.7, rel=0.02)
    for reading in (0.0, 5.0):
        with pytest.raises(ParameterError):
            work.use_reading(reading)


# these kits are hard to measure, but the intervals must still contain the truth

HARD_KITS = {
    "small dead band": {"dead": 25, "noise": 0.7, "coulomb": 0.10, "mass": 0.057, "torque": 0.0176},
    "sticks": {"noise": 0.4, "coulomb": 0.23, "viscous": 0.77, "mass": 0.037, "torque": 0.0174},
}


@pytest.mark.slow
@pytest.mark.parametrize("name", HARD_KITS)
def test_intervals_contain_the_truth_for_difficult_kits(name):
    kit = PaddleKit(**HARD_KITS[name])
    work = student.whole(kit)
    assert work.board.dead_band == pytest.approx(kit.dead, abs=paddle.BAND_UNCERTAINTY)
    found = work.strength
    assert full_force(work.board) == pytest.approx(kit.full, rel=found.half / found.ratio)
    assert found.half < 0.05 * found.ratio
    truth = {"mass": kit.mass, "viscous": kit.viscous, "coulomb": kit.coulomb}
    part = work.sweep_result.part
    assert [key for key, value in truth.items() if not part[key].holds(value)] == []


def test_a_weight_on_a_sticking_handle_has_a_wide_interval():
    kit = PaddleKit(coulomb=0.5)
    work = student.session(kit)
    work.direction = judge_pulses([(0.3, 0.01), (-0.3, -0.01)])
    student.let_go(kit, work)
    student.hang(kit, 0.05)
    work.carry(0.05)
    force, half = motor.carrying_force(work.carried[-1][1], work.board)
    assert half > 0.1
    assert abs(force - 9.81 * 0.05) <= kit.coulomb


def test_a_weight_that_is_too_heavy_for_the_motor_is_not_measured():
    kit = PaddleKit(DIAMETER, pulley=0.010, torque=0.74 * 0.0183, coulomb=0.174)
    work = student.session(kit)
    work.direction = judge_pulses([(0.3, 0.01), (-0.3, -0.01)])
    with pytest.raises(ParameterError, match="Use less mass"):
        student.weigh(kit, work, (0.1,))
    assert work.carried == []
    student.weigh(kit, work, (0.0, 0.05))
    assert work.strength.ratio == pytest.approx(0.74, rel=work.strength.half / work.strength.ratio)


def test_friction_beyond_the_strongest_pulse_still_permits_finding_the_direction():
    kit = PaddleKit(coulomb=0.30, direction=-1)
    work = student.session(kit)
    assert work.try_direction().key == "no motion"
    assert max(np.abs(kit.forces)) <= 0.3
    student.let_go(kit, work)
    found = work.find_dead_band()
    assert found.good
    assert "friction holds the handle up to 0.3" in found.text
    assert work.direction.agrees
    assert (work.board.direction, work.board.dead_band) == (-1, 0)
