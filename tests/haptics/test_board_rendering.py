"""Rendering on a board: the handover to the board and back, the messages sent, and the resulting rows."""

import math
import re

import numpy as np
import pytest

from hapkit_studio import environments, lab
from hapkit_studio.devices.hapkit import HapkitBoard
from hapkit_studio.dynamics.estimators import design
from hapkit_studio.errors import ParameterError
from hapkit_studio.haptics import arrays, rows
from hapkit_studio.haptics.board_plan import BackgroundPlanner
from hapkit_studio.laws import board
from hapkit_studio.laws.machine import Refusal
from hapkit_studio.protocol.messages import (
    Alive,
    Board,
    BoardFlag,
    Force,
    HelloRequest,
    Law,
    Leave,
    Piece,
    Release,
    Stop,
    Tune,
)
from tests.devices.fake_board import ARENA, KIT
from tests.haptics.board_support import ZERO
from tests.haptics.support import CONSTANT

SPRING = {"stiffness": 100.0}
QUANTUM = KIT.quantum
FULL = KIT.motor_constant * KIT.sector_radius / (KIT.handle_radius * KIT.pulley_radius)


def flags(found):
    return [int(row[rows.FLAGS]) for row in found]


def test_the_force_fades_out_before_the_handover(rendering):
    setup = rendering(values=SPRING)
    setup.run(40)
    setup.count = ZERO + 100
    before = setup.run(2)[-1]
    assert before[rows.APPLIED_FORCE] == pytest.approx(-100.0 * 100 * QUANTUM)
    found = setup.go()
    shares = np.array([row[rows.APPLIED_FORCE] for row in found]) / before[rows.APPLIED_FORCE]
    fading = shares[shares > 0.0]
    np.testing.assert_allclose(-np.diff(fading), 1.0 / 30.0, atol=1e-9)
    messages = [type(m) for m in setup.board.received]
    last = max(i for i, kind in enumerate(messages) if kind is Force)
    assert messages.index(Piece) > messages.index(Law) > messages.index(Board) > 0
    assert last < messages.index(Law)
    assert setup.messages(Force)[-1].force == 0.0


def test_lost_pieces_of_a_long_law_are_repeated_and_a_board_that_lost_its_law_gets_it_again(rendering):
    """The law also arrives after a reset during the transfer, and after a piece with a wrong checksum."""
    setup = rendering(environment="mass_spring_damper")
    setup.run(10)
    setup.kit.deaf = {Law: 1, Piece: 3}
    setup.go()
    assert len(setup.messages(Law)) == 2
    assert len(setup.messages(Piece)) >= setup.kit.loaded.size / 32 + 3
    assert setup.kit.loaded.data == setup.engine.decision().in_force.program.data
    setup.kit.loaded, setup.kit.generation = None, 0
    setup.run(2)
    assert setup.engine.rendering == "computer"
    setup.until(lambda: setup.kit.received > 64)
    setup.kit.loaded.data.clear()
    setup.until(lambda: setup.engine.rendering == "board")
    assert setup.kit.loaded.data == setup.engine.decision().in_force.program.data


def test_constants_beyond_one_message_are_sent_in_several(rendering):
    setup = rendering(environment="hard_surface")
    setup.go()
    setup.change_all_numbers()
    wanted = np.array(setup.engine.decision().in_force.program.given, np.float32)
    assert np.count_nonzero(wanted != setup.kit.loaded.numbers) > 6
    setup.until(lambda: np.array_equal(wanted, setup.kit.loaded.numbers))
    assert len(setup.messages(Law)) == 1


def test_more_changed_constants_than_ramps_are_sent_as_a_new_law(rendering):
    setup = rendering(environment="button", arena=345)
    setup.go(rate=2000)
    way = setup.engine.decision().in_force
    setup.change_all_numbers()
    assert setup.engine.decision().in_force.code_id == way.code_id
    setup.until(lambda: len(setup.messages(Law)) == 2)
    setup.until(lambda: setup.engine.rendering == "board")
    assert not setup.messages(Tune)
    assert setup.kit.loaded.data == setup.engine.decision().in_force.program.data


