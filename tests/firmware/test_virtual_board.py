"""The virtual board's program: its cable, its port to the byte, its time, how it fails and how it ends."""

import json
import os
import select
import signal
import subprocess
import time

import numpy as np
import pytest

from hapkit_studio.devices import virtual_board
from hapkit_studio.devices.virtual_board import BoardProgram
from hapkit_studio.errors import DeviceError
from tests.firmware.vb import Host, chip, needs_compiler, run
from tests.waiting import PATIENCE, wait_until

pytestmark = needs_compiler

BYTE_CYCLES = 160
"""10 bits at 1 Mbaud and 16 MHz."""
UNKNOWN_MODE = 3


@pytest.fixture
def start(tmp_path):
    """Return a function that starts a small program's board with a host at its port from the first cycle."""
    started, hosts = [], []
    still = tmp_path / "still.txt"
    still.write_text("0 freeze")

    def begin(name, *options):
        words = [virtual_board.program(), chip(name, tmp_path), "--control", "--script", still, *options]
        board = BoardProgram([str(w) for w in words])
        started.append(board)
        hosts.append(Host(board.reply("port")))
        board.send("resume")
        return board, hosts[-1]

    yield begin
    for board in started:
        board.end()
    for host in hosts:
        host.close()


# --- the port
def test_bytes_arrive_at_the_pace_of_the_line(start):
    _, host = start("stamp", "--fast")
    assert host.read(1) == b"R"
    host.write(bytes(32))
    stamps = np.frombuffer(host.read(64), "<u2")
    steps = np.diff(stamps).astype(int)  # as uint16 they wrap with the clock
    assert np.abs(steps - BYTE_CYCLES).max() <= 12  # the program looks every few cycles
    assert abs(steps.sum() - 31 * BYTE_CYCLES) <= 12


def test_bytes_leave_at_the_pace_of_the_line(tmp_path):
    sent = run(chip("chatter", tmp_path), tmp_path, "--seconds", "0.1").summary["transmitted"]
    assert 0.1 * 16e6 / BYTE_CYCLES - 3 <= sent <= 0.1 * 16e6 / BYTE_CYCLES


def test_a_late_reader_keeps_three_bytes_and_the_rest_is_counted(start):
    board, host = start("late", "--fast")
    assert host.read(1) == b"R"
    host.write(b"0123456789")
    assert host.read(4) == b"012!"
    host.write(b"abc")
    assert host.read(4) == b"abc."
    summary = json.loads(board.end())
    assert summary["overruns"] == 7
    assert summary["received"] == 13


def test_nothing_is_echoed_or_translated_by_the_cable(start):
    _, host = start("stamp", "--fast")
    assert host.read(1) == b"R"
    host.write(b"\r\n\x03\x04\x11\x13\x00\xff" * 4)
    host.read(64)
    ready, _, _ = select.select([host.fd], [], [], 0.0)
    assert not ready


# --- the cable
def test_an_unplugged_cable_is_a_hang_up_and_can_be_put_back(start):
    board, host = start("chatter")
    host.read(10)
    board.send("unplug")

    def ended():
        try:
            return os.read(host.fd, 4096) == b""
        except BlockingIOError:
            return False
        except OSError:
            return True

    wait_until(ended)
    board.send("plug")
    again = Host(board.reply("port"))
    again.read(10)
    again.close()


def test_the_link_leads_to_the_port_and_goes_with_it(tmp_path):
    link = tmp_path / "hapkit"
    words = [virtual_board.program(), chip("asleep", tmp_path), "--control", "--link", link]
    board = BoardProgram([str(w) for w in words])
    port = board.reply("port")
    assert os.readlink(link) == port
    board.end()
    assert not os.path.lexists(link)


