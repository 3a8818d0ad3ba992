"""The runner bounds forces, sends zero after any fault and at the end, and any thread can stop it."""

import math
import threading
from dataclasses import replace

import numpy as np
import pytest

from hapkit_studio.analysis.calibrate.motions import PULSES, SWEEP_LIMITS, pulse, sweep
from hapkit_studio.devices import board_runner
from hapkit_studio.devices.board_runner import (
    AbortedError,
    BoardRunner,
    CancelledError,
    Limits,
    StoppedError,
    track_of,
)
from hapkit_studio.devices.profiles import default
from hapkit_studio.errors import NoDataError
from hapkit_studio.protocol.messages import Sample
from tests.devices.paddle_kit import PaddleKit


@pytest.fixture
def runner():
    made = BoardRunner(PaddleKit())
    made.open()
    return made


def test_forces_are_limited_and_recording_uses_none(runner):
    runner.record(0.1)
    assert set(runner.board.forces) == {0.0}
    runner.run(lambda t, x, v: 5.0, 0.02, Limits(0.3))
    assert set(runner.board.forces) == {0.0, 0.3}
    pulse(runner, 9.0)
    assert max(np.abs(runner.board.forces)) == pytest.approx(max(PULSES))


@pytest.mark.parametrize(
    ("move", "limits", "text"),
    [
        (lambda t, x, v: math.nan, Limits(0.3), "not a number"),
        (lambda t, x, v: 1.0, Limits(1.0, 0.01), "10 mm"),
        (lambda t, x, v: 1.0, Limits(1.0, 1.0, 0.2), "0.20 m/s"),
    ],
)
def test_each_fault_ends_the_run_with_the_motor_off(runner, move, limits, text):
    seen = []

    def watched(t, x, v):
        seen.append(runner.progress)
        return move(t, x, v)

    with pytest.raises(AbortedError, match=text):
        runner.run(watched, 5.0, limits)
    assert seen == sorted(seen)
    assert {seconds for _, seconds in seen} == {5.0}
    assert runner.progress == (0.0, 0.0)
    assert runner.board.pwm == 0
    assert not runner.board.streaming
    assert abs(runner.board.x) < 0.02


def test_e_stop_ends_a_run_at_the_next_sample_until_it_is_released(runner):
    def stopping(t, x, v):
        if t > 0.05:
            threading.Thread(target=runner.stop).start()
        return 0.2

    with pytest.raises(StoppedError):
        runner.run(stopping, 5.0, Limits(0.3))
    assert runner.board.stopped
    assert runner.board.pwm == 0
    with pytest.raises(StoppedError):
        runner.run(lambda t, x, v: 0.1, 0.1, Limits(0.3))
    assert len(runner.record(0.05)) > 40
    runner.release()
    runner.run(lambda t, x, v: 0.1, 0.05, Limits(0.3))
    assert not runner.board.stopped


@pytest.mark.parametrize(
    "kit", [{"coulomb": 0.0, "viscous": 0.02}, {"mass": 0.02}, {"mass": 0.2, "coulomb": 0.4}]
)
def test_a_sweep_stays_within_its_limits_on_any_kit(kit):
    runner = BoardRunner(PaddleKit(**kit))
    runner.open()
    track = sweep(runner, 4.0, 0.8 * kit.get("coulomb", 0.1))
    assert np.abs(track.position - track.position[0]).max() < SWEEP_LIMITS.travel
    assert max(np.abs(runner.board.forces)) <= SWEEP_LIMITS.force


def test_with_a_wrong_direction_a_sweep_stays_within_its_limits():
    kit = PaddleKit(direction=-1)
    runner = BoardRunner(kit)
    runner.open()
    with pytest.raises(AbortedError):
        sweep(runner)
    assert abs(kit.x) < 0.040
    assert kit.pwm == 0


def test_a_tracks_time_is_unwrapped():
    around = [
        Sample(seq=i, time_us=(2**32 - 1500 + 1000 * i) % 2**32, count=i, raw=i, answered=0, delay_us=65535,
               flags=0, pwm=0, rx_errors=0, stale=0, generation=0, received=0, refusal=0)
        for i in range(4)
    ]  # fmt: skip
    track = track_of(around, default().board)
    np.testing.assert_allclose(track.time, [0.0, 1e-3, 2e-3, 3e-3], atol=1e-12)
    assert np.isinf(track.delay).all()


def test_cancel_ends_a_run_and_a_recording_until_the_next_job(runner):
    def cancelling(t, x, v):
        if t > 0.05:
            runner.cancel()
        return 0.2

    with pytest.raises(CancelledError):
        runner.run(cancelling, 5.0, Limits(0.3))
    assert runner.board.pwm == 0
    with pytest.raises(CancelledError):
        runner.record(5.0)
    runner.begin_job()
    assert len(runner.record(0.05)) > 40


def test_a_stopped_board_clock_ends_a_run(monkeypatch):
    monkeypatch.setattr(board_runner, "_SPARE_SECONDS", 0.05)
    monkeypatch.setattr(board_runner, "_SLOWEST", 0.0)
    kit = PaddleKit()
    sample = kit._sample
    kit._sample = lambda: replace(sample(), time_us=0)
    runner = BoardRunner(kit)
    runner.open()
    with pytest.raises(AbortedError, match="too slowly"):
        runner.record(1.0)
    assert not kit.streaming


def test_while_idle_the_motor_is_off_and_only_samples_for_drawing_are_kept(runner):
    runner.idle(lambda: runner.board.seq >= 12_000)
    assert set(runner.board.forces) == {0.0}
    assert len(runner.recent) == board_runner.RECENT_SAMPLES
    assert not runner.board.streaming


def test_a_lost_stream_command_is_repeated(runner):
    samples, deaf = runner.board.samples, [1]

    def once_more(silence=1.0):
        if deaf[0]:
            deaf[0] -= 1
            raise NoDataError("Silent.")
        yield from samples(silence)

    runner.board.samples = once_more
    assert len(runner.record(0.05)) > 40
    deaf[0] = 2
    with pytest.raises(NoDataError):
        runner.record(0.05)
    assert not runner.board.streaming
