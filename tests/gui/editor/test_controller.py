"""A law is written in the window from a template to the loop; errors are marked, and no text is lost."""

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QLabel

from hapkit_studio.gui.editor import code_page
from hapkit_studio.gui.shell.export_dialog import ExportDialog
from hapkit_studio.gui.shell.window_dialogs import KeysDialog
from hapkit_studio.gui.widgets.page_dialog import PageDialog
from hapkit_studio.haptics import rows
from hapkit_studio.workshop import trial
from hapkit_studio.workshop.folder import templates
from hapkit_studio.workshop.source import is_trusted, read, typed
from hapkit_studio.workshop.trying import TrialResult, failed
from tests.gui.own_support import LAW_LINE, law_tab, put, spring, wait_for_verdict


@pytest.fixture
def opened(home, make_window, qtbot):
    """Return a function that opens a window without a device, with a trusted file in the editor."""

    def make(text=None):
        path = put(home, "test_spring.py", text or spring())
        window = make_window()
        window.editor.edit(path)
        return window

    return make


@pytest.fixture
def no_trials(monkeypatch):
    """Start no trial process; a test provides the trial's result itself."""
    monkeypatch.setattr("hapkit_studio.gui.state.own_environments.Job.start", lambda *_: None)


def force_at(window, qtbot, place: float) -> float:
    """Hold the handle at ``place`` m; return the ratio of requested force to position in N/m."""
    window.studio.move_hand(place)
    reader, taken = window.studio.engine.reader(), []

    def settled():
        new = reader.read()
        taken.extend(new)
        return len(taken) > 600 and np.ptp([r[rows.POSITION] for r in taken[-100:]]) < 1e-4

    qtbot.waitUntil(settled)
    last = np.array(taken[-100:])
    return float(np.mean(last[:, rows.FORCE]) / np.mean(last[:, rows.POSITION]))


@pytest.mark.slow
def test_a_template_becomes_a_file_an_active_law_and_sliders(home, window, qtbot):
    window.actions_by_key.run("environment.new")
    chooser = window.editor.editor.chooser
    assert chooser.isVisible()
    assert window.centre.scene.isVisible()
    assert not window.centre.time.isVisible()
    assert chooser.title.text() == "My spring"
    chooser.title.selectAll()
    QTest.keyClicks(chooser.title, "Weiche Feder")
    verdict = wait_for_verdict(window, qtbot, lambda: QTest.keyClick(chooser.title, Qt.Key.Key_Return))
    assert verdict.ok
    assert verdict.calls >= 10_000
    path = home / "environments" / "weiche_feder.py"
    assert path.is_file()
    assert window.editor.path == path == window.own.active
    assert window.editor.page.code.hasFocus()
    assert window.studio.environment.title == "Weiche Feder"
    assert window.studio.engine.environment is window.studio.environment
    assert set(window.panel.parameters.rows) == {"stiffness", "damping", "center"}
    assert force_at(window, qtbot, 0.01) == pytest.approx(-80.0, rel=0.02)
    window.panel.parameters.rows["stiffness"].box.entered.emit(160.0)
    assert force_at(window, qtbot, 0.01) == pytest.approx(-160.0, rel=0.02)

    code = window.editor.page.code
    code.selectAll()
    code.insertPlainText(window.editor.page.text.replace("return -p.stiffness", "return -2.0 * p.stiffness"))
    assert law_tab(window) == "Law ●"
    verdict = wait_for_verdict(window, qtbot, lambda: window.actions_by_key.run("environment.save"))
    assert verdict.ok
    assert law_tab(window) == "Law"
    assert window.studio.values["stiffness"] == 160.0
    assert force_at(window, qtbot, 0.01) == pytest.approx(-320.0, rel=0.02)


def test_a_new_environment_gets_an_unused_name(home, make_window):
    put(home, "my_spring.py", spring("my_spring", "Other"))
    put(home, "other.py", spring("other", "My wall"))
    window = make_window()
    window.editor.begin_new()
    chooser = window.editor.editor.chooser
    assert chooser.title.text() == "My spring 2"
    chooser.group.button(1).click()
    assert chooser.title.text() == "My wall 2"
    chooser.group.button(2).click()
    assert chooser.title.text() == "My two walls"


@pytest.mark.slow
def test_an_error_is_at_its_line_and_the_old_law_keeps_running(opened, qtbot):
    window = opened(spring(force="-p.stifness * x"))
    before = window.studio.environment
    verdict = wait_for_verdict(window, qtbot, window.editor.save)
    assert not verdict.ok
    assert window.studio.environment is before
    assert list(window.editor.page.code.marks) == [LAW_LINE]
    assert "stifness" in window.editor.page.code.marks[LAW_LINE]
    text = window.editor.message.label.text()
    assert text.startswith(f"Line {LAW_LINE}: 'p.stifness'")
    assert text.endswith("The previous law keeps running.")
    assert window.gallery.own_rows[window.editor.path].summary == "The file does not run yet"