def test_a_different_law_rate_or_filter_is_sent_as_a_whole(rendering):
    setup = rendering(values=SPRING)
    setup.go()
    for change in (
        lambda: setup.engine.set_environment("wall"),
        lambda: setup.engine.set_parameter("side", "left"),
        lambda: setup.engine.set_loop(estimator="kalman"),
        lambda: setup.engine.set_where("board", 1000.0),
    ):
        laws = len(setup.messages(Law))
        change()
        setup.compiled()
        setup.until(lambda laws=laws: len(setup.messages(Law)) == laws + 1)
        setup.until(lambda: setup.engine.rendering == "board")
        assert setup.kit.loaded.law.period == setup.engine.decision().in_force.period
        assert setup.kit.loaded.data == setup.engine.decision().in_force.program.data
    generations = [law.generation for law in setup.messages(Law)]
    assert len(set(generations)) == len(generations)


def test_the_computer_renders_what_the_board_refuses_with_the_reason(rendering):
    setup = rendering(refuses=Refusal.JUMP)
    setup.engine.decision(wait=True)
    setup.engine.set_where("board")
    setup.until(lambda: setup.engine.decision().refusal != "")
    assert (
        setup.engine.decision().refusal == "The board refuses this law (jump). The computer renders instead."
    )
    assert (setup.engine.where, setup.engine.loop.where) == ("computer", "board")
    setup.run(150)
    assert setup.engine.rendering == "computer"
    assert len(setup.messages(Law)) == 1
    with pytest.raises(ParameterError, match="refuses this law"):
        setup.engine.set_where("board")
    setup.kit.refuses = Refusal.NONE
    setup.engine.set_environment("damping")
    setup.compiled()
    setup.until(lambda: setup.engine.rendering == "board")


def test_the_loop_of_each_renderer_has_its_own_rate_filter_and_controller(rendering):
    setup = rendering()
    setup.engine.set_loop(estimator="butterworth", controller=True)
    plan = setup.engine.decision(wait=True).plan
    here, there = (setup.engine.loop_of(where, 1e-3, "firm") for where in ("computer", "board"))
    assert (here.rate, here.estimator, here.controller) == (1000.0, "butterworth", True)
    assert (there.rate, there.estimator, there.controller) == (plan.rate, "kalman", False)
    assert (here.delay, here.hand) == (there.delay, there.hand) == (1e-3, "firm")
    assert (here.mass, here.coulomb) == (setup.engine.device.mass, setup.engine.device.coulomb_force)
    setup.engine.limit_force(1.0)
    assert setup.engine.loop_of("board", 1e-3) is None


def test_a_decision_that_is_pending_keeps_the_last_refusal_and_the_plan_in_force(rendering, monkeypatch):
    setup = rendering(arena=150)
    setup.go()
    in_force = setup.engine.decision().in_force
    monkeypatch.setattr(BackgroundPlanner, "plan", lambda self, planner, request: planner.known(request))
    setup.engine.set_environment("cat")
    decision = setup.engine.decision()
    assert (decision.where, decision.pending, decision.plan, decision.refusal) == ("board", True, None, "")
    assert decision.in_force is in_force
    refused = setup.engine.decision(wait=True)
    assert (refused.where, refused.pending, refused.in_force) == ("computer", False, None)
    setup.engine.set_loop(delay=0.001)  # with the loop's settings, the engine also publishes the decision
    setup.engine.set_environment("damping")
    decision = setup.engine.decision()
    assert (decision.where, decision.pending, decision.refusal) == ("computer", True, refused.refusal)
    setup.engine.decision(wait=True)
    assert setup.engine.decision().pending  # the decision is pending until the loop receives it
    setup.engine.set_loop(delay=0.0)
    decision = setup.engine.decision()
    assert (decision.where, decision.pending) == ("board", False)
    assert decision.in_force is decision.plan is not None


def test_the_computer_resumes_with_a_fade(rendering):
    setup = rendering(values=SPRING)
    setup.run(5)
    setup.count = ZERO + 100
    setup.go()
    setup.engine.set_where("computer")
    found = setup.until(lambda: setup.engine.rendering == "computer" and not setup.kit.renders)
    assert setup.messages(Leave)
    back = setup.run(36)
    found = [row[rows.APPLIED_FORCE] for row in back]
    assert found[-1] == pytest.approx(-100.0 * 100 * QUANTUM)
    steps = -np.diff(found)
    assert steps.max() <= 1.001 * 1.0 / 30.0
    assert abs(found[0]) < 0.1


