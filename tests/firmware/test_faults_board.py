"""What the virtual board does on purpose: damage at its rate, packets of the USB chip, a lying sensor."""

import numpy as np
import pytest

from hapkit_studio.devices import virtual_board
from hapkit_studio.devices.virtual_board import BoardProgram
from tests.firmware.vb import Host, chip, needs_compiler, run

pytestmark = needs_compiler

SENT = 9998
"""Bytes that a program sends in 0.1 s at 1 Mbaud, within a few."""


def summary(folder, *options, script=(), name="chatter", seconds="0.1"):
    done = run(chip(name, folder), folder, "--seconds", seconds, *options, script=script)
    assert done.code == 0, done.errors
    return done.summary


@pytest.mark.parametrize("kind", ["drop", "flip", "insert"])
def test_bytes_are_damaged_as_often_as_asked_for(tmp_path, kind):
    hurt = summary(tmp_path, f"--from-{kind}", "0.1")["hurt_from"]
    assert abs(hurt - 0.1 * SENT) < 5.0 * np.sqrt(0.09 * SENT)  # five standard deviations


def test_bursts_hurt_whole_runs_of_bytes(tmp_path):
    hurt = summary(tmp_path, "--from-burst", "0.002", "--from-length", "50")["hurt_from"]
    # a burst that begins within another one prolongs it to its own length
    assert 0.3 * SENT * 0.002 * 50 < hurt < 1.5 * SENT * 0.002 * 50


def test_the_same_seed_does_the_same_and_another_one_does_not(tmp_path):
    hurt = [summary(tmp_path, "--from-flip", "0.1", "--seed", seed)["hurt_from"] for seed in "1123"]
    assert hurt[0] == hurt[1]
    assert len(set(hurt)) > 1


@pytest.mark.parametrize("kind", ["lose", "garble", "add"])
def test_single_shots_hurt_as_many_bytes_as_asked_for(tmp_path, kind):
    assert summary(tmp_path, script=[f"0.05 from {kind} 7"])["hurt_from"] == 7


def test_a_fault_can_be_switched_off_again(tmp_path):
    script = ["0.02 from drop 1", "0.03 from drop 0"]
    assert summary(tmp_path, script=script)["hurt_from"] == pytest.approx(1000, abs=3)


@pytest.mark.parametrize(
    "line",
    [
        "to drop 2",
        "from drop",
        "from drop x",
        "to stall 0",
        "usb latency 2",
        "sensor stuck 2",
        "from drop 0 1",
    ],
)
def test_what_is_no_fault_is_refused(tmp_path, line):
    done = run(chip("asleep", tmp_path), tmp_path, "--seconds", "0.01", script=[f"0 {line}"])
    assert done.code == 2
    assert line in done.errors


# --- the USB chip
def packets(start, *options, script=()):
    """Return the bytes that each 1 ms of board time hands over, by turns."""
    board, host = start(*options, script=script)
    sizes, before = [], 0
    for _ in range(60):
        time, handed = board.reply("turn").split()
        sizes.append((float(time), int(handed) - before))
        before = int(handed)
        host.read(sizes[-1][1])
        board.send("go 0")
    return sizes


@pytest.fixture
def start(tmp_path):
    """Return a function that starts a sleeping or chattering program that takes turns with the test."""
    opened = []

    def begin(*options, script=()):
        commands = tmp_path / "script.txt"
        commands.write_text("\n".join(script))
        words = [virtual_board.program(), chip("ticker", tmp_path), "--turns", "--await", "0", *options]
        board = BoardProgram([str(w) for w in [*words, "--script", commands]])
        host = Host(board.reply("port"))
        opened.extend((board, host))
        return board, host

    yield begin
    for one in reversed(opened):
        one.end() if isinstance(one, BoardProgram) else one.close()


def test_without_a_usb_chip_every_frame_comes_at_once(start):
    sizes = packets(start)
    assert {size for _, size in sizes[2:]} == {11}
    np.testing.assert_allclose(np.diff([time for time, _ in sizes[2:]]), 1e-3, atol=1e-4)


def test_a_usb_chip_waits_for_62_bytes_or_its_timer(start):
    sizes = packets(start, "--latency", "0.016")
    assert {size for _, size in sizes[2:]} == {62}
    # 62 bytes come at 11 a ms
    np.testing.assert_allclose(np.mean(np.diff([t for t, _ in sizes[2:]])), 62 / 11 * 1e-3, rtol=0.02)


def test_a_short_timer_hands_over_what_is_there(start):
    sizes = packets(start, "--latency", "0.002")
    assert 20 <= max(size for _, size in sizes[2:]) <= 24  # two frames, and what is on its way
    np.testing.assert_allclose(np.diff([t for t, s in sizes[2:] if s]), 2e-3, atol=1.1e-3)


def test_a_stall_hands_nothing_over_and_keeps_what_the_chip_has_room_for(start):
    sizes = packets(start, script=["0.01 from stall 0.1"])
    held = [(t, s) for t, s in sizes if t > 0.0105]
    assert sum(s for t, s in held if t < 0.1099) == 0
    assert next(s for _, s in held if s) == 512


# --- the sensor
def readings(tmp_path, *options, script=()):
    done = run(virtual_board.firmware(), tmp_path, "--seconds", "0.5", *options, script=script)
    assert done.code == 0, done.errors
    return done


MOVE = ["0.05 position 0.004 0.4"]


def test_a_stuck_sensor_repeats_itself(tmp_path):
    log = readings(tmp_path, script=[*MOVE, "0.2 sensor stuck 1", "0.3 sensor stuck 0"]).truth
    stuck = log.converter[(log.time > 0.2015) & (log.time < 0.2995)]
    assert np.ptp(stuck) == 0
    assert np.ptp(log.converter[log.time < 0.2]) > 50
    assert np.ptp(log.converter[log.time > 0.3]) > 50


def test_a_noisy_sensor_has_the_deviation_asked_for(tmp_path):
    log = readings(tmp_path, "--sensor-noise", "4").truth
    settled = log.converter[log.time > 0.05]
    assert np.std(settled) == pytest.approx(4.0, rel=0.15)
    assert np.mean(settled) == pytest.approx(351.0, abs=1.0)


def test_a_flipping_sensor_jumps_half_a_turn_or_into_the_gap(tmp_path):
    log = readings(tmp_path, "--sensor-jump", "0.3").truth
    jumped = log.converter[(log.converter != 351) & (log.time > 0.05)]
    half = np.abs(np.abs(jumped - 351.0) - 460.0) <= 1.0
    gap = (jumped < 51) | (jumped >= 51 + 921)
    assert np.all(half | gap)
    assert half.any()
    assert gap.any()
    assert len(jumped) == pytest.approx(0.3 * 450, rel=0.25)
