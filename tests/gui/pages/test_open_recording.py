"""Recordings from files in the window: named columns, kept curves, identification."""

import numpy as np
import pytest
from PySide6.QtWidgets import QFileDialog

import hapkit_studio as hs
from hapkit_studio.gui.pages.open_recording import ColumnsDialog
from hapkit_studio.gui.state import prepare
from hapkit_studio.tables import TableColumn
from tests.analysis.identify.test_files import foreign
from tests.gui.shell.test_layout import cut_off
from tests.gui.window_support import sheets


@pytest.fixture(autouse=True)
def nothing_compiled(monkeypatch):
    """Prevent the page from starting a program that compiles."""
    monkeypatch.setattr(prepare, "begin", lambda *_, **__: None)


@pytest.fixture
def window(reset_idle_window):
    yield reset_idle_window
    for place in list(reset_idle_window.centre.kept_curves.curves):
        reset_idle_window.centre.kept_curves.remove(place)
    reset_idle_window.opener._named.clear()


@pytest.fixture
def lab(tmp_path):
    """Return another program's recording of a spring of 210 N/m, centred at 2 mm; its force is in mN."""
    path = tmp_path / "lab.csv"
    path.write_text(foreign())
    return path


def choose(window, path):
    """Choose a file in the file dialog, which is already open."""
    dialog = next(d for d in window.findChildren(QFileDialog) if d.isVisible())
    assert not dialog.isModal()
    dialog.fileSelected.emit(str(path))
    dialog.close()


def columns_sheet(window, qtbot):
    """Return the dialog of the columns once it is open."""
    found = lambda: [sheet for sheet in sheets(window) if isinstance(sheet, ColumnsDialog)]  # noqa: E731
    qtbot.waitUntil(lambda: bool(found()))
    return found()[-1]


@pytest.mark.slow
def test_a_foreign_table_is_held_in_the_plots_after_naming_its_columns(window, qtbot, lab):
    window.views.show("identify")
    window.actions_by_key.run("view.hold_file")
    choose(window, lab)
    sheet = columns_sheet(window, qtbot)
    assert {key: str(column) for key, column in sheet.columns.items()} == {
        "time": "t_ms:ms", "position": "x_mm:mm", "force": "F:N", "velocity": "dx_mms:mm/s",
    }  # fmt: skip
    assert sheet.names["time"].currentText() == "t_ms   (0,0000  1,0000  2,0000  3,0000 …)"
    assert cut_off(sheet) == []
    sheet.units["force"].setCurrentText("mN")
    sheet.take.click()
    kept = window.centre.kept_curves
    qtbot.waitUntil(lambda: bool(kept.curves))
    assert window.views.key == "live"
    (curve,) = kept.curves.values()
    assert curve.name == "lab.csv"
    assert curve.time[[0, -1]] == pytest.approx([-2.999, 0.0], abs=2e-3)
    t = curve.time + 2.999
    x = 8e-3 * np.sin(2.0 * np.pi * 0.83 * t) + 4e-3 * np.sin(2.0 * np.pi * 2.37 * t + 1.0)
    assert curve.values["position"] == pytest.approx(x, abs=2e-4)  # tolerance: motion within one pixel column
    v = curve.values["velocity"]
    assert curve.values["applied_force"] == pytest.approx(
        -210.0 * (curve.values["position"] - 2e-3) - 1.5 * v, abs=0.03
    )
    low, high = next(c for c in window.centre.time.canvases if c.plot_of.key == "force").view.viewRange()[1]
    assert low < curve.values["applied_force"].min() < curve.values["applied_force"].max() < high
    # the same columns need not be named again
    window.opener.open(str(lab))
    qtbot.waitUntil(lambda: bool([sheet for sheet in sheets(window) if isinstance(sheet, ColumnsDialog)]))
    assert str(columns_sheet(window, qtbot).columns["force"]) == "F:mN"


def test_a_table_with_the_studio_column_names_is_kept_without_asking(window, qtbot, tmp_path):
    path = tmp_path / "few.csv"
    path.write_text("time_s,position_m,force_applied_N\n0,0,0\n0.001,0.0001,-0.03\n0.002,0.0002,-0.06\n")
    window.opener.open(str(path))
    qtbot.waitUntil(lambda: bool(window.centre.kept_curves.curves))
    (trace,) = window.centre.kept_curves.curves.values()
    assert trace.values["applied_force"] == pytest.approx([0.0, -0.03, -0.06])
    assert trace.values["velocity"] == pytest.approx([0.1] * 3)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("time_s,position_m,force_applied_N\n0,0,0\n0,1,2\n", "bad.csv has times that decrease or repeat"),
        ("nothing", "bad.csv has 0 rows of numbers"),
    ],
)
def test_an_unreadable_file_is_reported_in_a_banner(window, qtbot, tmp_path, text, message):
    path = tmp_path / "bad.csv"
    path.write_text(text)
    window.opener.open(str(path))
    qtbot.waitUntil(lambda: window.banners.get("recording") is not None)
    notice = window.banners.get("recording")
    assert "No curve was kept." in notice.title
    assert message in notice.text
    assert not window.centre.kept_curves.curves


