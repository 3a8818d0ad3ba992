"""A person's own law built into the firmware: it is on the board, and the board renders it."""

import os
import shutil
import subprocess
from types import SimpleNamespace

import numpy as np
import pytest

from hapkit_studio.commands import firmware
from hapkit_studio.devices import virtual_board
from hapkit_studio.devices.virtual_board import VirtualBoard
from hapkit_studio.errors import AvrdudeMissingError, DeviceError, LawError, ParameterError, PortGoneError
from hapkit_studio.laws.cpp import CppLaw
from hapkit_studio.workshop import reading
from tests.firmware import sketches
from tests.firmware.board_runs import render
from tests.firmware.test_sketch import OWN
from tests.firmware.vb import QUANTUM

needs_tools = pytest.mark.skipif(
    not (virtual_board.built() and shutil.which("avr-g++") and shutil.which("make")),
    reason="no virtual board or no avr-gcc",
)

SLOPE = 70.0
LAW = OWN.replace(" - 2.0 * v", "")
"""Of position and memory alone: what it is at rest is exact."""


AT_ZERO = ("--magnet", str(921 - 51))
"""The magnet sits so that the sensor begins anew at the handle's zero."""


def given(file, output, **more):
    usual = {
        "own": [str(file)],
        "laws": ["wall"],
        "trust": True,
        "output": str(output),
        "flash": None,
        "avrdude": None,
    }
    return SimpleNamespace(**(usual | more))


@pytest.fixture
def own(tmp_path):
    """Return a person's file."""
    file = tmp_path / "ramp.py"
    file.write_text(LAW)
    return file


@needs_tools
def test_the_board_has_and_renders_a_persons_own_law(own, tmp_path):
    image = tmp_path / "own.hex"
    done = firmware.run(given(own, image))
    assert done.as_json["laws"] == ["wall", "ramp"]
    assert "of 32256 bytes" in done.text
    board = VirtualBoard("fast", firmware=image)
    board.open()
    try:
        laws = board.laws()
    finally:
        board.close()
    assert set(laws) == {"wall", "ramp"}
    assert laws["ramp"].fingerprint == CppLaw(reading.load_text(LAW, own).force, "ramp").fingerprint
    path = ("0.05 position 0.004 0.1", "0.3 position 0.02 0.2", "0.6 position 0.008 0.2")
    rows = render(tmp_path, "ramp", [SLOPE], 1000, 1.0, path, options=AT_ZERO, firmware=image).truth
    rest = rows[(rows.time > 0.85) & (rows.time < 1.0)]
    wanted = -SLOPE * (0.008 + 0.02)
    step = sketches.pwm_step(rest.duty)
    assert len(rest) > 100
    assert np.all(np.abs(rest.motor_force - wanted) <= step + 2 * SLOPE * QUANTUM)


def test_a_law_that_nobody_can_translate_is_refused_before_anything_is_built(tmp_path, monkeypatch):
    monkeypatch.setattr(subprocess, "run", None)
    file = tmp_path / "ramp.py"
    file.write_text(LAW.replace("s.far = x", "s.far = open('x')"))
    with pytest.raises(LawError, match=r"ramp\.py, line"):
        firmware.run(given(file, tmp_path / "out.hex"))


def test_a_law_that_the_studio_does_not_have_is_named(own, tmp_path, monkeypatch):
    monkeypatch.setattr(firmware, "_sources", lambda: tmp_path)
    with pytest.raises(ParameterError, match="There is no law wal; there are: free, spring"):
        firmware.run(given(own, tmp_path / "out.hex", laws=["wall", "wal"]))


def test_without_sources_or_tools_it_is_one_line(own, tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(DeviceError, match=r"needs avr-g\+\+ and make.*Or export a sketch"):
        firmware.run(given(own, tmp_path / "out.hex"))
    monkeypatch.setattr(firmware, "default_folder", lambda: tmp_path / "firmware" / "hapkit")
    with pytest.raises(DeviceError, match="sources are not here") as error:
        firmware.run(given(own, tmp_path / "out.hex"))
    assert "\n" not in str(error.value)


@pytest.mark.skipif(os.name != "posix", reason="another way to find programs")
def test_a_missing_avrdude_is_said_before_a_long_build(own, tmp_path, monkeypatch):
    monkeypatch.setattr(firmware, "_sources", lambda: tmp_path)
    with pytest.raises(AvrdudeMissingError, match="nowhere is no program"):
        firmware.run(given(own, tmp_path / "out.hex", flash="/dev/ttyUSB0", avrdude="nowhere"))


@pytest.mark.skipif(os.name != "posix", reason="another way to find programs")
def test_a_missing_port_is_said_before_a_long_build(own, tmp_path, monkeypatch):
    monkeypatch.setattr(firmware, "_sources", lambda: tmp_path)
    monkeypatch.setattr(firmware.avrdude, "find", lambda given: None)
    with pytest.raises(PortGoneError, match="ttyNONE7 is not there"):
        firmware.run(given(own, tmp_path / "out.hex", flash="/dev/ttyNONE7"))
    with pytest.raises(DeviceError, match="needs no flashing"):
        firmware.run(given(own, tmp_path / "out.hex", flash="simulated"))


def test_too_many_laws_for_the_chip_is_said_with_the_sizes():
    sizes = ["flash 33000 of 32256 bytes (102.3 %)", "RAM   900 of 2048 bytes (43.9 %), stack not counted"]
    error = firmware._refused("make: *** [sizes] Error 1", sizes)
    assert isinstance(error, LawError)
    assert "flash 33000 of 32256 bytes" in str(error)
    assert isinstance(firmware._refused("x.cpp:3: error: no", []), DeviceError)
