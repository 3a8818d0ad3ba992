"""Computer or board on the command line."""

import json
import threading
import time
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from hapkit_studio.commands import live_run
from hapkit_studio.devices import DeviceEntry, flash
from hapkit_studio.devices.hapkit import HapkitBoard, probe
from hapkit_studio.devices.virtual_board import VirtualBoard, built
from hapkit_studio.haptics import arrays
from hapkit_studio.haptics.engine import Engine
from hapkit_studio.haptics.health import Fault
from hapkit_studio.protocol.framing import encode
from tests.devices.fake_board import FakeBoard, FakeKit
from tests.devices.slow_line import SlowLine
from tests.lateness import ATTEMPTS
from tests.test_cli import as_json, run
from tests.waiting import wait_until

needs_board = pytest.mark.skipif(not built(), reason="the virtual board is not built")


class Gone:
    """What a run asks of an engine whose device goes away after three looks."""

    def __init__(self):
        self.looks = 0

    @property
    def fault(self):
        self.looks += 1
        return Fault(arrays.DEVICE_GONE, "The device is gone.") if self.looks > 3 else None

    def read(self):
        return np.zeros((2, 3))


def test_a_run_ends_when_the_device_goes_away_and_keeps_what_came():
    engine = Gone()
    table, played = live_run.play(engine, engine, None, 3600.0)
    assert len(table) == 2 * (3 + 1)
    assert played < 3600.0
    assert live_run.fault_words(engine.fault) == (
        "The device is gone. Force is zero. Check the USB cable, then try again."
    )


def test_a_run_that_a_person_ends_keeps_what_came(capsys, tmp_path, monkeypatch):
    move, moves = Engine.move_hand, []

    def then_end(engine, target):
        moves.append(target)
        if len(moves) == 30:
            raise KeyboardInterrupt
        move(engine, target)

    monkeypatch.setattr(Engine, "move_hand", then_end)
    words = ("--device", "simulated", "--hand", "press", "--seconds", "600", "--csv", str(tmp_path / "x.csv"))
    code, out, err = run(capsys, "run", "wall", *words)
    assert (code, err) == (0, "")
    assert "s of 600 s by Ctrl-C." in out
    assert len((tmp_path / "x.csv").read_text().splitlines()) > 100
    assert moves[-1] is None


def test_a_flash_that_a_person_ends_says_what_to_do(capsys, monkeypatch):
    def ended(*_words):
        raise KeyboardInterrupt

    monkeypatch.setattr(flash, "flash", ended)
    code, _, err = run(capsys, "flash", "/dev/ttyUSB7")
    assert code == 2
    assert "ttyUSB7: ended in the middle. Half of a firmware may be on the board: flash it again" in err


def test_a_board_that_sends_nothing_is_said_so_with_the_next_step(capsys, monkeypatch):
    board = FakeBoard(FakeKit())
    monkeypatch.setattr(live_run, "_PATIENCE", 0.2)
    try:
        code, out, err = run(capsys, "run", "wall", "--device", board.path, "--seconds", "1")
    finally:
        board.unplug()
    assert (code, out) == (2, "")
    assert "says hello, but no sample came for 0.2 s. Press the board's reset button" in err


def test_old_firmware_names_the_command_that_updates_it(capsys):
    old = replace(FakeKit().hello(), version=1)
    board = FakeBoard(lambda message: encode(old))
    try:
        said = [
            run(capsys, "check", board.path)[2],
            probe(DeviceEntry(board.path, "", partial(HapkitBoard, board.path)))["text"],
        ]
    finally:
        board.unplug()
    for words in said:
        assert f"Update firmware. Run `hapkit-studio flash {board.path}`." in words


def test_a_fault_ends_a_run_with_a_code_of_its_own(capsys, monkeypatch):
    words = ("run", "wall", "--device", "simulated", "--seconds", "0.2")
    assert run(capsys, *words)[0] == 0
    fault = Fault(arrays.OVER_SPEED, "Fault: over-speed, 5.2 m/s (limit 5.0 m/s).")
    monkeypatch.setattr(Engine, "fault", property(lambda engine: fault if engine.heard else None))
    monkeypatch.setattr(Engine, "heard", False, raising=False)
    play = live_run.play

    def then_fault(engine, *given):
        engine.heard = True
        return play(engine, *given)

    monkeypatch.setattr(live_run, "play", then_fault)
    code, out, err = run(capsys, *words)
    assert (code, err) == (2, "")
    assert fault.text in out


