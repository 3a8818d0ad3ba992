"""Tests without a chip: avrdude is found, run and retried, its output is parsed, and images are checked."""

import os
import stat
import subprocess
import sys

import pytest
import serial

from hapkit_studio.devices import avrdude, flash
from hapkit_studio.devices.avrdude import VERIFYING, WRITING, Output
from hapkit_studio.errors import (
    AvrdudeMissingError,
    FlashError,
    ParameterError,
    PortBusyError,
    PortGoneError,
    PortPermissionError,
)

posix = pytest.mark.skipif(os.name != "posix", reason="pseudo-terminals and shell programs")
PORT = "/dev/ttyUSB0"
BAR = "#" * 50
SIGNED = "avrdude: Device signature = 0x1e950f (probably m328p)\n"
WROTE = SIGNED + f"avrdude: writing flash (912 bytes):\n\nWriting | {BAR} | 100% 0.17s\n\n"


def program(path, text="#!/bin/sh\n"):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    return path


@pytest.fixture
def nothing_there(tmp_path, monkeypatch):
    """Set PATH and HOME to empty folders, and return their parent folder."""
    monkeypatch.setenv("PATH", str(tmp_path / "bin"))
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.setattr(avrdude, "_FOLDERS", {"linux": avrdude._FOLDERS["linux"][:2]})
    return tmp_path


# --- find avrdude
@posix
def test_a_given_program_has_priority_and_must_exist(nothing_there):
    own = program(nothing_there / "own" / "avrdude")
    program(nothing_there / "bin" / "avrdude")
    assert avrdude.find(own).program == own
    with pytest.raises(AvrdudeMissingError, match="nowhere is not a program"):
        avrdude.find("nowhere")


@posix
def test_the_path_comes_before_the_arduino_ide(nothing_there):
    tools = nothing_there / "home/.arduino15/packages/arduino/tools/avrdude"
    old, new = (program(tools / version / "bin" / "avrdude") for version in ("6.3.0-arduino9", "6.10.0"))
    assert avrdude.find(system="linux").program == new  # version 6.10 is newer than 6.3
    new.unlink()
    assert avrdude.find(system="linux") == avrdude.Avrdude(old)
    on_path = program(nothing_there / "bin" / "avrdude")
    assert avrdude.find(system="linux").command == [str(on_path)]
    # the program was built for another folder, so the studio passes the path of its configuration
    chips = nothing_there / "etc" / "avrdude.conf"
    chips.parent.mkdir()
    chips.touch()
    assert avrdude.find(system="linux").command == [str(on_path), f"-C{chips}"]


@posix
def test_a_bundles_avrdude_is_found_last_with_its_list_of_chips(nothing_there, monkeypatch):
    own = program(nothing_there / "bundle" / "bin" / "avrdude")
    chips = nothing_there / "bundle" / "etc" / "avrdude.conf"
    chips.parent.mkdir()
    chips.touch()
    monkeypatch.setattr(avrdude, "AVRDUDE", own.parent)
    assert avrdude.find(system="linux").command == [str(own), f"-C{chips}"]
    on_path = program(nothing_there / "bin" / "avrdude")
    assert avrdude.find(system="linux") == avrdude.Avrdude(on_path)


@posix
@pytest.mark.parametrize(
    ("system", "remedy"), [("linux", "apt install avrdude"), ("darwin", "brew install"), ("win32", "winget")]
)
def test_installation_advice_is_one_line_per_system(nothing_there, system, remedy):
    with pytest.raises(AvrdudeMissingError, match=f"not found.*{remedy}") as error:
        avrdude.find(system=system)
    assert "\n" not in str(error.value)


# --- check the image
def image(folder, *lines):
    path = folder / "some.hex"
    path.write_text("\n".join(lines))
    return path


END = ":00000001FF"


def record(address, kind, data):
    whole = bytes([len(data), address >> 8, address & 255, kind]) + data
    return ":" + (whole + bytes([-sum(whole) & 255])).hex().upper()


