"""The views beside Live: built when shown, room and panel shared, work in a thread that can be cancelled."""

import math
import threading

import pytest
from PySide6.QtCore import QEvent, QPointF, Qt
from PySide6.QtGui import QMouseEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QFileDialog, QLabel

from hapkit_studio.errors import ParameterError
from hapkit_studio.gui import tabs
from hapkit_studio.gui.tabs.bar import RunBar
from hapkit_studio.gui.tabs.base import Page, Tab
from hapkit_studio.gui.tabs.chart import Chart, decades, power, steps
from hapkit_studio.gui.tabs.export import Export
from hapkit_studio.gui.tabs.job import Job
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
        "first": Tab("first", "First", 1, Plain),
        "second": Tab("second", "Second", 2, Plain, scene=False),
    }
    monkeypatch.setattr(tabs, "discover", lambda: library)
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


@pytest.mark.parametrize("log", [(False, False), (True, True), (True, False)])
def test_a_chart_maps_to_pixels_and_back(qtbot, log):
    chart = Chart("across", "up", log=log)
    qtbot.addWidget(chart)
    chart.resize(640, 420)
    chart.set_range((1e-2, 1e3), (1e-6, 10.0))
    box = chart.frame()
    for x, y in ((1e-2, 1e-6), (1.0, 1e-3), (1e3, 10.0)):
        place = chart.at(x, y)
        assert chart.value(place) == pytest.approx((x, y), rel=1e-6, abs=1e-9)
    assert chart.at(1e-2, 1e-6).toPoint() == box.bottomLeft().toPoint()
    if log[0]:
        assert chart.at(10.0**0.5, 1.0).x() == pytest.approx(box.center().x(), abs=0.5)


def test_a_click_and_a_drag_come_in_data_units(qtbot):
    chart = Chart("across", "up")
    qtbot.addWidget(chart)
    chart.resize(640, 420)
    chart.show()
    chart.set_range((0.0, 10.0), (0.0, 100.0))
    heard = []
    chart.clicked.connect(lambda x, y: heard.append((x, y)))
    place = chart.at(5.0, 50.0).toPoint()
    QTest.mouseClick(chart.viewport(), Qt.MouseButton.LeftButton, pos=place)
    assert heard[0] == pytest.approx(chart.value(QPointF(place)))
    assert heard[0] == pytest.approx((5.0, 50.0), rel=0.02)
    QTest.mouseClick(chart.viewport(), Qt.MouseButton.LeftButton, pos=chart.at(10.0, 100.0).toPoint() * 2)
    assert len(heard) == 1


def test_powers_are_few_and_written_short():
    assert [power(k) for k in (-15, -1, 0, 2, 3)] == ["10⁻¹⁵", "0.1", "1", "100", "10³"]
    assert decades(-15.2, 3.1, 7) == [-15.0, -12.0, -9.0, -6.0, -3.0, 0.0, 3.0]


def test_a_range_of_less_than_two_decades_has_more_ticks_than_the_powers():
    found = [round(10.0**exponent, 6) for exponent in steps(math.log10(0.25), math.log10(6.0))]
    assert found == [0.5, 1.0, 2.0, 5.0]


def test_a_drag_goes_on_in_the_axes_of_its_press(qtbot):
    chart = Chart("across", "up")
    qtbot.addWidget(chart)
    chart.resize(640, 420)
    chart.show()
    chart.set_range((0.0, 10.0), (0.0, 100.0))
    heard = []
    chart.dragged.connect(lambda x, y: heard.append((x, y)))
    begin, end = chart.at(5.0, 50.0).toPoint(), chart.at(5.0, 60.0).toPoint()
    wanted = chart.value(QPointF(end))
    QTest.mousePress(chart.viewport(), Qt.MouseButton.LeftButton, pos=begin)
    chart.set_range((0.0, 10.0), (0.0, 500.0))
    chart.resize(640, 366)
    drag(chart, end)
    assert heard[-1] == pytest.approx(wanted, rel=1e-6)


def drag(chart, place):
    """Move the pointer with the left button held; QTest sends no buttons along."""
    pointer = QPointF(place)
    event = QMouseEvent(
        QEvent.Type.MouseMove, pointer, QPointF(chart.viewport().mapToGlobal(place)),
        Qt.MouseButton.NoButton, Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier,
    )  # fmt: skip
    chart.mouseMoveEvent(event)


def test_many_words_take_a_line_of_their_own(job, qtbot):
    bar = RunBar(job)
    qtbot.addWidget(bar)
    bar.resize(700, bar.sizeHint().height())
    low = bar.sizeHint().height()
    bar.say("The folder nowhere cannot be written: no such file or directory.", danger=True)
    assert bar.sizeHint().height() > low
    bar.say("508 points, 4.1 s")
    assert bar.sizeHint().height() == low


def test_enter_presses_and_space_does_not(job, qtbot, idle_window):
    bar = RunBar(job)
    bar.setParent(idle_window)
    bar.show()
    heard = []
    bar.run_pressed.connect(lambda: heard.append(True))
    bar.run.setFocus()
    QTest.keyClick(bar.run, Qt.Key.Key_Return)
    assert heard == [True]


def test_the_e_stop_is_within_reach_while_a_file_is_named(idle_window):
    export = Export(idle_window, "chart", lambda *_words, **_kinds: None)
    export.ask(lambda path: None, dict)
    dialog = idle_window.findChild(QFileDialog)
    assert dialog.isVisible()
    assert not dialog.isModal()
    idle_window.header.stop.click()
    assert idle_window.studio.stopped
    dialog.close()