def test_a_closed_port_does_not_keep_the_board_busy_and_can_be_opened_again(start):
    board, host = start("chatter")
    host.read(10)
    port = os.ttyname(host.fd)
    host.close()
    slept = voluntary_switches(board.pid)
    # a program that spins on the hang-up never goes to sleep
    wait_until(lambda: voluntary_switches(board.pid) - slept > 500)
    host.fd = os.open(port, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
    host.read(10)


def voluntary_switches(pid):
    with open(f"/proc/{pid}/status", encoding="ascii") as status:
        return int(next(line.split()[1] for line in status if line.startswith("voluntary_ctxt")))


# --- time
def board_time(board):
    board.send("status")
    return json.loads(board.reply("status"))["time"]


def test_a_stall_is_never_made_up_for_and_counted(start):
    board, _ = start("asleep")
    wait_until(lambda: board_time(board) > 0.0)
    began, before = time.monotonic(), board_time(board)
    os.kill(board.pid, signal.SIGSTOP)
    time.sleep(0.4)
    os.kill(board.pid, signal.SIGCONT)
    time.sleep(0.1)
    passed = board_time(board) - before
    assert passed <= time.monotonic() - began - 0.39
    summary = json.loads(board.end())
    assert summary["slipped"] >= 0.39
    assert summary["slips"] >= 1


def test_paced_time_is_not_ahead_of_the_clock(start):
    board, _ = start("asleep")
    wait_until(lambda: board_time(board) > 0.0)
    before, early = time.monotonic(), board_time(board)
    wait_until(lambda: board_time(board) > early + 0.3)
    late, after = board_time(board), time.monotonic()
    assert late - early <= after - before + 1e-3


def test_a_frozen_board_stands_still_until_resumed(start):
    board, _ = start("asleep")
    board.send("freeze")
    first = board_time(board)
    time.sleep(0.05)
    assert board_time(board) == first
    board.send("resume")
    wait_until(lambda: board_time(board) > first)


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


# --- failing and ending
@pytest.mark.parametrize(
    ("a", "b"),
    [(0x23, 0x01), (0x21, 0x03), (0x21, 0x09), (0x20, 0x01), (0x11, 0x01)],
    ids=["fast PWM", "prescaler 64", "top OCRA", "no PWM", "toggle"],
)
def test_an_unknown_pwm_mode_ends_the_program_loudly(tmp_path, a, b):
    outcome = run(chip("mode", tmp_path, CONTROL_A=a, CONTROL_B=b), tmp_path, "--seconds", "0.1")
    assert outcome.code == UNKNOWN_MODE
    assert f"TCCR0A = 0x{a:02x}, TCCR0B = 0x{b:02x}" in outcome.errors


def test_the_known_pwm_mode_runs(tmp_path):
    outcome = run(chip("mode", tmp_path, CONTROL_A=0x21, CONTROL_B=0x01), tmp_path, "--seconds", "0.1")
    assert (outcome.code, outcome.errors) == (0, "")
    assert outcome.summary["seconds"] == 0.1


def test_a_signal_ends_it_in_order(tmp_path):
    words = [virtual_board.program(), chip("asleep", tmp_path)]
    child = subprocess.Popen([str(w) for w in words], stdout=subprocess.PIPE, text=True)
    assert child.stdout.readline().startswith("port ")
    child.terminate()
    rest, _ = child.communicate(timeout=PATIENCE)
    assert child.returncode == 0
    assert json.loads(rest)["seconds"] >= 0.0


def test_it_ends_with_whoever_started_it(tmp_path):
    words = [virtual_board.program(), chip("asleep", tmp_path), "--control"]
    child = subprocess.Popen([str(w) for w in words], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    assert child.stdout.readline().startswith(b"port ")
    child.stdin.close()
    assert child.wait(timeout=PATIENCE) == 0
    child.stdout.close()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--mass", "-1"], "--mass goes from 1e-06 to 10, not -1"),
        (["--mass", "nan"], "--mass goes from"),
        (["--colour", "red"], "no such option: --colour"),
    ],
)
def test_a_wrong_option_is_named(tmp_path, options, words):
    outcome = run(chip("asleep", tmp_path), tmp_path, *options)
    assert outcome.code == 2
    assert words in outcome.errors


@pytest.mark.parametrize("line", ["0 dance", "0 hand 1 2", "0 force nan", "x force 1"])
def test_a_wrong_script_is_named(tmp_path, line):
    outcome = run(chip("asleep", tmp_path), tmp_path, "--seconds", "0.01", script=[line])
    assert outcome.code == 2
    assert line.removeprefix("0 ") in outcome.errors


def test_a_file_that_is_no_firmware_is_refused(tmp_path):
    (tmp_path / "x.elf").write_text("no firmware")
    with pytest.raises(DeviceError, match="not a firmware"):
        virtual_board.VirtualBoard(firmware=tmp_path / "x.elf").open()
