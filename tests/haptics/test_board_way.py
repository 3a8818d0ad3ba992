"""Who renders: handing over to a board and back, what it is told meanwhile, and what its rows hold."""

import re

import numpy as np
import pytest

from hapkit_studio import environments
from hapkit_studio.dynamics.estimators import design
from hapkit_studio.errors import ParameterError
from hapkit_studio.haptics import arrays, rows
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
from tests.devices.fake_kit import ARENA, KIT
from tests.haptics.board_support import ZERO, undisturbed
from tests.haptics.support import CONSTANT
from tests.waiting import wait_until

SPRING = {"stiffness": 100.0}
QUANTUM = KIT.quantum
FULL = KIT.motor_constant * KIT.sector_radius / (KIT.handle_radius * KIT.pulley_radius)


def flags(found):
    return [int(row[rows.FLAGS]) for row in found]


@undisturbed(values=SPRING)
def test_the_force_fades_out_before_the_board_is_told(desk):
    desk.run(40)
    desk.count = ZERO + 100
    before = desk.run(2)[-1]
    assert before[rows.APPLIED] == pytest.approx(-100.0 * 100 * QUANTUM)
    found = desk.go()
    shares = np.array([row[rows.APPLIED] for row in found]) / before[rows.APPLIED]
    fading = shares[shares > 0.0]
    np.testing.assert_allclose(-np.diff(fading), 1.0 / 30.0, atol=1e-9)
    told = [type(m) for m in desk.board.received]
    last = max(i for i, kind in enumerate(told) if kind is Force)
    assert told.index(Piece) > told.index(Law) > told.index(Board) > 0
    assert last < told.index(Law)
    assert desk.told(Force)[-1].force == 0.0


@undisturbed(values=SPRING)
def test_the_law_and_the_loop_are_those_in_force(desk):
    desk.engine.set_loop(estimator="kalman")
    desk.go(rate=500)
    (law,) = desk.told(Law)
    coefs = design("kalman", 500, desk.engine.device.quantum)[1]
    assert (law.rate, law.estimator) == (500, 2)
    assert (law.first, law.second) == pytest.approx((coefs[0], coefs[1] * 500.0), rel=1e-6)
    spring = environments.named("spring")
    program = board.compile(spring.force, spring.values(SPRING), 1.0 / 500.0, ARENA)
    assert desk.kit.loaded.data == program.data
    assert (law.states, law.given, law.slots, law.code) == (
        program.states, len(program.given), program.slots, len(program.code)
    )  # fmt: skip


@undisturbed(environment="mass_spring_damper")
def test_a_long_law_comes_whole_though_pieces_get_lost(desk):
    desk.run(10)
    desk.kit.deaf = {Law: 1, Piece: 3}
    desk.go()
    pieces = desk.told(Piece)
    assert len(desk.told(Law)) == 2
    assert len(pieces) > desk.kit.loaded.size / 32 + 3
    assert desk.kit.loaded.data == desk.engine.board_plan.program.data


@undisturbed(environment="mass_spring_damper")
def test_a_board_without_a_law_is_sent_it_anew(desk):
    """So after a reset in the middle, and where a piece was damaged and the whole does not fit its check."""
    desk.engine.board_refusal(wait=True)
    desk.engine.set_where("board")
    desk.until(lambda: desk.kit.received > 64)
    desk.kit.loaded.data.clear()
    desk.until(lambda: desk.engine.rendering == "board")
    desk.run(5)
    desk.kit.loaded, desk.kit.generation = None, 0
    desk.run(2)
    assert desk.engine.rendering == "computer"
    desk.until(lambda: desk.engine.rendering == "board")
    assert desk.kit.loaded.data == desk.engine.board_plan.program.data


@undisturbed(values=SPRING)
def test_a_board_that_loses_its_law_far_from_where_it_began_makes_no_speed(desk):
    desk.go()
    desk.count = ZERO + 700  # 14 mm
    desk.run(5)
    desk.kit.loaded, desk.kit.generation = None, 0
    found = desk.run(3)
    assert desk.engine.fault is None
    assert max(abs(row[rows.VELOCITY]) for row in found) < 1e-9


@undisturbed(values=SPRING)
def test_another_law_far_from_where_the_board_took_over_makes_no_speed(desk):
    desk.engine.set_loop(estimator="kalman")
    desk.go()
    desk.count = ZERO + 700  # 14 mm
    desk.run(5)
    desk.engine.set_environment("wall")
    found = []
    while desk.engine.rendering == "board" or not found:
        found += desk.run(1)
    found += desk.run(3)
    assert desk.engine.fault is None
    assert max(abs(row[rows.VELOCITY]) for row in found) < 1e-9