def test_the_stop_is_sent_first(rendering):
    setup = rendering(values=SPRING)
    setup.go()
    setup.run(5)
    setup.engine.stop()
    setup.engine.set_parameter("stiffness", 150.0)
    setup.telemetry = {"flags": int(BoardFlag.STOPPED)}
    row = setup.run(2)[-1]
    assert int(row[rows.FLAGS]) & rows.STOPPED
    assert setup.messages(Stop)
    laws = len(setup.messages(Law))
    setup.engine.release_stop()
    setup.telemetry = {}
    setup.run(2)
    assert setup.messages(Stop, Release)[-1] == Release()
    setup.until(lambda: len(setup.messages(Law)) == laws + 1)
    setup.until(lambda: setup.engine.rendering == "board")
    setup.run(40)
    assert not flags(setup.run(1))[-1]


def test_a_silent_board_gets_no_keep_alive_messages(rendering):
    setup = rendering()
    setup.go()
    setup.run(5)
    alive, forces = len(setup.messages(Alive)), len(setup.messages(Force))
    setup.board.fall_silent()
    setup.board.fall_silent()
    assert setup.engine.health().stale
    assert len(setup.messages(HelloRequest)) == 3  # the first of these requests opened the connection
    setup.run(80)
    assert (len(setup.messages(Alive)), len(setup.messages(Force))) == (alive, forces)
    setup.run(60)
    assert len(setup.messages(Alive)) > alive


def test_the_computer_renders_what_the_board_cannot(rendering):
    setup = rendering(arena=150)
    setup.go()
    setup.engine.set_environment("cat")
    text = r"Cat needs \d+ bytes of memory, but the board has 150"
    assert re.match(text, setup.engine.decision(wait=True).refusal)
    setup.until(lambda: setup.engine.rendering == "computer")
    assert (setup.engine.where, setup.engine.loop.where) == ("computer", "board")
    with pytest.raises(ParameterError, match=text):
        setup.engine.set_where("board")
    setup.engine.set_environment("damping")
    setup.until(lambda: setup.engine.rendering == "board")


@pytest.mark.parametrize(("share", "renderer"), [(0.99, "computer"), (1.01, "board")])
def test_the_board_renders_only_if_the_labs_limit_is_not_below_its_own(
    rendering, monkeypatch, share, renderer
):
    limited = lab.LabSettings(force_limit=share * KIT.max_force)
    monkeypatch.setattr(lab, "settings", lambda: limited)
    setup = rendering()
    if renderer == "board":
        setup.go()
    else:
        with pytest.raises(ParameterError, match="limit is set below the board's limit"):
            setup.engine.set_where("board")
    assert setup.engine.decision(wait=True).where == renderer
    assert setup.engine.max_force == pytest.approx(min(share, 1.0) * KIT.max_force)


def test_the_board_renders_if_the_labs_limit_is_its_own_before_rounding(rendering, monkeypatch):
    rounded = float(np.float32(2.7))
    assert rounded > 2.7
    monkeypatch.setattr(HapkitBoard, "max_force", rounded)
    monkeypatch.setattr(lab, "settings", lambda: lab.LabSettings(force_limit=2.7))
    rendering().go()


