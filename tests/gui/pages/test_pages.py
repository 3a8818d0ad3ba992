"""The views beside Live are built when first shown, have side panels, and run jobs that can be cancelled."""

import json
import threading

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QFileDialog, QLabel, QPushButton, QWidget

from hapkit_studio.errors import ParameterError
from hapkit_studio.gui import pages
from hapkit_studio.gui.pages import measuring
from hapkit_studio.gui.pages.base import Page, View
from hapkit_studio.gui.pages.measuring import RunBar
from hapkit_studio.gui.state.background import Job
from tests.gui.shell.test_layout import cut_off


class Plain(Page):
    """A page that has its own side panel and counts how often the page is shown and hidden."""

    def __init__(self, studio, live):
        super().__init__()
        self.column.addWidget(QLabel("measured"))
        self.side = QLabel("side")
        self.shown: list[bool] = []
        self.ended = False

    def set_shown(self, on):
        self.shown.append(on)

    def end(self):
        self.ended = True


def test_a_page_is_built_when_first_shown_and_ends_with_the_window(monkeypatch, make_window):
    library = {
        "first": View("first", "First", 1, Plain),
        "second": View("second", "Second", 2, Plain, scene=False),
    }
    monkeypatch.setattr(pages, "discover", lambda: library)
    window = make_window()
    views, bar = window.views, window.header.tabs
    assert window.findChildren(Plain) == []

    def seen():
        parts = window.centre.time, window.centre.scene, window.panel
        return tuple(part.isVisible() for part in parts)

    views.show("first")
    page = views.page("first")
    assert page.isVisible()
    assert page.shown == [True]
    assert seen() == (False, True, False)
    assert page.side.isVisible()
    assert page.side.width() == window.panel.width()
    views.show("second")
    assert page.shown == [True, False]
    assert not page.isVisible()
    assert seen() == (False, False, False)
    assert window.header.stop.isVisible()
    page.marked.emit("In the scene: a spring too stiff")
    assert (bar.tabText(1), bar.tabToolTip(1)) == ("First ●", "In the scene: a spring too stiff")
    page.marked.emit("")
    assert bar.tabText(1) == "First"
    for digit, key in ((Qt.Key.Key_2, "first"), (Qt.Key.Key_3, "second"), (Qt.Key.Key_1, "live")):
        QTest.keyClick(window, digit, Qt.KeyboardModifier.ControlModifier)
        assert views.key == key
    assert seen() == (True, True, True)
    assert not page.side.isVisible()
    window.close()
    assert page.ended


def test_pressing_a_tab_moves_the_focus_to_its_page(monkeypatch, make_window):
    monkeypatch.setattr(pages, "discover", lambda: {"alone": View("alone", "Alone", 1, Plain, scene=False)})
    window = make_window()
    for index, part in ((1, lambda: window.views.page("alone")), (0, lambda: window.centre.scene)):
        QTest.mouseClick(
            window.header.tabs, Qt.MouseButton.LeftButton, pos=window.header.tabs.tabRect(index).center()
        )
        assert QApplication.focusWidget() is part()


@pytest.fixture
def job(qtbot):
    made = Job(needs="")
    yield made
    made.end()


def test_the_run_button_moves_to_a_second_line_if_the_bar_is_too_narrow(job, qtbot, qapp):
    bar, choice = RunBar(job), QPushButton("A choice with a long text")
    page = QWidget()
    qtbot.addWidget(page)
    bar.setParent(page)
    bar.add(choice)
    page.show()
    wide = choice.sizeHint().width() + bar.run.sizeHint().width() + bar.export.sizeHint().width()
    for width, lines in ((wide + 60, 1), (wide - 10, 2), (wide + 60, 1)):
        bar.resize(width, 80)
        assert cut_off(page) == []
        assert (bar.run.y() > choice.geometry().bottom()) == (lines == 2)
        assert bar.export.geometry().right() < width


def test_a_job_reports_progress_and_delivers_its_result(job, qtbot):
    heard = []
    job.progressed.connect(lambda done, of: heard.append((done, of)))
    with qtbot.waitSignal(job.finished) as result:
        job.start(lambda progress: [progress(k, 3) for k in (1, 2, 3)] and "found")
    assert result.args == ["found"]
    assert heard[-1] == (3, 3)
    assert not job.running


