"""A law that is looked through for longer than the hardware watchdog waits: it begins, nothing is reset."""

import struct
from types import SimpleNamespace

import numpy as np

from hapkit_studio.laws import machine
from hapkit_studio.laws.machine import ARENA, EQUAL, MOST_JUMPS, RAMP, RAMPS
from hapkit_studio.protocol.messages import Sample, Stream, Telemetry
from tests.firmware.faults_turns import Turns
from tests.firmware.test_stack import Talk
from tests.firmware.vb import needs_board

pytestmark = needs_board

OPCODES = {operation.name: operation.code for operation in machine.OPERATIONS}
WATCHDOG = 0.016


def long_law():
    """Return a law that fills the arena, as many jumps under way from its beginning to its end as can be."""
    size = ARENA - 4 * 3 - RAMPS * RAMP
    code = bytearray([OPCODES["MAIN"]])
    jumps = []
    for _ in range(MOST_JUMPS - 1):
        code += bytes([OPCODES["TEST"] | EQUAL, 3, OPCODES["FAR_JUMP"], 0, 0])
        jumps.append(len(code))
    code += bytes([OPCODES["ABSOLUTE"]]) * (size - 1 - len(jumps) - len(code))
    for at in jumps:
        code[at - 2 : at] = struct.pack("<H", len(code) - at)
        code += bytes([OPCODES["ABSOLUTE"]])
    code += bytes([OPCODES["RETURN"]])
    data = struct.pack("<f", 1.0) + code
    return SimpleNamespace(states=0, given=(1.0,), slots=3, code=bytes(code), data=data)


def test_a_law_that_takes_long_to_look_through_begins(tmp_path):
    turns = Turns(tmp_path, ())
    talk = Talk(turns)
    talk.say(Stream(1, 0))
    talk.load(long_law(), 500, 1)
    turns.end()
    times = np.array([m.time_us for m in talk.heard if isinstance(m, Sample | Telemetry)]) * 1e-6
    assert np.all(np.diff(times) > 0.0)
    assert np.diff(times).max() > WATCHDOG