@undisturbed(values=SPRING)
def test_the_board_takes_over_the_zero_and_the_direction(desk):
    desk.run(10)
    desk.engine.flip_direction()
    desk.count = ZERO + 50
    assert desk.run(3)[-1][rows.POSITION] == pytest.approx(-50 * QUANTUM)
    desk.go()
    (board,) = desk.told(Board)
    assert (board.zero, board.sense, board.direction) == (ZERO, -1, -1)
    assert (board.table, board.label, board.counts_per_flip) == (KIT.table, KIT.label, KIT.counts_per_flip)
    row = desk.run(1)[-1]
    assert row[rows.POSITION] == pytest.approx(50 * QUANTUM)  # this board does not turn its counts
    assert desk.engine.fault is None


@undisturbed(values=SPRING)
def test_a_new_zero_is_the_boards_too(desk):
    desk.go()
    desk.count = ZERO + 120
    assert desk.run(2)[-1][rows.POSITION] == pytest.approx(120 * QUANTUM)
    desk.engine.zero_here()
    desk.until(lambda: len(desk.told(Board)) == 2)
    desk.until(lambda: desk.engine.rendering == "board")
    assert desk.told(Board)[-1].zero == ZERO + 120
    assert desk.run(2)[-1][rows.POSITION] == 0.0
    assert desk.engine.fault is None


@undisturbed(values=SPRING)
def test_rows_show_what_the_board_did(desk):
    desk.run(10)
    desk.go()
    desk.count = ZERO + 120
    desk.telemetry = {"velocity": 0.125, "asked": -1.5, "pwm": -128, "flags": int(BoardFlag.CLAMPED)}
    desk.run(30)
    row = desk.run(1)[-1]
    assert row[rows.POSITION] == pytest.approx(120 * QUANTUM)
    assert (row[rows.VELOCITY], row[rows.ASKED]) == (0.125, -1.5)
    assert row[rows.APPLIED] == pytest.approx(-FULL * (128 / 255) ** 2, rel=1e-6)
    assert int(row[rows.FLAGS]) == rows.CLAMPED
    assert row[rows.PERIOD] == pytest.approx(1e-3)


@undisturbed()
def test_the_board_hears_every_few_milliseconds_and_no_force(desk):
    desk.go()
    forces, alive = len(desk.told(Force)), len(desk.told(Alive))
    desk.run(100)
    assert len(desk.told(Force)) == forces
    assert 10 <= len(desk.told(Alive)) - alive <= 30


@undisturbed(values=SPRING)
def test_a_changed_parameter_is_one_constant_more(desk):
    desk.go()
    desk.run(20)
    desk.engine.set_parameter("stiffness", 120.0)
    desk.compiled()
    desk.until(lambda: desk.told(Tune))
    desk.run(20)
    tune = desk.told(Tune)[0]
    assert (tune.law, tune.count, tune.values[0]) == (desk.told(Law)[0].generation, 1, -120.0)
    assert desk.kit.loaded.numbers.tolist() == list(desk.engine.board_plan.program.given)
    desk.engine.move_hand(0.01)
    desk.run(20)
    assert (len(desk.told(Tune)), len(desk.told(Law))) == (1, 1)


@undisturbed(environment="hard_surface")
def test_more_constants_than_one_message_holds_are_sent_one_after_the_other(desk):
    desk.go()
    values = desk.engine.values
    numbers = [p for p in desk.engine.environment.parameters if not p.discrete]
    desk.engine.set_environment("hard_surface", values | {p.key: 0.9 * values[p.key] for p in numbers})
    desk.compiled()
    wanted = np.array(desk.engine.board_plan.program.given, np.float32)
    assert np.count_nonzero(wanted != desk.kit.loaded.numbers) > 6
    desk.until(lambda: np.array_equal(wanted, desk.kit.loaded.numbers))
    assert len(desk.told(Law)) == 1


@undisturbed(values=SPRING)
def test_a_change_that_got_lost_is_said_again_with_the_newest_value(desk):
    desk.go()
    desk.run(10)
    desk.kit.deaf = {Tune: 1}
    desk.engine.set_parameter("stiffness", 120.0)
    desk.compiled()
    desk.until(lambda: len(desk.told(Tune)) == 1)
    desk.engine.set_parameter("stiffness", 130.0)
    desk.compiled()
    desk.until(lambda: desk.kit.tuned)
    assert [t.values[0] for t in desk.told(Tune)] == [-120.0, -130.0]
    desk.run(80)
    assert len(desk.told(Tune)) == 2


