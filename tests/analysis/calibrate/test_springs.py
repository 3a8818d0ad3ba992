"""Two known springs determine the motor's strength and its interval; springs are then rendered correctly."""

import itertools
from dataclasses import replace
from unittest.mock import Mock

import numpy as np
import pytest

from hapkit_studio.analysis.calibrate import motions
from hapkit_studio.analysis.calibrate.motor import felt_stiffness, judge_pulses, strength_from_springs
from hapkit_studio.analysis.calibrate.paddle import recording_of
from hapkit_studio.analysis.identify import identify
from hapkit_studio.devices.board_runner import LateError, Limits, Track, motor_force
from hapkit_studio.devices.profiles import default, full_force
from hapkit_studio.errors import ParameterError
from tests.analysis.calibrate import student
from tests.devices.paddle_kit import PaddleKit

SPRINGS = (100.0, 300.0)
BOARD = default().board
WEAK = {"torque": 0.9 * BOARD.motor_constant}
KNOWN = 0.01
# the motor's direction is given, so that these tests need springs only
FOUND = judge_pulses([(0.3, 0.01), (-0.3, -0.01)])


def measured(kit, work, springs=SPRINGS, beside=0.0):
    """Attach springs in N/m to the handle in turn, each parallel to ``beside`` N/m; return the strength."""
    for stiffness in springs:
        student.let_go(kit, work)
        kit.spring = stiffness + beside
        work.pull(stiffness)
    kit.spring = beside
    student.let_go(kit, work)
    return work.use_springs(KNOWN)


def rendered(kit, work, stiffness=150.0):
    """Render a spring in N/m to a hand; return the identified and the true stiffness."""
    student.swing(kit, seconds=4.0, reach=0.008)
    track = work.runner.run(lambda t, x, v: -stiffness * x, 4.0, Limits(3.0))
    shown_stiffness = (
        identify(recording_of(track, work.board), terms=("stiffness",)).rendered["stiffness"].value
    )
    truly = [kit.motor_force(int(duty)) for duty in track.pwm]
    felt = -np.polyfit(track.position, truly, 1)[0]
    student.let_go(kit, work)
    return shown_stiffness, felt


@pytest.mark.slow
def test_a_motor_at_90_percent_is_corrected_and_springs_are_rendered_as_set():
    kit = PaddleKit(**WEAK)
    work = student.session(kit)
    stiffness, felt = rendered(kit, work)
    assert stiffness == pytest.approx(150.0, rel=0.01)
    assert felt == pytest.approx(135.0, rel=0.01)
    found = measured(kit, work)
    assert found.ratio == pytest.approx(0.90, rel=0.01)
    assert abs(found.ratio - 0.90) < found.half < 0.03
    assert "The motor gives 90 ± 2 % of the force that was set" in found.text
    stiffness, felt = rendered(kit, work)
    assert stiffness == pytest.approx(150.0, rel=0.01)
    assert felt == pytest.approx(150.0, rel=0.01)
    work.store("test")
    assert kit.stored.motor_constant == pytest.approx(0.9 * BOARD.motor_constant, rel=0.01)


STRONG = {"torque": 1.4 * BOARD.motor_constant}


@pytest.mark.slow
@pytest.mark.parametrize(
    "truth", [{**WEAK, "coulomb": 0.25}, {**STRONG, "noise": 1.0}], ids=["rubs", "noisy"]
)
def test_friction_and_parallel_stiffness_cancel(truth):
    """Gravity and the cable act like a spring of 12 N/m in parallel with the attached springs."""
    kit = PaddleKit(**truth)
    found = measured(kit, student.session(kit), beside=12.0)
    assert found.ratio == pytest.approx(kit.torque / BOARD.motor_constant, rel=0.01)


class StickingKit(PaddleKit):
    """A handle whose static friction is twice its kinetic friction."""

    def _glide(self, dt):
        sliding = self.coulomb
        self.coulomb *= 2.0 if self.v == 0.0 else 1.0
        super()._glide(dt)
        self.coulomb = sliding


@pytest.mark.slow
def test_shaking_frees_a_stuck_handle():
    kit = StickingKit(coulomb=0.15, **WEAK)
    work = student.session(kit)
    work.direction = FOUND
    assert measured(kit, work).ratio == pytest.approx(0.90, rel=0.01)


def test_after_a_late_computer_the_pull_is_repeated_twice(monkeypatch):
    late = LateError()
    monkeypatch.setattr(motions, "pull", Mock(side_effect=[late, late, pulled(100.0), late, late, late]))
    work = student.session(PaddleKit())
    work.direction = FOUND
    assert work.pull(100.0) == pytest.approx(100.0, rel=0.01)
    with pytest.raises(LateError):
        work.pull(100.0)


@pytest.mark.slow
def test_later_marks_correct_the_result_of_springs():
    """A pulley radius that is 4 % too large makes the lengths wrong, and with them the force from springs."""
    pulley = 1.04 * BOARD.pulley_radius
    kit = PaddleKit(replace(BOARD, pulley_radius=pulley, quantum=1.04 * BOARD.quantum), **WEAK)
    work = student.session(kit)
    measured(kit, work)
    assert abs(full_force(work.board) / kit.full - 1.0) > 0.03
    student.hold_at_marks(kit, work)
    work.use_scale()
    assert full_force(work.board) == pytest.approx(kit.full, rel=0.01)
    assert work.strength.half / work.strength.ratio >= work.scale.quantum_half / work.scale.quantum