@pytest.mark.parametrize("newer", [False, True], ids=["cancelled", "replaced"])
def test_a_cancelled_job_ends_at_its_next_progress_and_delivers_nothing(job, qtbot, qapp, newer):
    begun, go_on, ended, heard = threading.Event(), threading.Event(), threading.Event(), []

    def work(progress):
        try:
            begun.set()
            go_on.wait()
            progress(1, 2)
            return "never"
        finally:
            ended.set()

    job.finished.connect(heard.append)
    job.start(work)
    assert begun.wait(60.0)
    if newer:
        job.start(lambda progress: "new")
    else:
        job.cancel()
    assert job.running == newer
    go_on.set()
    job.wait()
    qapp.processEvents()
    assert ended.is_set()
    assert heard == ["new"] * newer


def test_errors_and_defects_of_a_job_are_reported(job, qtbot, capsys):
    def refuse(progress):
        raise ParameterError("The rate must be more than 0 Hz.")

    for work, text in ((refuse, "The rate must be more than 0 Hz."), (lambda progress: 1 / 0, "division")):
        with qtbot.waitSignal(job.failed) as blocker:
            job.start(work)
        assert text in blocker.args[0]
    assert "ZeroDivisionError" in capsys.readouterr().err


def test_the_same_button_runs_and_cancels(job, qtbot):
    bar = RunBar(job)
    qtbot.addWidget(bar)
    go_on = threading.Event()
    bar.run_pressed.connect(lambda: job.start(lambda progress: go_on.wait() and progress(1, 1)))
    bar.run.click()
    assert bar.run.text() == "Cancel"
    bar.run.click()
    assert bar.run.text() == "Measure"
    assert bar.status.text() == "The measurement was cancelled"
    go_on.set()
    job.wait()
    with qtbot.waitSignal(job.finished):
        bar.run.click()
    assert bar.run.text() == "Measure again"
    assert bar.export.isEnabled()


def test_a_longer_text_of_the_run_button_is_complete_at_once(job, qtbot):
    bar = RunBar(job, ("Run", "Run all failures again"))
    qtbot.addWidget(bar)
    bar.resize(600, 60)
    bar.show()
    bar.set_measured(True)
    assert bar.run.width() >= bar.run.sizeHint().width()


def test_a_long_status_has_its_own_line_and_enter_presses_the_button(job, shared_window):
    bar, heard = RunBar(job), []
    bar.setParent(shared_window)
    bar.resize(700, bar.sizeHint().height())
    bar.show()
    low = bar.sizeHint().height()
    bar.show_text("The folder nowhere cannot be written: no such file or directory.", danger=True)
    assert bar.sizeHint().height() > low
    bar.show_text("508 points, 4.1 s")
    assert bar.sizeHint().height() == low
    bar.run_pressed.connect(lambda: heard.append(True))
    bar.run.setFocus()
    QTest.keyClick(bar.run, Qt.Key.Key_Return)
    assert heard == [True]
    bar.deleteLater()


def test_the_e_stop_can_be_reached_while_a_file_dialog_is_open(shared_window):
    page = shared_window.views.page("accuracy").needs
    page.export()
    dialog = page.findChild(QFileDialog)
    assert dialog.isVisible()
    assert not dialog.isModal()
    shared_window.header.stop.click()
    assert shared_window.studio.stopped
    dialog.close()
    shared_window.studio.release_stop()


def test_a_file_is_written_in_a_thread_and_errors_are_shown(shared_window, monkeypatch, qtbot, tmp_path):
    page, taken = shared_window.views.page("accuracy").needs, []
    monkeypatch.setattr(measuring, "choose_file", lambda *given, save_as: taken.append((given[3], save_as)))
    monkeypatch.setattr(page, "exports", lambda: (lambda path: None, lambda: {"found": 1.5}))
    page.bar.export_pressed.emit()
    ((save, name),) = taken
    assert name == "accuracy-needs.png"
    for path, text in (
        ("a.json", "The file a.json was saved"),
        ("no/a.json", "The file a.json cannot be written: No such file"),
    ):
        save(str(tmp_path / path))
        qtbot.waitUntil(lambda text=text: page.bar.status.text().startswith(text))
    assert json.loads((tmp_path / "a.json").read_text()) == {"found": 1.5}
