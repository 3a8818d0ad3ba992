"""Flashing from the window with the real avrdude and a real boot loader in the virtual board."""

import contextlib
from dataclasses import replace
from functools import partial

import pytest

from hapkit_studio.devices import DeviceEntry, avrdude, flash, serial_ports
from hapkit_studio.devices.flash import shipped
from hapkit_studio.devices.hapkit import HapkitBoard
from hapkit_studio.devices.profiles import of_settings
from hapkit_studio.devices.serial_ports import Port, Role
from hapkit_studio.gui.wizard.flash_dialog import FlashDialog
from hapkit_studio.protocol.messages import PROTOCOL_VERSION, Origin
from tests.firmware import boot
from tests.gui.window_support import SIMULATED

SOON = 1_000_000
"""bit/s: speed of a boot loader that receives a whole firmware quickly."""


@pytest.fixture
def window(reset_window):
    """Return this test file's window with a running simulated device."""
    return reset_window


def sheet_of(window):
    window.actions_by_key.run("device.flash")
    return window.findChildren(FlashDialog)[-1]


def test_nothing_can_be_flashed_without_a_port_or_firmware(window, tmp_path, monkeypatch):
    monkeypatch.setattr(serial_ports, "ports", list)
    monkeypatch.setattr(avrdude, "find", lambda given=None: avrdude.Avrdude("/usr/bin/avrdude"))
    window.notices.flash.emit()
    sheet = window.findChildren(FlashDialog)[-1]
    assert sheet.isVisible()
    assert not sheet.write.isEnabled()
    text = "No serial port was found. Plug in the board, then press Search ports again."
    assert sheet.verdict.label.text() == text
    assert not sheet.ports.isEnabled()
    assert sheet.ports.placeholderText() == "No serial port found"
    assert not sheet.bar.isVisible()
    port, there = Port("/dev/ttyUSB0", "Hapkit board (FT232)", Role.KIT), shipped()
    monkeypatch.setattr(serial_ports, "ports", lambda: [port])
    monkeypatch.setattr(flash, "shipped", lambda: tmp_path / "firmware" / "hapkit.hex")
    sheet.again.click()
    text = "The firmware of Hapkit Studio, firmware/hapkit.hex, is missing. Install Hapkit Studio again."
    assert sheet.verdict.label.text() == text
    assert not sheet.write.isEnabled()
    monkeypatch.setattr(flash, "shipped", lambda: there)
    sheet.again.click()
    assert sheet.verdict.label.text() == "Ready to flash the firmware."
    assert sheet.write.isEnabled()
    assert sheet.ports.currentText() == "ttyUSB0: Hapkit board (FT232)"


def test_without_avrdude_the_dialog_explains_how_to_install_it(window, monkeypatch):
    monkeypatch.setattr(serial_ports, "ports", list)
    monkeypatch.setattr(avrdude, "_FOLDERS", {})
    monkeypatch.setattr(avrdude.shutil, "which", lambda *args, **more: None)
    sheet = sheet_of(window)
    assert not sheet.write.isEnabled()
    assert "apt install avrdude" in sheet.verdict.label.text()
    assert "choose it here" in sheet.verdict.label.text()
    monkeypatch.setattr(avrdude, "find", lambda given=None: avrdude.Avrdude(given))
    sheet.use("/opt/avrdude")
    assert sheet.where.text() == "/opt/avrdude"


@pytest.mark.slow
@boot.needs_avrdude
def test_a_board_in_use_is_released_flashed_and_reopened_with_its_settings(
    make_window, qtbot, tmp_path, monkeypatch
):
    board = boot.Board(tmp_path, boot.optiboot(tmp_path, SOON), firmware=shipped())
    monkeypatch.setattr(flash, "flash", partial(flash.flash, speeds=(SOON,)))
    monkeypatch.setattr(serial_ports, "ports", list)
    entry = DeviceEntry(board.port, "Hapkit on port", lambda: HapkitBoard(board.port))
    try:
        with contextlib.closing(HapkitBoard(board.port)) as kit:
            kit.open()
            kit.configure(replace(of_settings(kit.settings()), label="Mine", max_force=1.5))
            assert kit.save().origin == Origin.STORED
        window = make_window(entries=(SIMULATED, entry))
        window.studio.device.open(entry)
        qtbot.waitUntil(lambda: window.studio.engine is not None)
        sheet, seen = sheet_of(window), []
        assert sheet.ports.currentData() == board.port
        sheet.bar.valueChanged.connect(seen.append)
        sheet.write.click()
        assert window.studio.link.state == "idle"
        assert window.header.devices.word.text() == "In use: flashing firmware"
        assert window.status.loop.label.text() == "In use: flashing firmware"
        assert not sheet.close()  # an interrupted flash would leave no working firmware
        qtbot.waitUntil(lambda: not sheet.job.running)
        assert sheet.bar.value() == sheet.bar.maximum()
        assert not sheet.write.isEnabled()  # the board has not identified itself yet
        assert len(seen) > 4
        assert seen == sorted(seen)
        qtbot.waitUntil(lambda: window.studio.engine is not None)
        hello, text = window.studio.engine.device.hello, sheet.verdict.label.text()
        assert f"The board answers with firmware {hello.build}, protocol version {PROTOCOL_VERSION}" in text
        assert hello.build.encode() in flash.read_image(shipped())
        assert (hello.origin, hello.max_force) == (Origin.STORED, 1.5)
        assert sheet.write.isEnabled()
        assert sheet.write.text() == "Flash firmware"
        assert sheet.close()
        window.close()
    finally:
        board.end()


@pytest.mark.slow
@boot.needs_avrdude
def test_a_failed_flash_shows_the_reason_and_can_be_repeated(window, qtbot, tmp_path, monkeypatch):
    board = boot.Board(tmp_path, boot.of_another_chip(tmp_path))
    monkeypatch.setattr(serial_ports, "ports", lambda: [Port(board.port, "board", Role.KIT)])
    sheet = sheet_of(window)
    sheet.write.click()
    assert window.studio.link.state == "running"  # the window uses a different device
    qtbot.waitUntil(lambda: not sheet.job.running)
    assert "a different chip (signature 1e940f)" in sheet.verdict.label.text()
    assert sheet.write.text() == "Flash firmware again"
    assert sheet.write.isEnabled()
    board.end()
