"""A sweep gives mass, damping and dry friction: the intervals contain the truth, and a dead band is found."""

from dataclasses import replace

import numpy as np
import pytest

from hapkit_studio.analysis.calibrate import motions, paddle
from hapkit_studio.analysis.identify.handle import NAMES
from hapkit_studio.devices.board_runner import BoardRunner, motor_force
from hapkit_studio.devices.profiles import default
from hapkit_studio.protocol.messages import MotorMap
from tests.devices.paddle_kit import PaddleKit

SEEDS = range(5)


def kit_of(seed):
    """Return a kit with random paddle properties; seed 0 gives the usual ones."""
    rng = np.random.default_rng(seed)
    if seed == 0:
        return PaddleKit()
    low, high = (0.02, 0.05, 0.01), (0.15, 1.2, 0.35)
    mass, viscous, coulomb = np.exp(rng.uniform(np.log(low), np.log(high)))
    return PaddleKit(mass=mass, viscous=viscous, coulomb=coulomb, magnet=rng.uniform(0.0, 900.0))


def swept(kit):
    runner = BoardRunner(kit)
    runner.open()
    return paddle.sweep(runner, 6.0)


@pytest.mark.slow
def test_intervals_contain_the_truth_in_nine_of_ten_cases():
    held = []
    for seed in SEEDS:
        kit = kit_of(seed)
        part = swept(kit).part
        truth = {"mass": kit.mass, "viscous": kit.viscous, "coulomb": kit.coulomb}
        held += [e.holds(truth[e.key]) for e in part.estimates]
        assert part["mass"].half < 0.05 * kit.mass
    assert len(held) == 3 * len(SEEDS)
    assert sum(held) >= 0.9 * len(held)


def test_uncertain_scales_make_estimates_undetermined():
    """Mass and damping are determined if the length is uncertain by 49 %, and undetermined at 51 %."""
    part = swept(PaddleKit()).part
    for length, determined in ((0.49, True), (0.51, False)):
        wider = paddle.widened(part, 0.0, length)
        assert [wider[key].determined for key in NAMES] == [determined, determined, True]
        assert set(paddle.changes(wider)) == (set(NAMES) if determined else {"coulomb"})
        assert ("Take the marks of the step Zero and scale again" in wider["mass"].advice) != determined
    assert "Do the step Strength again" in paddle.widened(part, 1.01, 0.0)["coulomb"].advice


@pytest.mark.slow
def test_a_dead_band_is_fitted_and_a_false_one_is_removed():
    assert swept(PaddleKit(dead=40)).board.dead_band == pytest.approx(40, abs=3)
    assert swept(PaddleKit(replace(default().board, dead_band=40))).board.dead_band <= 3


@pytest.mark.parametrize("motor_map", list(MotorMap))
def test_the_motor_map_equals_the_firmwares(motor_map):
    table = (10, 30, 60, 100, 140, 180, 220, 255)
    board = replace(default().board, motor_map=motor_map, dead_band=55, table=table)
    full = 0.0183 * 0.074 / (0.090 * 0.005)
    half = {MotorMap.SQUARE: 0.25, MotorMap.LINEAR: 0.5, MotorMap.TABLE: 100.0 / 255.0}[motor_map]
    np.testing.assert_allclose(
        motor_force(board, np.array([0, 55, 155, 255, -255])), [0.0, 0.0, half * full, full, -full]
    )


def test_the_force_between_two_samples_is_weighted_by_the_time_of_its_change():
    runner = BoardRunner(PaddleKit())
    runner.open()
    track = runner.run(lambda t, x, v: 0.5 if 0.0105 < t < 0.0205 else 0.0, 0.03, motions.SWEEP_LIMITS)
    mean = paddle.mean_forces(track, track.settings)
    before = int(np.flatnonzero(track.pwm)[0]) - 1
    whole = mean[before + 2]
    assert whole == pytest.approx(0.5, rel=0.01)
    # the reply takes 0.4 ms of the period, so the new force acts for 0.6 ms
    assert mean[before] == pytest.approx(0.6 * whole, rel=1e-3)
