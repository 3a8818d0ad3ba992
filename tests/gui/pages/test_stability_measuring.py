"""Measuring on the stability page: progress, cancel, what holds and what does not; the trial; saving."""

import threading
from dataclasses import replace

import numpy as np
import pytest

from hapkit_studio.analysis.setting import Setting
from hapkit_studio.analysis.stability.kb_plane import exact_boundary
from hapkit_studio.gui.pages.stability import page as stability
from hapkit_studio.gui.pages.stability.map_data import measuring
from hapkit_studio.gui.studio import Studio
from tests.gui.pages.drawing_support import drawn, words
from tests.gui.pages.stability_support import follow, made_up
from tests.gui.window_support import PATIENCE_MS


@pytest.fixture
def page(window, qtbot):
    """Return the page in sight; the wall with little stiffness."""
    window.views.show("stability")
    shown = window.views.page("stability")
    follow(shown, qtbot)
    return shown


def test_what_is_measured_is_the_exact_boundary_and_progress_reaches_the_end():
    told = []
    setting = Setting(viscous=0.18, delay=1e-3)
    found = measuring(setting, False, (4.0, 3000.0), side=4)(lambda done, of: told.append((done, of)))
    assert found.points.stiffness == pytest.approx(exact_boundary(setting, found.points.damping), rel=0.01)
    limits = exact_boundary(setting, found.cells.damping)
    assert np.array_equal(found.cells.classes == 0, found.cells.stiffness[:, np.newaxis] < limits)
    assert found.words((4.0, 3000.0)).startswith("4 × 4 cells, ")
    assert found.words((8.0, 3000.0)) == "Measured to 4 N·s/m and 3,000 N/m only"
    assert told == sorted(told)
    assert told[-1][0] == told[-1][1]


def test_the_same_button_cancels_and_nothing_is_shown(page, qtbot, monkeypatch):
    begun = threading.Event()

    def endless(*_args):
        def work(progress):
            while True:
                begun.set()
                progress(1, 2)

        return work

    monkeypatch.setattr(stability, "measuring", endless)
    page.job._needs = ""
    page.bar.run.click()
    assert begun.wait(PATIENCE_MS / 1000.0)
    assert page.bar.run.text() == "Cancel"
    page.bar.run.click()
    page.job.wait()
    assert not page.job.running
    assert page.bar.status.text() == "Cancelled"
    assert page.results.all == []


def measure_again(page, monkeypatch):
    """Begin another measurement: the old map is paler as long as it runs."""
    go = threading.Event()
    monkeypatch.setattr(stability, "measuring", lambda *_args: lambda _progress: go.wait() and None)
    page.job._needs = ""
    page.bar.run.click()
    assert page._map.outdated
    page.job.cancel()
    go.set()
    assert not page._map.outdated


def test_a_measurement_pales_where_other_conditions_hold(page, window, qtbot, monkeypatch):
    page.show_result(made_up(page.lines.plane.setting))
    assert page.bar.status.text() == "4 × 3 cells, 3.1 s"
    assert not page._map.outdated
    assert {"Measured boundary: beyond this map", "buzzes, does not grow"} <= set(words(page.chart))
    window.studio.set_value("stiffness", 500.0)
    follow(page, qtbot)
    assert not page._map.outdated, "another dot is no other condition"
    page.real.setChecked(True)
    assert page._map.outdated
    assert page.bar.status.text() == "Out of date"
    page.real.setChecked(False)
    assert not page._map.outdated
    measure_again(page, monkeypatch)
    window.studio.set_loop(estimator="iir", options=())
    follow(page, qtbot)
    assert page._map.outdated
    drawn(page.chart)


def test_before_and_after_the_controller_stand_side_by_side(page, window, qtbot):
    plain = page.lines.plane.setting
    controlled = replace(plain, controller=True)
    page.show_result(made_up(plain))
    page.show_result(made_up(controlled))
    assert {m.setting.controller for m in page.results.all} == {False, True}
    beyond = {f"{name}: beyond this map" for name in ("Measured boundary", "Measured, controlled")}
    assert beyond <= set(words(page.chart))
    page.show_result(made_up(controlled))
    assert len(page.results.all) == 2
    assert not page.outdated, "the controller is off, and there is a map without it"
    page.side.controller.click()
    assert follow(page, qtbot).setting.controller
    assert page.results.last.setting == controlled
    assert not page.outdated
    drawn(page.chart)
    page.show_result(made_up(replace(plain, rate=500.0)))
    assert [m.setting.rate for m in page.results.all] == [500.0]
    window.studio.set_loop(controller=False)
    assert not page.side.controller.isChecked()


def test_measuring_before_the_lines_are_there_begins_with_them(page, qtbot, monkeypatch):
    monkeypatch.setattr(stability, "measuring", lambda *args: lambda _progress: made_up(args[0]))
    page.job._needs = ""
    lines, page.lines = page.lines, None
    page.bar.run.click()
    assert not page.job.running
    page.show_lines(lines)
    qtbot.waitUntil(lambda: len(page.results.all) == 1, timeout=PATIENCE_MS)


def test_the_handle_is_pulled_and_let_go(page, window, qtbot, monkeypatch):
    places = []
    monkeypatch.setattr(window.studio, "move_hand", places.append)
    window.studio.set_grip("released")
    page.trial._timer.setInterval(1)
    page.side.release.click()
    assert window.studio.grip == "medium", "without a grip nothing would be pulled"
    assert not page.side.release.isEnabled()
    qtbot.waitUntil(lambda: places[-1:] == [None], timeout=PATIENCE_MS)
    wall = window.studio.values["position"]
    assert wall < places[0] <= wall + 0.0151
    assert window.studio.grip == "released"
    page.trial._timer.setInterval(PATIENCE_MS)
    page.side.release.click()
    window.views.show("live")
    assert places[-1] is None, "leaving the page lets go"
    assert not page.trial.holding
    monkeypatch.setattr(Studio, "hand_is_ours", False)
    window.views.show("stability")
    assert not page.side.release.isEnabled()
    assert "On a real Hapkit you are the hand" in page.side.try_words.text()


def test_picture_and_numbers_are_those_in_sight(page, tmp_path, monkeypatch):
    page.show_result(made_up(page.lines.plane.setting))
    taken = []
    monkeypatch.setattr(page._export, "ask", lambda *args: taken.append(args))
    page.bar.export.click()
    figure, numbers = taken[0]
    assert numbers()["measured"]["stiffness"] == [800.0, 900.0, 1000.0]
    assert numbers()["stiffness"] == page.lines.plane.margin.stiffness
    figure(str(tmp_path / "map.png"))
    assert (tmp_path / "map.png").stat().st_size > 20_000
    page.real.setChecked(True)
    page.bar.export.click()
    assert taken[1][1]()["measured"] is None