DRIFTING = spring(force="-p.stiffness * s.t").replace("@law\n", '@law(state={"t": 0.0})\n')
DRIFTING = DRIFTING.replace("    return", "    s.t += dt\n    return")


@pytest.mark.slow
def test_a_law_that_drifts_is_active_with_advice_at_its_line(opened, qtbot):
    window = opened(DRIFTING)
    verdict = wait_for_verdict(window, qtbot, window.editor.save)
    assert verdict.ok
    code, message = window.editor.page.code, window.editor.message
    assert code.marks == {}
    assert list(code.remarks) == [LAW_LINE]
    assert "count the calls, `s.t += 1`" in code.remarks[LAW_LINE]
    assert message.tone == "warn"
    assert message.label.text().startswith(f"The law is running. Line {LAW_LINE}: `s.t` becomes inaccurate")
    window.actions_by_key.run("environment.export")
    (sheet,) = window.findChildren(ExportDialog)
    assert f"Line {LAW_LINE}: `s.t` becomes inaccurate" in sheet.verdict.label.text()
    path = window.editor.path
    window.editor.close()
    window.editor.edit(path)
    assert list(code.remarks) == [LAW_LINE]
    code.go_to(LAW_LINE)
    QTest.keyClicks(code, "#")  # the remark disappears when its line changes
    assert code.remarks == {}


def test_a_cached_trial_shows_its_advice_at_once(opened, qtbot):
    window = opened(DRIFTING)
    trial.remember(read(window.editor.path), True)
    wait_for_verdict(window, qtbot, lambda: window.own.choose(window.editor.path))
    assert list(window.editor.page.code.remarks) == [LAW_LINE]


def test_f1_shows_the_language_at_the_word_under_the_cursor(opened):
    window = opened()
    page = window.editor.page
    QTest.keyClicks(page.code, "math.hypot ")
    QTest.keyClick(page.code, Qt.Key.Key_Left)
    QTest.keyClick(page.code, Qt.Key.Key_F1)
    (sheet,) = window.findChildren(PageDialog)
    assert sheet.field.text() == sheet.page.textCursor().selectedText() == "hypot"
    first = sheet.page.textCursor().position()
    QTest.keyClick(sheet.field, Qt.Key.Key_Return)
    assert sheet.page.textCursor().position() > first
    QTest.keyClick(sheet.field, Qt.Key.Key_Return)
    assert sheet.page.textCursor().position() == first  # the page contains the word twice
    assert sheet.isVisible()
    page.language.click()
    assert [s.field.text() for s in window.findChildren(PageDialog) if s.isVisible()] == [""]
    assert not window.findChildren(KeysDialog)
    window.centre.scene.setFocus()
    QTest.keyClick(window.centre.scene, Qt.Key.Key_F1)
    assert len(window.findChildren(KeysDialog)) == 1


def test_text_typed_during_a_trial_stays_unsaved(opened, no_trials):
    window = opened()
    window.editor.save()
    assert window.editor.message.label.text() == "Checking the law line by line…"
    assert window.editor.message.busy.isVisible()
    assert window.gallery.own_rows[window.editor.path].summary == "Checking the file…"
    QTest.keyClicks(window.editor.page.code, "#")
    window.own.runner.finished.emit((read(window.editor.path), failed("this is wrong", 3)))
    assert not window.editor.message.busy.isVisible()
    assert "#" in window.editor.page.text
    assert window.editor.page.unsaved
    assert window.editor.message.label.text().endswith("Your later changes are not saved.")


def test_a_fault_marks_its_line(window, qtbot, home):
    text = spring(key="fault", force="-p.stiffness * x / max(x - 0.2, -0.2 * (x < 0.01))")
    path = put(home, "fault.py", text)
    # a trial would find this fault, so report a trial without faults
    found = typed(path, text), TrialResult()
    wait_for_verdict(window, qtbot, lambda: window.own.runner.finished.emit(found))
    window.editor.edit(path)
    window.studio.move_hand(0.02)
    qtbot.waitUntil(lambda: window.studio.fault is not None)

    def marked():
        window.live.tick()
        return bool(window.editor.page.code.marks)

    qtbot.waitUntil(marked)
    assert list(window.editor.page.code.marks) == [LAW_LINE]
    assert window.editor.message.label.text() == window.studio.fault.text
    assert window.banners.get("fault") is not None