def test_an_image_has_its_bytes_at_their_addresses(tmp_path):
    lines = (
        record(4, 0, b"abcd"),
        record(0, 2, b"\x00\x10"),
        record(0, 0, b"xy"),
        record(0, 3, bytes(4)),
        END,
    )
    data = flash.read_image(image(tmp_path, *lines))
    assert data == b"\xff\xff\xff\xffabcd" + b"\xff" * 248 + b"xy"
    # the image fills the flash exactly
    assert len(flash.read_image(image(tmp_path, record(0x7DFE, 0, b"ab"), END))) == flash.FLASH_BYTES


@pytest.mark.parametrize(
    ("lines", "text"),
    [
        (["hello"], "line 1: this is not a line"),
        ([":0000"], "line 1: this is not a line"),
        ([record(0, 0, b"abc"), record(3, 0, b"def")[:-1] + "0"], "line 2: the check sum is wrong"),
        ([record(0, 0, b"abc")], "incomplete .hex"),
        ([END], "incomplete .hex"),
        ([record(0, 9, b"abc"), END], "kind 9"),
        ([record(0x7DFF, 0, b"ab"), END], r"has 32,257 bytes; the chip has room for 32,256"),
    ],
)
def test_a_bad_image_is_refused_in_one_line(tmp_path, lines, text):
    with pytest.raises(ParameterError, match=text) as error:
        flash.read_image(image(tmp_path, *lines))
    assert "\n" not in str(error.value)


def test_missing_or_unreadable_images_give_a_one_line_error(tmp_path, monkeypatch):
    with pytest.raises(ParameterError, match=r"^Cannot read .*mine\.hex: No such file or directory\.$"):
        flash.image_of(tmp_path / "mine.hex")
    with pytest.raises(ParameterError, match=r"^Cannot read .*: Is a directory\.$"):
        flash.image_of(tmp_path)
    monkeypatch.setattr(flash, "shipped", lambda: tmp_path / "firmware" / "hapkit.hex")
    with pytest.raises(
        ParameterError, match=r"firmware/hapkit\.hex, is missing\. Install Hapkit Studio again"
    ):
        flash.image_of()


# --- parse avrdude's output
@pytest.mark.parametrize(
    ("text", "message"),
    [
        (WROTE + "avrdude: verification error, first mismatch at byte 0x0000\n         0x0c != 0xff\n",
         r"verification of the written firmware failed from 0x0000 on\. Flash again"),
        (WROTE + "avrdude warning: verification mismatch\n  device 0x34 != input 0x35 at addr 0x0002 (error)",
         r"failed: 0x34 instead of 0x35 at 0x0002\."),
        (SIGNED.replace("950f", "9406") + "avrdude: Expected signature for ATmega328P is 1E 95 0F",
         r"ttyUSB0 has a different chip \(signature 1e9406\)"),
        (SIGNED + "avrdude: error: something new\n", "avrdude failed on ttyUSB0"),
        (SIGNED + "avrdude error: cannot do it\n", r"failed on ttyUSB0: cannot do it\. Flash again"),
    ],
)  # fmt: skip
def test_each_failure_has_its_message(text, message):
    parser = Output(lambda stage, part: None)
    parser.feed(text)
    assert not parser.no_sync
    error = parser.error(PORT)
    assert isinstance(error, FlashError)
    with pytest.raises(FlashError, match=message):
        raise error


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ('avrdude: ser_open(): can\'t open device "/dev/ttyUSB0": Permission denied', PortPermissionError),
        ('avrdude: ser_open(): can\'t open device "/dev/ttyUSB0": Device or resource busy', PortBusyError),
        ('avrdude: ser_open(): can\'t open device "\\\\.\\COM3": Access is denied.', PortBusyError),
        ("avrdude OS error: cannot open port /dev/ttyUSB0: No such file or directory", PortGoneError),
    ],
)
def test_a_port_that_cannot_be_opened_is_the_ports_own_error(text, kind):
    parser = Output(lambda stage, part: None)
    parser.feed(text)
    assert isinstance(parser.error(PORT), kind)