def test_the_dialog_opens_the_file_only_once_each_column_is_chosen_once(window, qtbot, tmp_path):
    path = tmp_path / "odd.csv"
    path.write_text("a;b;c\n0;1;2\n1;2;3\n")
    window.opener.open(str(path))
    sheet = columns_sheet(window, qtbot)
    assert sheet.verdict.label.text() == "Choose the column of the time and the position and the force."
    assert not sheet.take.isEnabled()
    for quantity, name in (("time", "a"), ("position", "b"), ("force", "b")):
        sheet.names[quantity].setCurrentIndex(sheet.names[quantity].findData(name))
    assert sheet.verdict.label.text() == (
        "Two quantities use the same column. Choose a different column for one of them."
    )
    assert not sheet.take.isEnabled()
    assert not sheet.units["velocity"].isEnabled()
    sheet.names["force"].setCurrentIndex(sheet.names["force"].findData("c"))
    assert sheet.take.isEnabled()
    assert sheet.columns == {
        "time": TableColumn("a", "s"),
        "position": TableColumn("b", "m"),
        "force": TableColumn("c", "N"),
    }
    sheet.leave.click()
    assert not window.centre.kept_curves.curves


@pytest.mark.slow
def test_a_file_is_identified_independently_of_the_window_settings(window, qtbot, lab, tmp_path):
    window.views.show("identify")
    page = window.views.page("identify")
    assert page.released.isHidden()
    page.opening.click()
    choose(page, lab)
    sheet = columns_sheet(window, qtbot)
    sheet.units["force"].setCurrentText("mN")
    sheet.take.click()
    qtbot.waitUntil(lambda: page.found is not None)
    assert page.found.rendered["stiffness"].value == pytest.approx(210.0, abs=0.3)
    assert page.answer.label.text().startswith("Stiffness: 210.")
    assert page.side.label.text() == "The values are identified from the file “lab.csv”."
    assert ("File", "lab.csv") in page.conditions.pairs
    assert page.point.text().endswith(page.found.force_known)
    assert "The force is taken from the file" in page.found.force_known
    assert page.exports()[1]()["file"] == "lab.csv"
    window.resize(1280, 720)
    window.grab()
    assert cut_off(page) == cut_off(page.side) == []
    # the window's settings do not affect the result
    window.studio.set_value("stiffness", 123.0)
    assert page.answer.label.text().startswith("Stiffness: 210.")
    # the handle can be identified only if no hand holds it
    assert "hand's force is not measured" in page.found.handle.advice
    assert page.released.isVisible()
    first = page.found
    page.released.click()
    qtbot.waitUntil(lambda: page.found is not first)
    assert page.found.handle.estimates
    page.released.click()
    # open a session, which contains its settings
    hs.simulate("spring", {"stiffness": 300.0}, hand="shake", seconds=2.0).save(tmp_path / "felt.hapkit")
    page.opener.open(str(tmp_path / "felt.hapkit"))
    qtbot.waitUntil(
        lambda: page.side.label.text() == "The values are identified from the file “felt.hapkit”."
    )
    assert page.found.rendered["stiffness"].asked == 300.0
    assert page.found.rendered["stiffness"].value == pytest.approx(300.0, abs=0.3)
    assert page.released.isHidden()


@pytest.mark.slow
def test_a_file_that_cannot_be_identified_gives_the_reason_beside_the_button(window, qtbot, tmp_path):
    window.views.show("identify")
    page = window.views.page("identify")
    path = tmp_path / "few.csv"
    path.write_text("time_s,position_m,force_applied_N\n0,0,0\n0.001,0.0001,-0.03\n0.002,0.0002,-0.06\n")
    page.opener.open(str(path))
    qtbot.waitUntil(lambda: "at least 32 samples, not 3" in page.bar.status.text())
    path.write_text("nothing")
    page.opener.open(str(path))
    qtbot.waitUntil(lambda: "0 rows of numbers" in page.bar.status.text())