@undisturbed(environment="button", arena=345)
def test_more_moving_constants_than_there_is_room_for_are_a_law(desk):
    desk.go()
    way, values = desk.engine.board_plan, desk.engine.values
    numbers = [p for p in desk.engine.environment.parameters if not p.discrete]
    desk.engine.set_environment("button", values | {p.key: 0.9 * values[p.key] for p in numbers})
    desk.compiled()
    assert desk.engine.board_plan.form == way.form
    desk.until(lambda: len(desk.told(Law)) == 2)
    desk.until(lambda: desk.engine.rendering == "board")
    assert not desk.told(Tune)
    assert desk.kit.loaded.data == desk.engine.board_plan.program.data


@undisturbed(values=SPRING)
def test_another_law_or_rate_or_filter_is_sent_whole(desk):
    desk.go()
    for change in (
        lambda: desk.engine.set_environment("wall"),
        lambda: desk.engine.set_parameter("side", "left"),
        lambda: desk.engine.set_loop(estimator="kalman"),
        lambda: desk.engine.set_where("board", 1000.0),
    ):
        laws = len(desk.told(Law))
        change()
        desk.compiled()
        desk.until(lambda laws=laws: len(desk.told(Law)) == laws + 1)
        desk.until(lambda: desk.engine.rendering == "board")
        assert desk.kit.loaded.law.rate == desk.engine.board_plan.rate
        assert desk.kit.loaded.data == desk.engine.board_plan.program.data
    generations = [law.generation for law in desk.told(Law)]
    assert len(set(generations)) == len(generations)


@undisturbed(refuses=Refusal.JUMP)
def test_what_the_board_refuses_the_computer_renders_and_says_so(desk):
    desk.engine.board_refusal(wait=True)
    desk.engine.set_where("board")
    desk.until(lambda: desk.engine.board_refusal() != "")
    assert desk.engine.board_refusal() == "The board refuses this law (jump). The computer renders."
    assert (desk.engine.where, desk.engine.where_wanted) == ("computer", "board")
    desk.run(150)
    assert desk.engine.rendering == "computer"
    assert len(desk.told(Law)) == 1
    with pytest.raises(ParameterError, match="refuses this law"):
        desk.engine.set_where("board")
    desk.kit.refuses = Refusal.NONE
    desk.engine.set_environment("damping")
    desk.compiled()
    desk.until(lambda: desk.engine.rendering == "board")


@undisturbed(values=SPRING)
def test_the_computer_comes_back_with_a_fade(desk):
    desk.run(5)
    desk.count = ZERO + 100
    desk.go()
    desk.engine.set_where("computer")
    found = desk.until(lambda: desk.engine.rendering == "computer" and not desk.kit.renders)
    wait_until(lambda: desk.told(Leave))
    back = desk.run(36)
    found = [row[rows.APPLIED] for row in back]
    assert found[-1] == pytest.approx(-100.0 * 100 * QUANTUM)
    steps = -np.diff(found)
    assert steps.max() <= 1.001 * 1.0 / 30.0
    assert abs(found[0]) < 0.1


@undisturbed(values=SPRING)
def test_the_stop_goes_out_first(desk):
    desk.go()
    desk.run(5)
    desk.engine.stop()
    desk.engine.set_parameter("stiffness", 150.0)
    desk.telemetry = {"flags": int(BoardFlag.STOPPED)}
    row = desk.run(2)[-1]
    assert int(row[rows.FLAGS]) & rows.STOPPED
    wait_until(lambda: desk.told(Stop))
    laws = len(desk.told(Law))
    desk.engine.release_stop()
    desk.telemetry = {}
    desk.run(2)
    wait_until(lambda: desk.told(Stop, Release)[-1] == Release())
    desk.until(lambda: len(desk.told(Law)) == laws + 1)
    desk.until(lambda: desk.engine.rendering == "board")
    desk.run(40)
    assert not flags(desk.run(1))[-1]


@undisturbed()
def test_over_speed_on_the_board_is_latched_here_and_stops_it(desk):
    desk.go()
    desk.telemetry = {"flags": int(BoardFlag.OVER_SPEED), "velocity": 3.5}
    desk.run(2)
    assert desk.engine.fault.code == arrays.OVER_SPEED
    assert "3.5 m/s" in desk.engine.fault.text
    wait_until(lambda: desk.told(Stop))
    desk.telemetry = {"flags": int(BoardFlag.OVER_SPEED)}
    desk.engine.clear_fault()
    desk.run(3)
    wait_until(lambda: desk.told(Stop, Release)[-1] == Release())
    desk.telemetry = {}
    desk.run(10)
    assert desk.engine.fault is None