# The pulls below are computed for many kits at once. In these pulls, friction may hold the handle.

PERIOD = 1e-3


def pulls(random, nominal, stiffness, strength, coulomb, grows, noise):
    """Return one track per element of the arrays (n,).

    ``stiffness`` is in N/m; ``strength`` is the true force divided by the commanded force. Friction is
    ``coulomb`` in N, varied at random for each rise and fall of the force, and increases by ``grows`` N/m.
    ``noise`` is in counts.
    """
    time = np.arange(0.0, motions.PULLS * motions.PULL_PERIOD, PERIOD)
    rise = 1.0 - np.abs(2.0 * (time / motions.PULL_PERIOD % 1.0) - 1.0)
    force = 0.4 + (min(0.016 * nominal, 1.6) - 0.4) * rise
    duty = np.round(255.0 * np.sqrt(force / full_force(BOARD))).astype(int)
    leg = (2.0 * time / motions.PULL_PERIOD).astype(int)
    friction = coulomb * np.abs(1.0 + 0.2 * random.standard_normal((leg[-1] + 1, len(coulomb))))
    place, places = np.zeros(len(stiffness)), []
    for force, drag in zip(motor_force(BOARD, duty), friction[leg], strict=True):
        now = drag + grows * place
        place = np.clip(place, (strength * force - now) / stiffness, (strength * force + now) / stiffness)
        places.append(place)
    counts = np.array(places) / BOARD.quantum + noise * random.standard_normal((len(time), len(coulomb)))
    return [track(time, np.floor(count).astype(int), duty) for count in counts.T]


def track(time, count, duty):
    none = np.zeros(len(time), int)
    return Track(time, count, count, duty, none, none, none, 0.0 * time, BOARD)


@pytest.mark.slow
@pytest.mark.parametrize("known", [0.03, 0.0])
def test_intervals_contain_the_truth_in_95_percent_of_many_kits(known):
    random, n = np.random.default_rng(7), 150
    strength, beside = random.uniform(0.7, 1.4, n), random.uniform(-5.0, 15.0, n)
    coulomb, grows = random.uniform(0.02, 0.08, n), random.uniform(-1.0, 3.0, n)
    noise = random.uniform(0.0, 2.0, n)
    tracks = []
    for nominal in SPRINGS:
        true = nominal * (1.0 + known / 1.96 * random.standard_normal(n))
        tracks.append(pulls(random, nominal, true + beside, strength, coulomb, grows, noise))
    found = [
        strength_from_springs(list(zip(SPRINGS, two, strict=True)), BOARD, known, 0.0)
        for two in zip(*tracks, strict=True)
    ]
    errors = np.array([f.ratio for f in found]) / strength - 1.0
    halves = np.array([f.half / f.ratio for f in found])
    assert (np.abs(errors) <= halves).mean() >= 0.93
    # the interval is hardly wider than the uncertainty of the two springs requires
    least = known * np.hypot(*SPRINGS) / np.ptp(SPRINGS)
    assert np.median(halves) == pytest.approx(least, abs=0.01)
    assert abs(errors.mean()) < 3.5 * errors.std() / n**0.5 + 0.002


# invalid measurements are rejected


@pytest.mark.parametrize("springs", [(100.0,), (100.0, 100.0), (100.0, 199.0), (39.0, 100.0)])
def test_unsuitable_springs_are_rejected(springs):
    with pytest.raises(ParameterError, match=r"Two springs|40 or more"):
        strength_from_springs([(stiffness, None) for stiffness in springs], BOARD)


def pulled(stiffness, grows=0.0):
    """Return the track of one spring in N/m, pulled by a motor of nominal strength."""
    random, alone = np.random.default_rng(1), np.ones(1)
    numbers = stiffness * alone, alone, 0.05 * alone, grows * alone, 0.0 * alone
    return pulls(random, 100.0, *numbers)[0]


def test_position_dependent_friction_is_not_mistaken_for_stiffness():
    found, _ = felt_stiffness(pulled(100.0, grows=3.0), BOARD)
    assert found == pytest.approx(100.0, rel=0.005)


def with_gap(track, gap, at):
    """Return a track whose handle moves ``gap`` m without force, ``at`` m from its start."""
    count = track.count + np.where(track.count > at / BOARD.quantum, round(gap / BOARD.quantum), 0)
    return replace(track, count=count)


def test_curvature_widens_the_interval():
    straight = pulled(100.0)
    for at, gap in itertools.product((6e-3, 8e-3, 12e-3), (0.05e-3, 0.1e-3)):
        found, half = felt_stiffness(with_gap(straight, gap, at), BOARD)
        assert abs(found - 100.0) <= half, (at, gap)


def test_a_slack_or_too_stiff_spring_is_rejected():
    assert felt_stiffness(pulled(100.0), BOARD)[0] == pytest.approx(100.0, rel=0.01)
    with pytest.raises(ParameterError, match="slack"):
        felt_stiffness(with_gap(pulled(100.0), 1e-3, 10e-3), BOARD)
    with pytest.raises(ParameterError, match="softer"):
        felt_stiffness(pulled(5e4), BOARD)
