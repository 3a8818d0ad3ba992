"""Firmware that hangs, in its tick or in its main program: the hardware watchdog switches the motor off."""

import os
import select

import numpy as np
import pytest

from hapkit_studio.devices.virtual_board import VirtualBoard, truth
from hapkit_studio.protocol.framing import Decoder, encode
from hapkit_studio.protocol.messages import Force, Sample
from tests.firmware.test_firmware import make
from tests.firmware.vb import needs_compiler, wait_until
from tests.lateness import ATTEMPTS

pytestmark = needs_compiler

HANGS_AT = 0.3
WATCHDOG = 0.025


def hung(folder) -> np.recarray:
    """Return the truth of a board that is told a force until it hangs."""
    log = folder / "truth.f64"
    board = VirtualBoard("paced", log=log, options=("--log-period", "1e-4"), firmware=folder / "hapkit.elf")
    board.open()
    board.start_stream()
    decoder = Decoder()
    try:
        while board.status()["time"] < HANGS_AT + 0.05:
            if select.select([board.fileno()], [], [], 0.01)[0]:
                heard = decoder.feed(os.read(board.fileno(), 4096))
                newest = [encode(Force(m.seq, 0, 1.0)) for m in heard if isinstance(m, Sample)][-1:]
                os.write(board.fileno(), b"".join(newest))
        wait_until(lambda: board.status()["time"] > HANGS_AT + 0.06)
    finally:
        board.end()
    return truth(log)


def pushes(rows: np.recarray) -> bool:
    """Tell whether the motor was on as the board hung: a busy machine may be too late to tell it a force."""
    return bool(np.any(rows.duty[(rows.time > HANGS_AT - 0.05) & (rows.time < HANGS_AT)] != 0))


@pytest.mark.parametrize("where", [1, 2])
def test_a_hang_is_ended_with_the_motor_off_within_25_ms(tmp_path, where):
    built = make(f"BUILD={tmp_path}", f"DEFINES=-DHAPKIT_HANG={where}", f"{tmp_path}/hapkit.elf")
    assert built.returncode == 0, built.stderr
    rows = next(filter(pushes, (hung(tmp_path) for _ in range(ATTEMPTS))))
    again = rows.time[(rows.time > HANGS_AT) & (rows.duty == 0)]
    assert again.size > 0
    assert again[0] <= HANGS_AT + WATCHDOG
