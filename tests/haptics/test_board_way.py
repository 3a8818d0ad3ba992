"""Who renders: handing over to a board and back, what it is told meanwhile, and what its rows hold."""

import numpy as np
import pytest

from hapkit_studio.dynamics.estimators import design
from hapkit_studio.errors import ParameterError
from hapkit_studio.haptics import rig, rows
from hapkit_studio.protocol.messages import (
    NO_LAW,
    Alive,
    Board,
    BoardFlag,
    Force,
    HelloRequest,
    Loop,
    Release,
    Scene,
    Stop,
)
from tests.devices.fake_kit import KIT
from tests.haptics.board_support import LAWS, ZERO, undisturbed
from tests.haptics.serial_support import wait_for
from tests.haptics.support import CONSTANT

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
    assert told.index(Scene) > told.index(Loop) > told.index(Board) > 0
    assert last < told.index(Scene)
    assert desk.told(Force)[-1].force == 0.0


@undisturbed(values=SPRING)
def test_the_scene_and_the_loop_are_those_in_force(desk):
    desk.engine.set_loop(estimator="kalman")
    desk.go(rate=500)
    (loop,), (scene,) = desk.told(Loop), desk.told(Scene)
    coefs = design("kalman", 500, desk.engine.device.quantum)[1]
    assert (loop.rate, loop.estimator) == (500, 2)
    assert (loop.first, loop.second) == pytest.approx((coefs[0], coefs[1] * 500.0), rel=1e-6)
    assert LAWS[scene.law] == "spring"
    wanted = [desk.engine.values[p.key] for p in desk.engine.environment.parameters]
    assert scene.values == pytest.approx((*wanted, *(16 - len(wanted)) * (0.0,)))


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
def test_a_changed_parameter_is_one_scene_more(desk):
    desk.go()
    desk.run(20)
    scenes = len(desk.told(Scene))
    desk.engine.set_parameter("stiffness", 120.0)
    desk.run(20)
    new = desk.told(Scene)[scenes:]
    assert [s.values[0] for s in new] == [120.0]
    assert new[0].generation != desk.told(Scene)[0].generation
    desk.engine.move_hand(0.01)
    desk.run(20)
    assert len(desk.told(Scene)) == scenes + 1


@undisturbed(values=SPRING)
def test_a_scene_that_got_lost_is_said_again(desk):
    desk.go()
    desk.run(10)
    desk.kit.hears = False
    desk.engine.set_parameter("stiffness", 120.0)
    desk.run(20)
    desk.kit.hears = True
    desk.until(lambda: desk.kit.scene.values[0] == 120.0, 1000)


@undisturbed(values=SPRING)
def test_the_computer_comes_back_with_a_fade(desk):
    desk.run(5)
    desk.count = ZERO + 100
    desk.go()
    desk.engine.set_where("computer")
    found = desk.until(lambda: desk.engine.rendering == "computer" and not desk.kit.renders)
    wait_for(lambda: desk.told(Scene)[-1].law == NO_LAW)
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
    wait_for(lambda: desk.told(Stop))
    told = desk.told(Stop, Scene)
    assert told.index(Stop()) < len(told) - 1 or told[-1] == Stop()
    desk.engine.release_stop()
    desk.telemetry = {}
    desk.run(2)
    wait_for(lambda: desk.told(Stop, Release)[-1] == Release())
    desk.run(40)
    assert not flags(desk.run(1))[-1]


@undisturbed()
def test_over_speed_on_the_board_is_latched_here_and_stops_it(desk):
    desk.go()
    desk.telemetry = {"flags": int(BoardFlag.OVER_SPEED), "velocity": 3.5}
    desk.run(2)
    assert desk.engine.fault.code == rig.OVER_SPEED
    assert "3.5 m/s" in desk.engine.fault.text
    wait_for(lambda: desk.told(Stop))
    desk.telemetry = {"flags": int(BoardFlag.OVER_SPEED)}
    desk.engine.clear_fault()
    desk.run(3)
    wait_for(lambda: desk.told(Stop, Release)[-1] == Release())
    desk.telemetry = {}
    desk.run(10)
    assert desk.engine.fault is None


@undisturbed()
def test_a_force_that_is_no_number_needs_another_scene(desk):
    desk.go()
    desk.telemetry = {"flags": int(BoardFlag.REFUSED), "asked": float("nan")}
    row = desk.run(2)[-1]
    assert desk.engine.fault.code == rig.NOT_A_NUMBER
    assert row[rows.ASKED] == 0.0
    scenes = len(desk.told(Scene))
    desk.engine.clear_fault()
    desk.telemetry = {}
    desk.run(15)
    assert len(desk.told(Scene)) == scenes + 1
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
    desk.telemetry = {"state_at": 0, "state": 9.0, "generation": desk.kit.scene.generation}
    first = desk.engine.environment.force.compiled().initial_state[0]
    assert desk.run(1)[-1][rows.STATE] == first


@undisturbed(stale=True)
def test_a_silent_board_is_no_more_told_that_someone_is_there(desk):
    desk.go()
    desk.run(5)
    alive, forces = len(desk.told(Alive)), len(desk.told(Force))
    wait_for(lambda: desk.engine.health().stale and len(desk.told(HelloRequest)) >= 2)
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
    wait_for(lambda: desk.told(Scene, Force)[-1] == Force(0, 0.0))
    told = desk.told(Scene, Force)
    assert [m.law for m in told if isinstance(m, Scene)][-1] == NO_LAW


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


@undisturbed(changed=("wall",))
def test_what_the_board_cannot_render_stays_here(desk):
    assert desk.engine.board_refusal() == ""
    desk.go()
    desk.engine.set_environment("wall")
    assert "another version" in desk.engine.board_refusal()
    desk.until(lambda: desk.engine.rendering == "computer")
    assert (desk.engine.where, desk.engine.where_wanted) == ("computer", "board")
    with pytest.raises(ParameterError, match="Update firmware"):
        desk.engine.set_where("board")
    desk.engine.set_environment(CONSTANT)
    assert "Export it as a sketch" in desk.engine.board_refusal()
    desk.engine.set_environment("damping")
    desk.until(lambda: desk.engine.rendering == "board")


@undisturbed()
def test_the_boards_own_estimators_and_rates(desk):
    desk.engine.set_loop(estimator="butterworth")
    desk.engine.set_where("board")
    assert desk.engine.board_way.estimator == 2
    with pytest.raises(ParameterError, match="500, 1,000, 2,000, 4,000 Hz"):
        desk.engine.set_where("board", 300.0)
    desk.engine.limit_force(1.0)
    assert desk.engine.where == "computer"
    assert "force limit" in desk.engine.board_refusal()


@undisturbed()
def test_a_rate_that_the_board_missed_is_said_again(desk):
    desk.go(rate=500)  # but its frames go on as at 1 kHz
    desk.until(lambda: len(desk.told(Loop)) >= 2, 1000)