@undisturbed()
def test_a_force_that_is_no_number_needs_the_law_anew(desk):
    desk.go()
    desk.telemetry = {"flags": int(BoardFlag.REFUSED), "asked": float("nan")}
    row = desk.run(2)[-1]
    assert desk.engine.fault.code == arrays.NOT_A_NUMBER
    assert row[rows.ASKED] == 0.0
    laws = len(desk.told(Law))
    desk.engine.clear_fault()
    desk.telemetry = {}
    desk.until(lambda: len(desk.told(Law)) == laws + 1)
    desk.until(lambda: desk.engine.rendering == "board")
    assert desk.engine.fault is None


@undisturbed(environment="hard_surface")
def test_values_of_state_take_turns(desk):
    desk.go()
    names = desk.engine.environment.state_names
    for at in range(len(names)):
        desk.telemetry = {"state_at": at, "state": 0.5 + at}
        row = desk.run(1)[-1]
    assert row[rows.STATE : rows.STATE + len(names)].tolist() == [0.5 + at for at in range(len(names))]
    desk.engine.set_environment("friction")
    desk.telemetry = {"state_at": 0, "state": 9.0}
    first = desk.engine.environment.force.compiled().initial_state[0]
    assert desk.run(1)[-1][rows.STATE] == first


@undisturbed(stale=True)
def test_a_silent_board_is_no_more_told_that_someone_is_there(desk):
    desk.go()
    desk.run(5)
    alive, forces = len(desk.told(Alive)), len(desk.told(Force))
    wait_until(lambda: desk.engine.health().stale and len(desk.told(HelloRequest)) >= 2)
    assert len(desk.told(Alive)) == alive
    assert len(desk.told(Force)) == forces
    desk.run(80)
    assert len(desk.told(Alive)) == alive
    desk.run(60)
    assert len(desk.told(Alive)) > alive


@undisturbed()
def test_the_last_act_takes_the_law_away_and_commands_zero(desk):
    desk.go()
    desk.engine.close()
    wait_until(lambda: desk.told(Leave, Force)[-1] == Force(0, 0, 0.0))
    told = desk.told(Leave, Force)
    left = told.index(Leave())
    assert told[left : left + 2] == [Leave(), Leave()]
    assert set(told[left + 2 :]) == {Force(0, 0, 0.0)}


@undisturbed()
def test_delays_are_kept_apart(desk):
    desk.run(60)
    desk.telemetry = {"delay_us": 150}
    desk.go()
    desk.run(60)
    assert desk.engine.delay_of("computer").mean == pytest.approx(500e-6)
    assert desk.engine.delay_of("board").mean == pytest.approx(150e-6, rel=0.02)
    assert desk.engine.health().delay == desk.engine.delay_of("board").mean


@undisturbed()
def test_skipped_ticks_are_counted(desk):
    desk.go()
    desk.telemetry = {"overruns": 250}
    desk.run(1)
    desk.telemetry = {"overruns": 3}
    desk.run(1)
    assert desk.engine.overruns == 259


@undisturbed(arena=150)
def test_what_the_board_cannot_render_stays_here(desk):
    desk.go()
    desk.engine.set_environment("cat")
    words = r"Cat needs \d+ bytes, the board has 150"
    assert re.match(words, desk.engine.board_refusal(wait=True))
    desk.until(lambda: desk.engine.rendering == "computer")
    assert (desk.engine.where, desk.engine.where_wanted) == ("computer", "board")
    with pytest.raises(ParameterError, match=words):
        desk.engine.set_where("board")
    desk.engine.set_environment("damping")
    desk.until(lambda: desk.engine.rendering == "board")


@undisturbed()
def test_a_law_of_ones_own_needs_nothing_on_the_board(desk):
    desk.go()
    desk.engine.set_environment(CONSTANT)
    desk.compiled()
    desk.until(lambda: desk.kit.renders and desk.kit.loaded.data == desk.engine.board_plan.program.data)
    desk.until(lambda: desk.engine.rendering == "board")


@undisturbed()
def test_the_boards_own_estimators_and_rates(desk):
    desk.engine.set_loop(estimator="butterworth")
    desk.engine.board_refusal(wait=True)
    desk.engine.set_where("board")
    assert desk.engine.board_plan.estimator == 2
    with pytest.raises(ParameterError, match="500, 1,000, 2,000, 4,000 Hz"):
        desk.engine.set_where("board", 300.0)
    desk.engine.limit_force(1.0)
    assert desk.engine.where == "computer"
    assert "force limit" in desk.engine.board_refusal()
