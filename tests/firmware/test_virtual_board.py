"""The virtual board: its cable, its port byte by byte, its time, injected faults, and its exit."""

import json
import math
import os
import select
import signal
import subprocess
import time
from contextlib import ExitStack
from functools import cache

import numpy as np
import pytest

from hapkit_studio import devices
from hapkit_studio.devices import virtual_board
from hapkit_studio.devices.virtual_board import VirtualBoard
from hapkit_studio.dynamics.hand import ARRIVES, GRIPS, LEADS
from hapkit_studio.errors import DeviceError, ParameterError
from tests.firmware.vb import Host, chip, duty_step, exchange, needs_compiler, opened, run, started
from tests.waiting import PATIENCE, wait_until

pytestmark = needs_compiler

BYTE_CYCLES = 160
"""Cycles per byte: ten bits at 1 Mbaud and 16 MHz."""
UNKNOWN_MODE = 3
UDRE, TXC = 1 << 5, 1 << 6


@pytest.fixture(scope="module")
def images(tmp_path_factory):
    """Return a function that compiles a small program; each program is compiled once."""
    return cache(lambda name, **defined: chip(name, tmp_path_factory.mktemp(name), **defined))


@pytest.fixture
def start(images, tmp_path):
    """Return a function that starts a board with a small program, and with a host at its port."""
    with ExitStack() as running:
        yield lambda name, *options, **defined: running.enter_context(
            started(images(name, **defined), tmp_path, *options)
        )


# --- the board in the list of devices
def test_it_is_listed_only_if_it_is_built(monkeypatch, tmp_path):
    entry = next(e for e in devices.available() if e.key == "virtual-board")
    assert isinstance(entry.make(), VirtualBoard)
    assert entry.make().motor
    monkeypatch.setenv(virtual_board.VARIABLE, str(tmp_path / "virtual_board"))
    assert "virtual-board" not in [e.key for e in devices.available()]
    with pytest.raises(DeviceError, match="not built"):
        VirtualBoard().open()
    with pytest.raises(DeviceError, match="paced, lockstep, fast"):
        VirtualBoard("slow")


def test_a_hand_leads_and_releases_the_handle_and_the_log_can_be_read_while_it_grows(tmp_path):
    near = 0.1 / GRIPS["firm"].stiffness
    with opened("fast", log=tmp_path / "truth.f64") as board:
        assert board.max_force == 3.0
        assert board.quantum == pytest.approx(20.74e-6, rel=1e-3)
        assert board.full_force == pytest.approx(3.0093, rel=1e-4)
        board.set_grip("firm")
        board.move_hand(np.float64(0.01))
        wait_until(lambda: abs(board.status()["position"] - 0.01) < near)
        board.move_hand(-0.02)
        wait_until(lambda: abs(board.status()["position"] + 0.02) < near)
        assert board.status()["hand_force"] != 0.0
        board.move_hand(None)
        wait_until(lambda: board.status()["hand_force"] == 0.0)
        board.move_hand(0.0)
        wait_until(lambda: board.status()["hand_force"] != 0.0)
        board.set_grip("released")
        wait_until(lambda: board.status()["hand_force"] == 0.0)
        with pytest.raises(ParameterError, match="iron"):
            board.set_grip("iron")
        rows = board.flush()
        log = virtual_board.truth(tmp_path / "truth.f64")
        assert len(log) >= rows > 20
        np.testing.assert_allclose(np.diff(log.time), 1e-3, atol=2e-6)
        pid = board.pid
        board.close()
        with pytest.raises(ProcessLookupError):
            os.kill(pid, 0)
        assert board.summary["cycles"] > 0
        assert not board.send("status")


@pytest.mark.parametrize("grip", ["light", "medium", "firm"])
def test_a_hand_that_presses_far_away_approaches_then_leads(tmp_path, grip):
    """A law renders a spring of 80 N/m.

    The handle overshoots by at most v / ω. v is the hand's speed, ω the natural frequency of handle and hand.
    """
    reach, stiffness, hand = 0.04, 80.0, GRIPS[grip]
    with opened(log=tmp_path / "truth.f64") as board:
        board.start_stream()
        quantum = board.quantum
        start = exchange(board.fileno(), 0.002, lambda s: 0.0)[-1].count
        for place, seconds in ((0.5 * reach, 0.1), (reach, 0.6), (-reach, 0.2)):
            board.set_grip(grip)
            board.move_hand(place)
            exchange(board.fileno(), seconds, lambda s: -stiffness * quantum * (s.count - start))
    log = virtual_board.truth(tmp_path / "truth.f64")
    log = log[log.hand_force != 0.0]
    speed = np.diff(log.hand_target) / np.diff(log.time)
    turn = np.argmax(speed < 0.0)
    assert speed[:turn].max() == pytest.approx(ARRIVES, rel=1e-3)
    assert -speed.min() == pytest.approx(LEADS, rel=1e-3)
    both = hand.stiffness + stiffness
    swing = ARRIVES / math.sqrt(both / (hand.mass + 0.044))
    most = stiffness * hand.stiffness / both * (reach + swing)
    assert np.all(np.abs(log.motor_force[:turn]) < most + 2.0 * duty_step(log.duty[:turn]))


