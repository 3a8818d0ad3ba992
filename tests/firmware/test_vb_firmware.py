"""The real firmware in the virtual board: what it measures, what it drives, when it lets go."""

import itertools
import json
import os
import resource
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from hapkit_studio.devices.virtual_board import VirtualBoard, firmware, truth
from hapkit_studio.errors import PortGoneError
from tests.firmware.vb import FULL_FORCE, QUANTUM, needs_board, run
from tests.firmware.vb_host import exchange, rows_of, session
from tests.waiting import wait_until

pytestmark = needs_board

WATCHDOG = 0.025
LOG_PERIOD = 1e-4
SWEEP = ("0.1 position -0.05 0.25", "0.4 position 0.05 0.5", "1.0 position 0 0.04")
PUSH = ("0.1 hand 0.015 400 8 0.1 0.2", "0.6 hand -0.01 400 8 0.1 0.3")


def quiet(sample):
    return 0.0


def test_counts_follow_the_handle_over_its_whole_travel_and_back(tmp_path):
    samples, log, _ = session(tmp_path, 1.05, quiet, SWEEP)
    rows = rows_of(samples, log)
    counts = np.array([s.count for s in samples])
    assert np.ptp(rows.position) == pytest.approx(0.1)
    assert np.count_nonzero(np.abs(np.diff(rows.converter)) > 460) >= 9  # the sensor began anew
    moved = np.round(rows.position / QUANTUM - (counts - counts[0]), 6)
    assert np.ptp(moved) <= 1.0 + 1e-6


def test_the_sensor_is_a_saw_tooth_of_921_counts(tmp_path):
    _, log, _ = session(tmp_path, 1.05, quiet, SWEEP)
    tooth = 51 + np.floor(np.mod(log.position / QUANTUM + 300, 921))  # the magnet's place at the start: 300
    sure = np.abs(np.mod(log.position / QUANTUM, 1.0) - 0.5) < 0.499999
    np.testing.assert_array_equal(log.converter[sure], tooth[sure])
    assert 51 <= log.converter.min() < 60
    assert 960 < log.converter.max() <= 972


def test_a_magnet_turned_round_counts_backwards(tmp_path):
    options = ("--sensor-sign", "-1", "--magnet", "900")
    samples, log, _ = session(tmp_path, 0.6, quiet, SWEEP, options=options)
    counts = np.array([s.count for s in samples])
    moved = rows_of(samples, log).position / QUANTUM + (counts - counts[0])
    assert np.ptp(moved) <= 1.0 + 1e-6


def test_the_motors_force_is_the_laws_within_a_count_and_a_step(tmp_path):
    stiffness, forces, start = 120.0, {}, []

    def spring(sample):
        start.append(sample.count)
        forces[sample.seq] = -stiffness * QUANTUM * (sample.count - start[0])
        return forces[sample.seq]

    samples, log, summary = session(tmp_path, 1.2, spring, PUSH)
    rows = rows_of(samples, log)
    answered = [k for k in range(1, len(samples)) if samples[k].answered in forces and samples[k].delay_us]
    assert len(answered) > 1100
    found = rows.motor_force[answered]
    wanted = np.array([forces[samples[k].answered] for k in answered])
    assert np.abs(wanted).max() > 1.0
    # half a step of the duty, at duty d + 1/2: (2 d + 1) / 2 of 255^2
    step = FULL_FORCE * (np.abs(rows.duty[answered]) + 1.0) / 255.0**2
    assert np.all(np.abs(found - wanted) <= step)
    before = rows.position[[samples[k].answered - samples[0].seq for k in answered]] - rows.position[0]
    assert np.all(np.abs(found + stiffness * before) <= step + stiffness * QUANTUM)
    assert [s.pwm for s in samples] == rows.duty.astype(int).tolist()
    assert summary["overruns"] == summary["deaf"] == summary["unanswered"] == 0