def test_changes_of_the_law_in_force_are_sent_as_constants(rendering):
    """After a lost change the newest value is sent; a rendering board receives no forces."""
    setup = rendering(values=SPRING)
    setup.engine.set_loop(estimator="kalman")
    setup.go(rate=500)
    (law,) = setup.messages(Law)
    coefs = design("kalman", 500, setup.engine.device.quantum)[1]
    assert (law.period, law.estimator) == (4000, 2)
    assert (law.first, law.second) == pytest.approx((coefs[0], coefs[1] * 500.0), rel=1e-6)
    spring = environments.named("spring")
    program = board.compile(spring.force, spring.values(SPRING), 1.0 / 500.0, ARENA)
    assert setup.kit.loaded.data == program.data
    sizes = program.states, len(program.given), program.slots, len(program.code)
    assert (law.states, law.given, law.slots, law.code) == sizes
    forces, alive = len(setup.messages(Force)), len(setup.messages(Alive))
    setup.run(100)
    assert 10 <= len(setup.messages(Alive)) - alive <= 30
    setup.kit.deaf = {Tune: 1}
    setup.engine.set_parameter("stiffness", 120.0)
    setup.compiled()
    setup.until(lambda: len(setup.messages(Tune)) == 1)
    state = setup.engine.driver.conn.state
    state.tuned_at = math.inf  # the change counts as recent for as long as the test takes
    setup.engine.set_parameter("stiffness", 130.0)
    setup.compiled()
    setup.run(20)
    assert len(setup.messages(Tune)) == 1
    state.tuned_at = 0.0
    setup.until(lambda: setup.kit.tuned)
    setup.engine.move_hand(0.01)
    setup.run(80)
    assert [(t.law, t.count, t.values[0]) for t in setup.messages(Tune)] == [
        (law.generation, 1, -120.0),
        (law.generation, 1, -130.0),
    ]
    assert setup.kit.loaded.numbers.tolist() == list(setup.engine.decision().in_force.program.given)
    assert (len(setup.messages(Law)), len(setup.messages(Force))) == (1, forces)
    setup.engine.close()
    assert setup.messages(Leave, Force)[-1] == Force(0, 0, 0.0)
    messages = setup.messages(Leave, Force)
    left = messages.index(Leave())
    assert messages[left : left + 2] == [Leave(), Leave()]
    assert set(messages[left + 2 :]) == {Force(0, 0, 0.0)}


def test_a_handover_far_from_the_start_causes_no_apparent_speed(rendering):
    """The first handover is to a different law, the second from a board that has lost its law."""
    setup = rendering(values=SPRING)
    setup.engine.set_loop(estimator="kalman")
    setup.go()
    setup.count = ZERO + 700  # 700 counts are 14 mm
    setup.run(5)
    setup.engine.set_environment("wall")
    found = []
    while setup.engine.rendering == "board" or not found:
        found += setup.run(1)
    found += setup.until(lambda: setup.engine.rendering == "board")
    setup.kit.loaded, setup.kit.generation = None, 0
    found += setup.run(3)
    assert setup.engine.fault is None
    assert max(abs(row[rows.VELOCITY]) for row in found) < 1e-9


def test_the_board_receives_zero_and_direction(rendering):
    setup = rendering(values=SPRING)
    setup.run(10)
    setup.engine.flip_direction()
    setup.count = ZERO + 50
    assert setup.run(3)[-1][rows.POSITION] == pytest.approx(-50 * QUANTUM)
    setup.go()
    (board,) = setup.messages(Board)
    assert (board.zero, board.sense, board.direction) == (ZERO, -1, -1)
    assert (board.table, board.label, board.counts_per_flip) == (KIT.table, KIT.label, KIT.counts_per_flip)
    row = setup.run(1)[-1]
    assert row[rows.POSITION] == pytest.approx(50 * QUANTUM)  # this board does not reverse its counts
    assert setup.engine.fault is None


def test_a_new_zero_is_sent_to_the_board(rendering):
    setup = rendering(values=SPRING)
    setup.go()
    setup.count = ZERO + 120
    assert setup.run(2)[-1][rows.POSITION] == pytest.approx(120 * QUANTUM)
    setup.engine.zero_here()
    setup.until(lambda: len(setup.messages(Board)) == 2)
    setup.until(lambda: setup.engine.rendering == "board")
    assert setup.messages(Board)[-1].zero == ZERO + 120
    assert setup.run(2)[-1][rows.POSITION] == 0.0
    assert setup.engine.fault is None


