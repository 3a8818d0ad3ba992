"""The views beside Live: built when shown, room and panel shared, work in a thread that can be cancelled."""

import threading

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QFileDialog, QLabel

from hapkit_studio.errors import ParameterError
from hapkit_studio.gui import pages
from hapkit_studio.gui.background import Job
from hapkit_studio.gui.pages.base import Page, Pairs, SidePanel, View
from hapkit_studio.gui.pages.measuring import RunBar
from tests.gui.window_support import PATIENCE_MS


class Plain(Page):
    """A page with a side of its own that counts how often it comes and goes."""

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


@pytest.fixture
def two_tabs(monkeypatch):
    library = {
        "first": View("first", "First", 1, Plain),
        "second": View("second", "Second", 2, Plain, scene=False),
    }
    monkeypatch.setattr(pages, "discover", lambda: library)
    return library


def test_a_page_is_built_when_it_is_first_shown(two_tabs, idle_window):
    window, views = idle_window, idle_window.views
    assert window.findChildren(Plain) == []
    views.show("first")
    page = views.page("first")
    assert page.isVisible()
    assert page.shown == [True]
    assert not window.centre.time.isVisible()
    assert window.centre.scene.isVisible()
    assert page.side.isVisible()
    assert not window.panel.isVisible()
    assert page.side.width() == window.panel.width()
    views.show("second")
    assert page.shown == [True, False]
    assert not page.isVisible()
    assert not window.centre.scene.isVisible()
    assert window.header.stop.isVisible()
    views.show("live")
    assert window.centre.time.isVisible()
    assert window.centre.scene.isVisible()
    assert window.panel.isVisible()
    assert not page.side.isVisible()


def test_a_page_that_acts_on_the_scene_marks_its_tab_in_every_view(two_tabs, idle_window):
    bar, views = idle_window.header.tabs, idle_window.views
    page = views.page("first")
    views.show("second")
    page.marked.emit("In the scene: a spring too stiff")
    assert bar.tabText(1) == "First ●"
    assert bar.tabToolTip(1) == "In the scene: a spring too stiff"
    page.marked.emit("")
    assert bar.tabText(1) == "First"


def test_ctrl_and_a_digit_choose_a_view(two_tabs, idle_window):
    for digit, key in ((Qt.Key.Key_2, "first"), (Qt.Key.Key_3, "second"), (Qt.Key.Key_1, "live")):
        QTest.keyClick(idle_window, digit, Qt.KeyboardModifier.ControlModifier)
        assert idle_window.views.key == key


def test_pages_end_with_the_window(two_tabs, idle_window):
    idle_window.views.show("first")
    page = idle_window.views.page("first")
    idle_window.close()
    assert page.ended


@pytest.fixture
def job(qtbot):
    made = Job(needs="")
    yield made
    made.end()


def test_work_tells_its_progress_and_hands_over_its_result(job, qtbot):
    heard = []
    job.progressed.connect(lambda done, of: heard.append((done, of)))
    with qtbot.waitSignal(job.finished, timeout=PATIENCE_MS) as result:
        job.start(lambda progress: [progress(k, 3) for k in (1, 2, 3)] and "found")
    assert result.args == ["found"]
    assert heard[-1] == (3, 3)
    assert not job.running


def test_cancelled_work_ends_at_its_next_word_and_delivers_nothing(job, qtbot, qapp):
    begun, go_on, ended = threading.Event(), threading.Event(), threading.Event()

    def work(progress):
        try:
            begun.set()
            go_on.wait()
            progress(1, 2)
            return "never"
        finally:
            ended.set()

    heard = []
    job.finished.connect(heard.append)
    job.start(work)
    begun.wait()
    job.cancel()
    go_on.set()
    job.wait()
    qapp.processEvents()
    assert ended.is_set()
    assert heard == []
    assert not job.running


def test_a_newer_piece_of_work_replaces_the_older_one(job, qtbot, qapp):
    go_on = threading.Event()
    heard = []
    job.finished.connect(heard.append)
    job.start(lambda progress: go_on.wait() and "old")
    old = job._thread
    with qtbot.waitSignal(job.finished, timeout=PATIENCE_MS):
        job.start(lambda progress: "new")
    go_on.set()
    old.join()
    qapp.processEvents()
    assert heard == ["new"]


def test_an_error_is_said_and_a_defect_too(job, qtbot, capsys):
    def refuse(progress):
        raise ParameterError("The rate must be more than 0 Hz.")

    with qtbot.waitSignal(job.failed, timeout=PATIENCE_MS) as said:
        job.start(refuse)
    assert said.args == ["The rate must be more than 0 Hz."]
    with qtbot.waitSignal(job.failed, timeout=PATIENCE_MS) as said:
        job.start(lambda progress: 1 / 0)
    assert "division" in said.args[0]
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
    assert bar.status.text() == "Cancelled"
    go_on.set()
    job.wait()
    with qtbot.waitSignal(job.finished, timeout=PATIENCE_MS):
        bar.run.click()
    assert bar.run.text() == "Measure again"
    assert bar.export.isEnabled()


def test_many_words_take_a_line_of_their_own_and_enter_presses(job, qtbot, idle_window):
    bar, heard = RunBar(job), []
    bar.setParent(idle_window)
    bar.resize(700, bar.sizeHint().height())
    bar.show()
    low = bar.sizeHint().height()
    bar.say("The folder nowhere cannot be written: no such file or directory.", danger=True)
    assert bar.sizeHint().height() > low
    bar.say("508 points, 4.1 s")
    assert bar.sizeHint().height() == low
    bar.run_pressed.connect(lambda: heard.append(True))
    bar.run.setFocus()
    QTest.keyClick(bar.run, Qt.Key.Key_Return)
    assert heard == [True]


def test_the_e_stop_is_within_reach_while_a_file_is_named(idle_window):
    idle_window.views.show("fidelity")
    idle_window.views.page("fidelity").export()
    dialog = idle_window.findChild(QFileDialog)
    assert dialog.isVisible()
    assert not dialog.isModal()
    idle_window.header.stop.click()
    assert idle_window.studio.stopped
    dialog.close()


def test_a_section_is_named_while_there_is_something_in_it(qtbot):
    side = SidePanel("Title")
    qtbot.addWidget(side)
    rule, heading = side.section("Conditions")
    pairs = Pairs((rule, heading))
    side.add(pairs)
    side.show()
    for shown in ([], [("Rate", "1 kHz")], []):
        pairs.show_pairs(shown)
        assert heading.isVisible() == rule.isVisible() == bool(shown)
