"""Export of a sketch from the window: which values, which kit, which folder."""

import re

import pytest

from hapkit_studio.devices import profiles
from hapkit_studio.gui.shell.export_dialog import ExportDialog
from hapkit_studio.gui.widgets import breakpoints
from hapkit_studio.workshop.sketch import Kit


@pytest.fixture
def window(reset_window):
    """Return the window whose simulated device runs."""
    return reset_window


@pytest.fixture
def sheet(window):
    """Return the export dialog, opened from the menu."""
    window.actions_by_key.run("environment.export")
    return window.findChildren(ExportDialog)[-1]


@pytest.mark.slow
def test_it_writes_the_panels_values_at_the_time_of_saving(window, sheet, tmp_path):
    window.studio.choose("wall")
    window.studio.set_values({"stiffness": 430.0})
    assert sheet.what.text() == "Wall, with the values of the panel"
    assert sheet.y() >= window.mapToGlobal(window.banners.pos()).y() + 2 * breakpoints.BANNER_HEIGHT
    sheet.write(str(tmp_path / "mine.ino"))
    text = (tmp_path / "mine" / "mine.ino").read_text("utf-8")
    assert "stiffness = 430.0f" in text
    assert f"Saved mine/mine.ino in {tmp_path}." in sheet.verdict.label.text()


@pytest.mark.slow
def test_a_law_with_much_arithmetic_gets_a_lower_rate(window, sheet):
    assert "kRate = 1000" in sheet.text()
    window.studio.choose("mass_spring_damper")
    window.studio.set_values({"integrator": 7.0})
    assert sheet.rates.itemText(0).startswith("250 Hz")
    assert "kRate = 250" in sheet.text()
    sheet.rates.setCurrentIndex(sheet.rates.findData(500))
    assert "kRate = 500" in sheet.text()


@pytest.mark.slow
def test_kit_and_printing_can_be_chosen(window, sheet):
    kits = [sheet.kits.itemText(at) for at in range(sheet.kits.count())]
    assert kits == [kit.title for kit in profiles.KITS]  # all kits are offered, because no kit is connected
    sheet.kits.setCurrentIndex(kits.index("Hapkit with AS5048A"))
    sheet.prints.setCurrentIndex(2)
    text = sheet.text()
    assert "kCountsPerRepeat = 16384" in text
    assert "kPrintsPerSecond = 0" in text


def test_an_unsupported_estimator_is_replaced_with_a_message(window, sheet):
    window.studio.set_loop(estimator="foaw")
    assert "Kalman filter with constant gain, instead of" in sheet.velocity.text()
    assert "alpha-beta" in sheet.text()
    window.studio.set_loop(estimator="difference")
    assert sheet.velocity.text().endswith(", the same as in the loop")
    assert "ifference" in sheet.velocity.text()


@pytest.mark.slow
def test_a_warning_about_an_unstable_sketch_is_in_the_dialog_and_in_the_file(window, sheet, tmp_path):
    window.studio.choose("wall")
    window.studio.set_loop(estimator="difference")
    window.studio.set_values({"stiffness": 5000.0, "damping": 0.0})
    # limit K = 2 b / (T + 2 t) of a released handle without rendered damping; the delay t equals the period T
    limit = 2.0 * 0.5 / (1e-3 + 2e-3)
    text = sheet.verdict.label.text()
    assert "At 1,000 Hz" in text
    assert "In your hand, a push of more than" in text
    found = float(re.search(r"limit of ([\d,]+) N/m in your hand", text)[1].replace(",", ""))
    assert limit < found < 5000.0, "a hand damps"
    sheet.rates.setCurrentIndex(sheet.rates.findData(2000))
    assert "At 2,000 Hz" in sheet.verdict.label.text()
    sheet.rates.setCurrentIndex(sheet.rates.findData(1000))
    sheet.write(str(tmp_path / "stiff.ino"))
    assert "Saved stiff/stiff.ino" in sheet.verdict.label.text()
    assert "In your hand, a push of more than" in sheet.verdict.label.text()
    assert "In your hand, a push of more than" in (tmp_path / "stiff" / "stiff.ino").read_text("utf-8")
    window.studio.set_values({"stiffness": 100.0})
    assert "After you let go, the handle moves away" in sheet.verdict.label.text()


@pytest.mark.slow
@pytest.mark.parametrize("name", ["my wall.ino", "nowhere/at/all\0.ino"])
def test_an_invalid_name_gives_a_one_line_message(sheet, tmp_path, name):
    sheet.write(str(tmp_path / name))
    assert sheet.verdict.label.text().startswith("A sketch's name")
    assert not list(tmp_path.glob("**/*.ino"))


def test_the_connected_board_is_first_with_its_calibration(window, monkeypatch):
    kit = Kit(profiles.named("hapkit3-short").board, calibrated=True)
    monkeypatch.setattr("hapkit_studio.gui.shell.export_dialog.connected_kit", lambda studio: kit)
    window.show_export()
    sheet = window.findChildren(ExportDialog)[-1]
    assert sheet.kits.currentText() == "Connected kit: Hapkit short, calibrated"
    assert "kZero = 0" in sheet.text()