def test_a_host_that_hesitates_in_lockstep_is_counted():
    patience, period = 0.05, 0.001
    begin = time.monotonic()
    with opened(options=["--answer-timeout", str(patience)]) as board:
        board.start_stream()
        exchange(board.fileno(), 0.05, lambda s: 1.0)
        left, before = time.monotonic(), board.status()["time"]
        wait_until(lambda: board.status()["time"] > before + 5.5 * period)
        passed, hesitated = board.status()["time"] - before, time.monotonic() - left
    # after each time-out without an answer, the board's time advances by one period
    assert passed <= (hesitated / patience + 2) * period
    assert passed / period - 2 <= board.summary["unanswered"] <= (time.monotonic() - begin) / patience


# --- the port
def test_bytes_arrive_at_the_rate_of_the_line_without_echo_or_translation(start):
    _, host = start("stamp", "--fast")
    assert host.read(1) == b"R"
    host.write(b"\r\n\x03\x04\x11\x13\x00\xff" * 4)
    stamps = np.frombuffer(host.read(64), "<u2")
    steps = np.diff(stamps).astype(int)  # the differences are uint16, and overflow together with the clock
    assert np.abs(steps - BYTE_CYCLES).max() <= 12  # the program polls every few cycles
    assert abs(steps.sum() - 31 * BYTE_CYCLES) <= 12
    assert not select.select([host.fd], [], [], 0.0)[0]


def test_a_late_reader_gets_three_bytes_and_the_others_are_counted(start):
    board, host = start("late", "--fast")
    assert host.read(1) == b"R"
    host.write(b"0123456789")
    assert host.read(4) == b"012!"
    host.write(b"abc")
    assert host.read(4) == b"abc."
    summary = json.loads(board.end())
    assert summary["overruns"] == 7
    assert summary["received"] == 13


def test_the_transmitter_takes_two_bytes_reports_their_end_and_loses_a_third(start):
    """The test follows the data sheet's description of the flag TXC0 (transmit complete) in UCSR0A.

    TXC0 requests an interrupt while it is set. The interrupt clears it, and so does writing a one to it.
    """
    board, host = start("pairs", "--fast", WAIT=1)
    found = host.read(9)
    gone, served, inside, behind, cleared = found[4:]
    assert found[:4] == b"1234"
    assert gone & (UDRE | TXC) == UDRE | TXC
    assert served == 1
    assert (inside | behind | cleared) & TXC == 0
    assert json.loads(board.end())["overwritten"] == 0
    board, host = start("pairs", "--fast", WAIT=0)
    assert host.read(7)[:2] == b"13"
    assert json.loads(board.end())["overwritten"] == 2


# --- the cable
def test_an_unplugged_cable_is_a_hang_up_and_a_closed_port_uses_no_processor_time(start):
    def ended():
        try:
            return os.read(host.fd, 4096) == b""
        except BlockingIOError:
            return False
        except OSError:
            return True

    def voluntary_switches():
        with open(f"/proc/{board.pid}/status", encoding="ascii") as status:
            return int(next(line.split()[1] for line in status if line.startswith("voluntary_ctxt")))

    board, host = start("chatter")
    host.read(10)
    board.send("unplug")
    wait_until(ended)
    board.send("plug")
    port = board.reply("port")
    again = Host(port)
    again.read(10)
    again.close()
    slept = voluntary_switches()
    # a program that polled the closed port without pauses would never sleep
    wait_until(lambda: voluntary_switches() - slept > 500)
    again = Host(port)
    again.read(10)
    again.close()


# --- time
def board_time(board):
    board.send("status")
    return json.loads(board.reply("status"))["time"]