@pytest.mark.alone
@needs_board
def test_the_board_renders_and_answers_sooner(capsys):
    for left in reversed(range(ATTEMPTS)):
        found = as_json(
            capsys, "run", "wall", "--device", "virtual-board", "--render", "board", "--hand", "press",
            "--seconds", "1", "--estimator", "kalman",
        )  # fmt: skip
        if not found["faults"] or not left:
            break
    assert found["render"] == "board"
    assert found["board"]["delay_us"] < 0.5 * found["computer"]["delay_us"]
    assert found["board"]["rate_Hz"] == 4000.0
    assert found["board"]["stiffness_limit"] > 2.0 * found["computer"]["stiffness_limit"]
    assert found["board_overruns"] == 0
    assert found["link"]["stale_forces"] == 0


@pytest.fixture
def line():
    """Return a maker of a line with a delay of so many s to the virtual board and from it, and its path."""
    made = []

    def make(to, back):
        board = VirtualBoard(options=["--stop", "0.05"])
        board.start()
        made.append((board, SlowLine(board.port, to, back)))
        return made[-1]

    yield make
    for board, slow in made:
        slow.close()
        board.end()


@pytest.mark.alone
@needs_board
def test_a_link_too_slow_for_the_computer_is_said_and_the_board_renders(capsys, line):
    board, slow = line(0.028, 0.028)  # where the machine is busy, fewer ms by the board's clock
    board.send("hand 0.010 400 8 0.1 0.3")
    words = ("run", "spring", "-p", "stiffness=120", "--device", slow.path, "--seconds", "3", "--json")
    code, out, _ = run(capsys, *words)
    found = json.loads(out)
    assert code == 2
    assert found["seconds"] < 1.5
    assert found["peak_force"] == 0.0
    assert "the board obeys none after 25 ms. Force is zero. Let the board render" in found["faults"][0]
    threading.Timer(2.5, board.send, ["hand -0.010 400 8 0.1 0.3"]).start()
    found = as_json(capsys, *words[:-1], "--render", "board")
    assert not found["faults"]
    assert found["peak_force"] > 0.5
    assert found["link"]["without_force_s"] == 0.0


@pytest.mark.alone
@needs_board
def test_a_spring_too_stiff_for_the_delay_is_said_at_once_and_in_the_result(capsys, line):
    _, slow = line(0.005, 0.005)
    _, out, err = run(
        capsys, "run", "spring", "-p", "stiffness=300", "--device", slow.path, "--seconds", "1.5", "--json"
    )
    words = "300 N/m are in force: it may swing. Lower the stiffness, or let the board render."
    assert words in err
    assert any(words in said for said in json.loads(out)["warnings"])


@pytest.mark.alone
@needs_board
def test_held_back_words_push_nobody_and_are_counted(capsys, line):
    """Bytes to the board are held back for 0.4 s while the handle is led through the spring's centre."""
    board, slow = line(0.0, 0.0)

    def hold():
        board.send("hand 0.012 400 8 0.1 0.3")
        wait_until(lambda: slow.passed > passed + 12_000)  # a second of forces
        slow.held = True
        board.send("hand -0.012 400 8 0.1 0.3")
        time.sleep(0.4)
        slow.held = False

    for _ in range(ATTEMPTS):
        passed, holding = slow.passed, threading.Thread(target=hold)
        holding.start()
        found = json.loads(run(capsys, "run", "spring", "--device", slow.path, "--seconds", "4", "--json")[1])
        holding.join()
        link = found["link"]
        if not found["faults"] and not link["motor_off"]["computer_busy"]:
            break
    assert not found["faults"]
    assert link["stale_forces"] > 0
    assert link["motor_off"]["board_watchdog"] >= 1
    assert link["motor_off"]["computer_busy"] == 0
    assert 0.3 < link["without_force_s"] < 1.5
    assert any("The board switched its motor off" in said for said in found["warnings"])