def test_rows_and_counts_report_the_boards_state(rendering):
    setup = rendering(environment="hard_surface")
    setup.run(60)
    setup.telemetry = {"delay_us": 150}
    setup.go()
    setup.run(60)
    assert setup.engine.delay_of("computer").mean == pytest.approx(500e-6)
    assert setup.engine.delay_of("board").mean == pytest.approx(150e-6, rel=0.02)
    assert setup.engine.health().delay == setup.engine.delay_of("board").mean
    setup.count = ZERO + 120
    setup.telemetry = {"velocity": 0.125, "asked": -1.5, "pwm": -128, "flags": int(BoardFlag.CLAMPED)}
    row = setup.run(31)[-1]
    assert row[rows.POSITION] == pytest.approx(120 * QUANTUM)
    assert (row[rows.VELOCITY], row[rows.FORCE]) == (0.125, -1.5)
    assert row[rows.APPLIED_FORCE] == pytest.approx(-FULL * (128 / 255) ** 2, rel=1e-6)
    assert int(row[rows.FLAGS]) == rows.CLAMPED
    assert row[rows.PERIOD] == pytest.approx(1e-3)
    names = setup.engine.environment.state_names
    for at in range(len(names)):
        setup.telemetry = {"state_at": at, "state": 0.5 + at, "overruns": 250}
        row = setup.run(1)[-1]
    assert row[rows.STATE : rows.STATE + len(names)].tolist() == [0.5 + at for at in range(len(names))]
    setup.telemetry = {"overruns": 3}
    setup.run(1)
    assert setup.engine.missed_of("board") == 259
    setup.engine.set_environment("friction")
    setup.telemetry = {"state_at": 0, "state": 9.0}
    first = setup.engine.environment.force.compiled().initial_state[0]
    assert setup.run(1)[-1][rows.STATE] == first


def test_faults_latched_by_the_board_are_latched_here_stop_it_and_can_be_cleared(rendering):
    """The faults are over-speed, a jump at which the board resets its estimate, and a non-finite force."""
    setup = rendering()
    setup.go()
    setup.telemetry = {"flags": int(BoardFlag.OVER_SPEED), "velocity": 3.5}
    setup.run(2)
    assert setup.engine.fault.code == arrays.OVER_SPEED
    assert "3.5 m/s" in setup.engine.fault.text
    assert setup.messages(Stop)
    setup.telemetry = {"flags": int(BoardFlag.OVER_SPEED)}
    setup.engine.clear_fault()
    setup.run(1)
    assert setup.messages(Stop, Release)[-1] == Release()
    setup.telemetry = {}
    setup.excuse_over()
    setup.until(lambda: setup.engine.rendering == "board")
    assert setup.engine.fault is None
    setup.count += 400
    setup.telemetry = {"flags": int(BoardFlag.OVER_SPEED), "velocity": 0.0}
    setup.run(1)
    speed = 400 * setup.engine.device.quantum / 1e-3
    assert speed > 5.0
    assert f"the handle moved too fast, {speed:.1f} m/s" in setup.engine.fault.text
    setup.telemetry = {}
    setup.engine.clear_fault()
    setup.excuse_over()
    setup.until(lambda: setup.engine.rendering == "board")
    setup.telemetry = {"flags": int(BoardFlag.REFUSED), "asked": float("nan")}
    row = setup.run(2)[-1]
    assert setup.engine.fault.code == arrays.NOT_A_NUMBER
    assert row[rows.FORCE] == 0.0
    laws = len(setup.messages(Law))
    setup.engine.clear_fault()
    setup.telemetry = {}
    setup.until(lambda: len(setup.messages(Law)) == laws + 1)
    setup.until(lambda: setup.engine.rendering == "board")
    assert setup.engine.fault is None


def test_a_users_law_renders_on_the_board_with_the_boards_estimators_and_rates(rendering):
    setup = rendering()
    setup.engine.set_loop(estimator="butterworth")
    setup.go()
    assert setup.engine.decision().in_force.estimator == 2
    setup.engine.set_environment(CONSTANT)
    setup.compiled()
    setup.until(
        lambda: setup.kit.renders and setup.kit.loaded.data == setup.engine.decision().in_force.program.data
    )
    setup.until(lambda: setup.engine.rendering == "board")
    with pytest.raises(ParameterError, match="500 to 4,000 Hz in steps of 100 Hz"):
        setup.engine.set_where("board", 300.0)
    setup.engine.limit_force(1.0)
    assert setup.engine.where == "computer"
    assert "force limit" in setup.engine.decision().refusal