def test_esc_stops_from_inside_the_editor(window, home):
    window.editor.edit(put(home, "test_spring.py", spring()))
    for widget in (window.editor.page.code, window.editor.page.save):
        widget.setFocus()
        QTest.keyClick(widget, Qt.Key.Key_Escape)
        assert window.studio.stopped
        assert window.studio.engine.stopped
        assert window.editor.page.isVisible()
        window.studio.release_stop()
    window.actions_by_key.run("environment.new")
    QTest.keyClick(window.editor.editor.chooser.title, Qt.Key.Key_Escape)
    assert window.studio.stopped


def full(_path, _text):
    """Raise the error of a full disk."""
    raise OSError(28, "No space left on device")


def test_closing_asks_about_unsaved_text(opened, no_trials, monkeypatch):
    window = opened()
    # after discarding, the file is unchanged and there is no draft
    path = window.editor.path
    QTest.keyClicks(window.editor.page.code, "#")
    window.editor.page.keep_draft()
    window.editor.close()
    window.editor.message.buttons[1].click()
    assert path.read_text(encoding="utf-8") == spring()
    window.editor.edit(path)
    assert window.editor.page.text == spring()
    assert not window.editor.page.unsaved
    assert window.editor.page.code.textCursor().blockNumber() == LAW_LINE - 1
    assert window.editor.message.label.text() == ""
    assert not code_page.draft_path(path).exists()
    # text that cannot be written is kept
    QTest.keyClicks(window.editor.page.code, "#01c m?")
    with monkeypatch.context() as disk:
        disk.setattr("hapkit_studio.workshop.folder.save", full)
        window.editor.save()
    assert window.editor.page.unsaved
    assert "No space left" in window.editor.message.label.text()
    assert window.own.checking is None
    assert window.studio.environment.key == "wall", "letters of a law choose no environment"
    text = window.editor.page.text
    window.actions_by_key.run("environment.close")
    assert window.editor.page.isVisible()
    assert [b.text() for b in window.editor.message.buttons] == [
        "Save",
        "Discard changes",
        "Continue editing",
    ]
    window.editor.message.buttons[2].click()
    assert window.editor.page.code.hasFocus()
    window.actions_by_key.run("environment.close")
    window.editor.message.buttons[0].click()
    assert path.read_text(encoding="utf-8") == text
    assert is_trusted(read(path))
    assert window.editor.path is None
    assert window.centre.time.isVisible()
    assert law_tab(window) is None


@pytest.mark.slow
def test_unsaved_text_is_restored_after_a_restart(opened, make_window, home):
    window = opened()
    QTest.keyClicks(window.editor.page.code, "# half a thought ")
    path, text = window.editor.path, window.editor.page.text
    window.close()
    assert path.read_text(encoding="utf-8") == spring()
    again = make_window()
    again.editor.edit(path)
    assert again.editor.page.text == text
    assert again.editor.page.unsaved
    again.editor.page.code.undo()
    assert again.editor.page.text == spring()
    assert not again.editor.page.unsaved


def test_quitting_asks_once_about_unsaved_text(opened, no_trials):
    window = opened()
    QTest.keyClicks(window.editor.page.code, "#")
    window.header.tabs.setCurrentIndex(0)
    window.actions_by_key.run("session.quit")
    assert window.isVisible()
    assert window.editor.message.isVisible()
    labels = [button.text() for button in window.editor.message.buttons]
    assert labels == ["Save and quit", "Quit and keep a draft", "Continue editing"]
    window.editor.message.buttons[2].click()
    window.actions_by_key.run("session.quit")
    assert window.isVisible()
    path, text = window.editor.path, window.editor.page.text
    assert window.editor.message.buttons[0].hasFocus()
    QTest.keyClick(window.editor.message.buttons[0], Qt.Key.Key_Return)
    assert not window.isVisible()
    assert path.read_text(encoding="utf-8") == text


def test_ctrl_e_goes_to_the_law_and_back_and_every_control_has_a_name(opened):
    window = opened()
    window.actions_by_key.run("environment.law")
    assert window.centre.scene.hasFocus()
    window.header.tabs.setCurrentIndex(0)
    window.actions_by_key.run("environment.law")
    assert window.editor.page.code.hasFocus()
    assert not window.centre.time.isVisible()
    assert window.editor.page.code.accessibleName() == "Law, test_spring.py"
    assert window.editor.page.close_law.accessibleName()
    window.editor.begin_new()
    rows_ = window.editor.editor.chooser.group.buttons()
    names = [row.accessibleName().split(":")[0] for row in rows_]
    assert names == [one.title.capitalize() for one in templates()]
    labels = window.editor.editor.chooser.findChildren(QLabel)
    assert any(label.buddy() is window.editor.editor.chooser.title for label in labels)
