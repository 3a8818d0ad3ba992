"""The virtual board as a device of the studio: found, started, held by a hand, ended."""

import os
import time

import numpy as np
import pytest

from hapkit_studio import devices
from hapkit_studio.devices import virtual_board
from hapkit_studio.devices.virtual_board import VirtualBoard
from hapkit_studio.dynamics.hand import GRIPS
from hapkit_studio.errors import DeviceError, ParameterError
from tests.firmware.vb import needs_board
from tests.firmware.vb_host import exchange
from tests.waiting import wait_until

pytestmark = needs_board


@pytest.fixture
def board(tmp_path):
    board = VirtualBoard("fast", log=tmp_path / "truth.f64")
    board.open()
    yield board
    board.close()


def test_it_is_in_the_list_where_it_is_built():
    entry = next(e for e in devices.available() if e.key == "virtual-board")
    assert isinstance(entry.make(), VirtualBoard)
    assert not entry.make().simulated


def test_it_is_not_in_the_list_where_it_is_not_built(monkeypatch, tmp_path):
    monkeypatch.setenv(virtual_board.VARIABLE, str(tmp_path / "virtual_board"))
    assert not virtual_board.built()
    assert "virtual-board" not in [e.key for e in devices.available()]
    with pytest.raises(DeviceError, match="not built"):
        VirtualBoard().open()


def test_its_constants_come_from_the_firmware(board):
    assert board.max_force == 3.0
    assert board.rate == 1000.0
    assert board.quantum == pytest.approx(20.74e-6, rel=1e-3)
    assert board.full_force == pytest.approx(3.0093, rel=1e-4)


def test_a_hand_leads_the_handle_and_lets_go(board):
    board.move_hand(np.float64(0.01), "firm")
    wait_until(lambda: abs(board.status()["position"] - 0.01) < 0.1 / GRIPS["firm"].stiffness)
    board.move_hand(-0.02)
    wait_until(lambda: abs(board.status()["position"] + 0.02) < 0.1 / GRIPS["firm"].stiffness)
    assert board.status()["hand_force"] != 0.0
    board.move_hand(None)
    wait_until(lambda: board.status()["hand_force"] == 0.0)
    board.move_hand(0.0)
    wait_until(lambda: board.status()["hand_force"] != 0.0)
    board.set_grip("released")
    wait_until(lambda: board.status()["hand_force"] == 0.0)


def test_an_unknown_grip_is_refused(board):
    with pytest.raises(ParameterError, match="iron"):
        board.set_grip("iron")


def test_the_truth_log_can_be_read_while_it_grows(board, tmp_path):
    wait_until(lambda: board.flush() > 20)
    rows = board.flush()
    log = virtual_board.truth(tmp_path / "truth.f64")
    assert len(log) >= rows
    np.testing.assert_allclose(np.diff(log.time), 1e-3, atol=2e-6)


def test_closing_ends_and_reaps_the_program(board):
    pid = board.pid
    board.close()
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)
    assert board.summary["cycles"] > 0
    assert not board.send("status")
    board.close()


def test_an_unknown_mode_is_refused():
    with pytest.raises(DeviceError, match="paced, lockstep, fast"):
        VirtualBoard("slow")


def test_a_host_that_hesitates_in_lockstep_is_counted():
    patience, period = 0.05, 0.001
    begin = time.monotonic()
    board = VirtualBoard("lockstep", options=["--answer-timeout", str(patience)])
    board.open()
    board.start_stream()
    exchange(board.fileno(), 0.05, lambda s: 1.0)
    left, before = time.monotonic(), board.status()["time"]
    wait_until(lambda: board.status()["time"] > before + 5.5 * period)
    passed, hesitated = board.status()["time"] - before, time.monotonic() - left
    board.close()
    # a sample period each time its patience ends
    assert passed <= (hesitated / patience + 2) * period
    assert passed / period - 2 <= board.summary["unanswered"] <= (time.monotonic() - begin) / patience