@pytest.mark.slow
def test_paced_time_is_never_ahead_stops_while_frozen_and_does_not_catch_up_after_a_stall(start):
    board, _ = start("asleep")
    wait_until(lambda: board_time(board) > 0.0)
    before, early = time.monotonic(), board_time(board)
    wait_until(lambda: board_time(board) > early + 0.3)
    late, after = board_time(board), time.monotonic()
    assert late - early <= after - before + 1e-3
    board.send("freeze")
    first = board_time(board)
    time.sleep(0.05)
    assert board_time(board) == first
    board.send("resume")
    wait_until(lambda: board_time(board) > first)
    began, before = time.monotonic(), board_time(board)
    os.kill(board.pid, signal.SIGSTOP)
    time.sleep(0.4)
    os.kill(board.pid, signal.SIGCONT)
    wait_until(lambda: board_time(board) > before + 0.1)
    passed = board_time(board) - before
    assert passed <= time.monotonic() - began - 0.39
    summary = json.loads(board.end())
    assert summary["slipped"] >= 0.39
    assert summary["slips"] >= 1


def test_real_time_priority_is_given_up(start):
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1))
    except PermissionError:
        pytest.skip("no right to real-time priority")
    try:
        board, _ = start("asleep")
        assert os.sched_getscheduler(board.pid) == os.SCHED_OTHER
    finally:
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))


# --- injected faults of the line
SENT = 9998
"""Approximate number of bytes that a program sends in 0.1 s at 1 Mbaud."""


def test_bytes_leave_at_the_rate_of_the_line_and_are_damaged_at_the_given_probability(images, tmp_path):
    def chatter(*options, script=()):
        done = run(images("chatter"), tmp_path, "--seconds", "0.1", *options, script=script)
        assert done.code == 0, done.errors
        return done.summary

    assert 0.1 * 16e6 / BYTE_CYCLES - 3 <= chatter()["transmitted"] <= 0.1 * 16e6 / BYTE_CYCLES
    for kind in ("drop", "flip", "insert"):
        hurt = [chatter(f"--from-{kind}", "0.1", "--seed", seed)["hurt_from"] for seed in "112"]
        # the tolerance is five standard deviations
        assert abs(hurt[0] - 0.1 * SENT) < 5.0 * np.sqrt(0.09 * SENT)
        assert hurt[0] == hurt[1] != hurt[2]
    hurt = chatter("--from-burst", "0.002", "--from-length", "50")["hurt_from"]
    # bursts may overlap: a burst that begins within another one lasts until its own end
    assert 0.3 * SENT * 0.002 * 50 < hurt < 1.5 * SENT * 0.002 * 50
    for kind in ("lose", "garble", "add"):
        assert chatter(script=[f"0.05 from {kind} 7"])["hurt_from"] == 7
    script = ["0.02 from drop 1", "0.03 from drop 0"]
    assert chatter(script=script)["hurt_from"] == pytest.approx(1000, abs=3)


@pytest.fixture
def packets(start, tmp_path):
    """Return a function that runs a board which sends a frame of 11 bytes every millisecond.

    The function returns the times in s at which bytes arrived, and the number of bytes at each time.
    """

    def handed(*options, script=""):
        commands = tmp_path / "turns.txt"
        commands.write_text(script)
        board, host = start("ticker", "--turns", "--await", "0", "--script", str(commands), *options)
        sizes, before = [], 0
        for _ in range(60):
            now, all_of_them = board.reply("turn").split()
            sizes.append((float(now), int(all_of_them) - before))
            before = int(all_of_them)
            host.read(sizes[-1][1])
            board.send("go 0")
        return np.array([(t, size) for t, size in sizes[2:] if size]).T

    return handed


@pytest.mark.parametrize(
    ("latency", "sizes", "apart"),
    [(0.0, {11}, 1e-3), (0.016, {62}, 62 / 11 * 1e-3), (0.002, set(range(20, 25)), 2e-3)],
    ids=["no chip", "62 bytes", "timer"],
)
def test_a_usb_chip_waits_for_62_bytes_or_its_timer(packets, latency, sizes, apart):
    times, came = packets("--latency", str(latency))
    assert came.max() in sizes
    assert len(sizes) > 1 or set(came) == sizes
    np.testing.assert_allclose(np.diff(times), apart, atol=1.1e-3 if latency else 1e-4)
    assert np.mean(np.diff(times)) == pytest.approx(apart, rel=0.02)


def test_a_stall_passes_no_bytes_and_keeps_those_that_the_chip_can_store(packets):
    times, came = packets(script="0.01 from stall 0.1")
    first = np.flatnonzero(times > 0.0105)[0]
    assert times[first] >= 0.1099
    assert came[first] == 512