def test_progress_grows_with_every_mark_and_completes():
    seen = []
    parser = Output(lambda stage, part: seen.append((stage, round(part, 2))))
    whole = (
        SIGNED
        + f"Reading | {BAR} | 100% 0.00s\n\nWriting | {BAR} | 100% 1.0s\n\nReading | {BAR} | 100% 1.0s\n"
    )
    for character in whole:
        parser.feed(character)
    steps = [round(k / 50, 2) for k in range(51)]
    assert seen == [(WRITING, part) for part in steps] + [(VERIFYING, part) for part in steps]
    in_two, seen[:] = Output(lambda stage, part: seen.append((stage, part))), []
    in_two.feed(whole[:150])
    in_two.feed(whole[150:])
    assert seen[-2:] == [(WRITING, 1.0), (VERIFYING, 1.0)]


# --- run avrdude
TALKER = f"""#!{sys.executable}
import sys, time
with open({{log!r}}, "a") as log:
    log.write(sys.argv[sys.argv.index("-b") + 1] + "\\n")
{{body}}
"""
DEAF = """print("avrdude warning: attempt 1 of 10: not in sync: resp=0x00", flush=True)
time.sleep(60)"""
OLD_ONLY = (
    """if "57600" in sys.argv:
    sys.exit(0)
"""
    + DEAF
)


@pytest.fixture
def talker(tmp_path):
    """Return a function that makes a fake avrdude, which logs the speed of each call."""

    def make(body):
        text = TALKER.format(log=str(tmp_path / "log"), body=body)
        return program(tmp_path / "avrdude", text)

    return make


@pytest.fixture
def port():
    """Return a serial port that is not in use."""
    ends = os.openpty()
    yield os.ttyname(ends[1])
    for end in ends:
        os.close(end)


def calls(tmp_path):
    return [int(line) for line in (tmp_path / "log").read_text().split()]


@posix
def test_the_older_boot_loaders_speed_is_tried_second(talker, port, tmp_path):
    small = image(tmp_path, record(0, 0, b"ab"), END)
    done = flash.flash(port, small, talker(OLD_ONLY))
    assert (done.speed, done.size) == (57600, 2)
    assert calls(tmp_path) == [115200, 57600]
    with pytest.raises(
        FlashError, match=r"does not answer at 115,200 or 57,600 baud\. Unplug.*Burn Bootloader"
    ):
        flash.flash(port, small, talker(DEAF))
    assert calls(tmp_path)[2:] == [115200, 57600] * flash.ROUNDS
    # the image overlaps the old boot loader
    large = image(tmp_path, record(flash.OLD_FLASH_BYTES, 0, b"a"), END)
    with pytest.raises(FlashError, match="does not answer at 115,200 baud"):
        flash.flash(port, large, talker(OLD_ONLY))
    assert calls(tmp_path)[2 + 2 * flash.ROUNDS :] == [115200] * flash.ROUNDS


@posix
def test_a_silent_avrdude_is_killed(talker, port, tmp_path, monkeypatch):
    monkeypatch.setattr(flash, "SILENCE", 0.3)
    silent = talker('print("Writing | ###", flush=True)\ntime.sleep(60)')
    with pytest.raises(FlashError, match=r"printed nothing for 0\.3 s"):
        flash.flash(port, image(tmp_path, record(0, 0, b"ab"), END), silent)


@posix
def test_a_busy_or_missing_port_is_reported_before_avrdude_runs(talker, port, tmp_path):
    small, tool = image(tmp_path, record(0, 0, b"ab"), END), talker(DEAF)
    with serial.Serial(port, exclusive=True), pytest.raises(PortBusyError):
        flash.flash(port, small, tool)
    with open(port, "rb", buffering=0) as reader:
        child = subprocess.Popen(["sleep", "60"], stdin=reader)  # this process reads the port without a lock
    try:
        with pytest.raises(PortBusyError, match=rf"is used by sleep \(process {child.pid}\)"):
            flash.flash(port, small, tool)
    finally:
        child.kill()
        child.wait()
    with pytest.raises(PortGoneError, match=r"ttyUSB9 does not exist\. Plug the board in"):
        flash.flash(str(tmp_path / "ttyUSB9"), small, tool)
    assert not (tmp_path / "log").exists()
