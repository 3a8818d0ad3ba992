"""Another program on the board than the studio's: told in words, and no force, whatever it says."""

from pathlib import Path

import numpy as np
import pytest

from hapkit_studio.devices.virtual_board import VirtualBoard, truth
from hapkit_studio.errors import NotAHapkitError, WrongProtocolError
from hapkit_studio.protocol.framing import encode
from hapkit_studio.protocol.messages import PROTOCOL_VERSION, Hello
from tests.devices.fake_board import HELLO_FIELDS
from tests.firmware.vb import chip, needs_compiler

pytestmark = needs_compiler

OLD, NEW = (encode(Hello(**HELLO_FIELDS | {"version": PROTOCOL_VERSION + step})) for step in (-1, 1))
TEXT = b"pos 0.0123 m, force -0.45 N\r\n"
"""What the sketches of a course print."""
HANDSHAKE = 0.6
PATIENCE = 30.0
"""s for a Hello that comes at some time."""


def refused(folder: Path, name: str, said: bytes = b"", seconds: float = HANDSHAKE) -> type[Exception]:
    """Connect to a board with another program; return how it was refused, the motor off all the while."""
    log = folder / "truth.f64"
    options = ("--log-period", "1e-3")
    board = VirtualBoard("fast", log=log, firmware=chip(name, folder, said), options=options)
    with pytest.raises((NotAHapkitError, WrongProtocolError)) as caught:
        board.open(seconds)
    assert board.summary["seconds"] > 0.0
    assert not np.any(truth(log).duty)
    assert str(caught.value).count("\n") == 0
    return caught.type


@pytest.mark.parametrize("name", ["chatter", "asleep"])
def test_noise_and_silence_are_no_hapkit(tmp_path, name):
    assert refused(tmp_path, name) is NotAHapkitError


def test_a_sketch_that_prints_text_is_no_hapkit(tmp_path):
    assert refused(tmp_path, "says", TEXT) is NotAHapkitError


@pytest.mark.parametrize("hello", [OLD, NEW], ids=["older", "newer"])
def test_another_version_is_told_from_another_program(tmp_path, hello):
    assert refused(tmp_path, "says", hello, PATIENCE) is WrongProtocolError