def test_the_sensor_is_stuck_noisy_and_jumps_as_requested(tmp_path):
    def readings(*options, script=()):
        done = run(virtual_board.firmware(), tmp_path, "--seconds", "0.5", *options, script=script)
        assert done.code == 0, done.errors
        return done.truth.time, done.truth.converter

    time, read = readings(script=["0.05 position 0.004 0.4", "0.2 sensor stuck 1", "0.3 sensor stuck 0"])
    assert np.ptp(read[(time > 0.2015) & (time < 0.2995)]) == 0
    assert np.ptp(read[time < 0.2]) > 50
    assert np.ptp(read[time > 0.3]) > 50
    time, read = readings("--sensor-noise", "4")
    assert np.std(read[time > 0.05]) == pytest.approx(4.0, rel=0.15)
    assert np.mean(read[time > 0.05]) == pytest.approx(351.0, abs=1.0)
    time, read = readings("--sensor-jump", "0.3")
    jumped = read[(read != 351) & (time > 0.05)]  # the sensor jumped by half a turn, or into the gap
    half = np.abs(np.abs(jumped - 351.0) - 460.0) <= 1.0
    gap = (jumped < 51) | (jumped >= 51 + 921)
    assert np.all(half | gap)
    assert half.any()
    assert gap.any()
    assert len(jumped) == pytest.approx(0.3 * 450, rel=0.25)


# --- failures and the end of the program
@pytest.mark.parametrize(
    ("timer", "a", "b"),
    [(0, 0x23, 0x01), (0, 0x21, 0x03), (0, 0x21, 0x09), (0, 0x20, 0x01), (0, 0x11, 0x01), (2, 0x23, 0x01),
     (2, 0x21, 0x04)],
    ids=["fast PWM", "prescaler 64", "top OCRA", "no PWM", "toggle", "D3, fast PWM", "D3, prescaler 64"],
)  # fmt: skip
def test_an_unknown_pwm_mode_ends_the_program_with_a_message(images, tmp_path, timer, a, b):
    image = images("mode", TIMER=timer, CONTROL_A=a, CONTROL_B=b)
    outcome = run(image, tmp_path, "--seconds", "0.1", "--pins", "3" if timer else "5")
    assert outcome.code == UNKNOWN_MODE
    assert f"TCCR{timer}A = 0x{a:02x}, TCCR{timer}B = 0x{b:02x}" in outcome.errors
    other = run(image, tmp_path, "--seconds", "0.01", "--pins", "5" if timer else "3")
    assert (other.code, other.errors) == (0, "")  # the other pin's mode has no effect


def test_it_ends_properly_after_a_signal_and_with_its_parent(images, tmp_path):
    link = tmp_path / "hapkit"
    command = [virtual_board.program(), images("asleep"), "--link", link]
    for end in ("signal", "input"):
        control = ["--control"] if end == "input" else []
        child = subprocess.Popen(
            [str(w) for w in [*command, *control]], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        assert child.stdout.readline() == f"port {os.readlink(link)}\n"
        if end == "signal":
            child.terminate()
        rest, _ = child.communicate(timeout=PATIENCE)  # communicate() closes the program's input
        assert child.returncode == 0
        assert json.loads(rest)["seconds"] >= 0.0
        assert not os.path.lexists(link)


@pytest.mark.parametrize(
    ("options", "line", "text"),
    [
        (["--mass", "-1"], "", "--mass goes from 1e-06 to 10, not -1"),
        (["--mass", "nan"], "", "--mass goes from"),
        (["--colour", "red"], "", "no such option: --colour"),
        *(((), f"0 {line}", line) for line in (
            "dance", "hand 1 2", "force nan", "to drop 2", "from drop", "from drop x", "to stall 0",
            "usb latency 2", "sensor stuck 2", "from drop 0 1",
        )),
        ((), "x force 1", "x force 1"),
    ],
)  # fmt: skip
def test_a_wrong_option_or_script_is_named(images, tmp_path, options, line, text):
    outcome = run(images("asleep"), tmp_path, "--seconds", "0.01", *options, script=[line] if line else [])
    assert outcome.code == 2
    assert text in outcome.errors


def test_a_file_that_is_not_a_firmware_is_refused(tmp_path):
    (tmp_path / "x.elf").write_text("no firmware")
    with pytest.raises(DeviceError, match="not a firmware"):
        VirtualBoard(firmware=tmp_path / "x.elf").open()