def test_lockstep_runs_are_identical_bit_by_bit(tmp_path):
    logs, streams = [], []
    for name in ("one", "two"):
        folder = tmp_path / name
        folder.mkdir()
        samples, _, _ = session(folder, 0.8, lambda s: 0.002 * (400 - s.count), PUSH)
        streams.append(samples)
        logs.append((folder / "truth.f64").read_bytes()[: 64 * 800])
    assert streams[0] == streams[1]
    assert logs[0] == logs[1]
    assert np.ptp(np.frombuffer(logs[0])) > 0.0


def test_every_answer_in_lockstep_is_in_force_before_the_next_sample(tmp_path):
    samples, _, _ = session(tmp_path, 0.3, lambda s: 0.5)
    assert all(s.answered == s.seq - 1 for s in samples[1:])
    assert max(s.delay_us for s in samples[1:]) < 1000


def test_interrupts_are_never_off_for_long(tmp_path):
    *_, summary = session(tmp_path, 0.5, lambda s: 0.3, PUSH)
    assert 0 < summary["interrupts_off_cycles"] <= 250


@pytest.mark.parametrize("mode", ["paced", "lockstep"])
def test_a_killed_host_leaves_the_motor_off_within_25_ms(tmp_path, mode):
    log = tmp_path / "truth.f64"
    board = VirtualBoard(mode, log=log, options=("--log-period", str(LOG_PERIOD)))
    board.open()
    board.start_stream()
    root = str(Path(__file__).parents[2])
    words = [sys.executable, "-m", "tests.firmware.vb_host", board.port, "2.0"]
    host = subprocess.Popen(words, cwd=root)
    board._abandon()  # the port is the other program's now; nobody says goodbye
    try:
        wait_until(lambda: board.status()["motor_force"] > 1.9)
        pushed = board.status()["time"]
        os.kill(host.pid, signal.SIGKILL)
        host.wait()
        wait_until(lambda: board.status()["duty"] == 0)
        stopped = board.status()["time"]
        wait_until(lambda: board.status()["time"] > stopped + LOG_PERIOD)
    finally:
        host.kill()
        board.end()
    rows = truth(log)
    end = np.flatnonzero(rows.duty)[-1] + 1
    assert rows.time[end] >= pushed
    off = rows.time[end] - board.summary["last_byte"]
    assert 0.5 * WATCHDOG < off <= WATCHDOG + LOG_PERIOD
    assert board.summary["silent_offs"] >= 1


def test_a_pulled_cable_leaves_the_motor_off_and_a_new_one_serves(tmp_path):
    log = tmp_path / "truth.f64"
    board = VirtualBoard("paced", log=log)
    board.open()
    board.start_stream()
    exchange(board.fileno(), 0.1, lambda s: 1.0)
    assert board.status()["duty"] > 0
    board.unplug()
    wait_until(lambda: board.status()["duty"] == 0)
    with pytest.raises(PortGoneError):
        wait_until(board.start_stream)
    board._abandon()
    board.plug()
    super(VirtualBoard, board).open()
    board.start_stream()
    assert len(exchange(board.fileno(), 0.1, quiet, halves=1)) >= 100
    board.close()
    assert json.dumps(board.summary)


@pytest.mark.slow
def test_five_seconds_in_lockstep_lose_no_frame(tmp_path):
    samples, _, summary = session(tmp_path, 5.0, lambda s: 0.3)
    assert [(b.seq - a.seq) & 0xFFFF for a, b in itertools.pairwise(samples)] == [1] * (len(samples) - 1)
    assert summary["frames"] >= 5000
    assert summary["dropped"] == summary["overwritten"] == 0


def test_board_time_passes_faster_than_real_time(tmp_path):
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    assert run(firmware(), tmp_path, "--seconds", "4").summary["seconds"] == pytest.approx(4.0, abs=2e-6)
    busy = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    assert 4.0 / busy > 1.5  # of processor time: what else the machine does is not in it
