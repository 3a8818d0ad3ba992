"""Firmware that hangs, in its tick or in its main program: the hardware watchdog switches the motor off."""

import numpy as np
import pytest

from hapkit_studio.devices.virtual_board import truth
from hapkit_studio.protocol.framing import Decoder, encode
from hapkit_studio.protocol.messages import Force, Sample, Stream
from tests.firmware.faults_turns import Turns
from tests.firmware.test_firmware import make
from tests.firmware.vb import needs_compiler

pytestmark = needs_compiler

HANGS_AT = 0.3
WATCHDOG = 0.025


def hung(folder) -> np.recarray:
    """Return the truth of a board that is told a force until it hangs."""
    turns = Turns(folder, (), ("--await", str(Sample.ID)), folder / "hapkit.elf")
    turns.say(encode(Stream(1, 0)))
    decoder = Decoder()
    while turns.time < HANGS_AT + 0.06:
        turns.turn()
        heard = [m for m in decoder.feed(turns.take(4096)) if isinstance(m, Sample)]
        turns.say(b"".join(encode(Force(m.seq, 0, 1.0)) for m in heard))
    turns.end()
    return truth(turns.log)


@pytest.mark.parametrize("where", [1, 2])
def test_a_hang_is_ended_with_the_motor_off_within_25_ms(tmp_path, where):
    built = make(f"BUILD={tmp_path}", f"DEFINES=-DHAPKIT_HANG={where}", f"{tmp_path}/hapkit.elf")
    assert built.returncode == 0, built.stderr
    rows = hung(tmp_path)
    before = (rows.time > HANGS_AT - 0.05) & (rows.time < HANGS_AT)
    assert np.all(rows.duty[before] != 0)
    again = rows.time[(rows.time > HANGS_AT) & (rows.duty == 0)]
    assert again.size > 0
    assert again[0] <= HANGS_AT + WATCHDOG
