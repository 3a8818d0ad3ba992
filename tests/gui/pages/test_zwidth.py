"""The Z-width view measures in a simulation or on a device; it shows each new point and can be cancelled."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtGui import QGuiApplication

from hapkit_studio.analysis.zwidth import HIGHEST
from hapkit_studio.analysis.zwidth.result import BUZZES, Point, Protocol, ZWidth, conditions
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.gui.live.export import write
from hapkit_studio.gui.pages.zwidth import DEVICE, SIMULATION
from hapkit_studio.haptics import rows
from tests.gui.pages.drawing_support import leave, outside, point, texts
from tests.gui.shell.test_fits import misfits
from tests.gui.shell.test_layout import resize


def made_up(capped=False, clamped=True):
    """Return a Z-width whose best point is 1,340 N/m at 2 N·s/m."""
    limit = Point(1344.0, HIGHEST) if capped else Point(1344.0, BUZZES, clamped, 1357.0, 1409.0)
    points = [Point(500.0, BUZZES, first_failed=510.0, last_held=500.0), limit]
    damping = [0.0, 2.0]
    curve = np.array([np.linspace(0.0, 2.0, 5), np.linspace(330.0, 1000.0, 5)])
    found = ZWidth.of(
        "simulation", damping, points, LoopSettings(), conditions(LoopSettings(), Protocol(max_force=3.0))
    )
    return replace(found, linear=curve[1, [0, -1]], curve=curve)


@pytest.fixture
def window(reset_window):
    """Return the window with the running simulated device."""
    return reset_window


@pytest.fixture
def page(window):
    """Return the view in its initial state; nothing is compiled or measured automatically."""
    window.studio.set_value("stiffness", 321.0)
    shown = window.views.page("zwidth")
    shown.begun.add("simulation")
    window.views.show("zwidth")
    shown.job._needs = ""
    shown.where.show_index(SIMULATION)
    shown._results.clear()
    shown.show_found()
    return shown


@pytest.fixture
def begun(page, window, qtbot):
    """Return the view while it measures on a device, after the first wall was tried."""
    window.studio.choose("spring")
    page.where.show_index(DEVICE)
    page.bar.run.click()
    qtbot.waitUntil(lambda: window.studio.engine.values.get("stiffness") == 200.0)
    return page


def assert_over(page, window, environment="spring"):
    """Check that no measurement is running and that the device renders the settings of the window."""
    page.job.wait()
    studio, engine = window.studio, window.studio.engine
    assert not page.job.running
    assert studio.environment.key == environment
    assert engine.environment is studio.environment
    assert engine.values == studio.values
    assert engine.max_force == engine.device.max_force
    assert page.force.isEnabled()


@pytest.mark.slow
def test_the_simulation_starts_automatically_once_and_a_device_waits_for_the_user(page, window, qtbot):
    window.studio.set_loop(hand="released")
    window.views.show("live")
    page.begun.clear()
    page.where.show_index(DEVICE)
    window.views.show("zwidth")
    assert not page.job.running
    with qtbot.waitSignal(page.job.finished):
        page.where.button(SIMULATION).click()
    result = page.result
    assert result.place == "Simulation"
    assert list(result.damping) == [0.0, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0]
    assert (result.stiffness > result.linear).all()  # friction raises the linear limit
    assert page.answer.label.text() == result.sentence
    conditions = {c.key: c.value for c in result.conditions}
    device = window.studio.engine.device
    assert (conditions["mass"], conditions["max_force"]) == (device.mass, device.max_force)
    assert conditions["hand"] == "released"
    pairs = dict(page.conditions.pairs)
    assert (pairs["Hand"], pairs["Push"]) == ("none, only a constant push", "1 N")
    assert page.bar.export.isEnabled()
    assert window.studio.engine.values["stiffness"] == 321.0
    page._results.clear()
    window.views.show("live")
    window.views.show("zwidth")
    assert not page.job.running


@pytest.mark.slow
def test_points_appear_one_by_one(page):
    page.show_result(made_up())
    page._begin("Simulating hits on walls…")
    assert page.chart.pale
    page.job._wanted = object()  # the job now behaves as if a measurement were running
    points = [(0.0, Point(500.0, BUZZES, False)), (1.0, Point(900.0, BUZZES, True, 909.0, 920.0))]
    for new in points:
        page.arrived.emit(*new)
    assert not page.chart.pale
    assert page.walls.points == points
    assert "rests at some walls, buzzes at others" in texts(page.chart)
    assert "handle rests at all walls up to here, motor at its limit" in texts(page.chart)
    page.job._wanted = None
    page.arrived.emit(2.0, Point(950.0, BUZZES, True))  # this point arrives after the measurement
    assert len(page.walls.points) == 2
    page.job.running_changed.emit(False)


@pytest.mark.slow
def test_the_result_is_shown_as_text_table_and_numbers(page, tmp_path):
    page.show_result(made_up(capped=True))
    where = "With damping b = 2 N·s/m (no hand), the handle comes to rest at all tested walls up to"
    text = f"{where} at least 1,340 N/m."
    assert page.answer.label.text() == text
    assert page.answer.sign.name == "check"
    page.show_result(made_up())
    best = (
        "With damping b = 2 N·s/m (no hand), the handle comes to rest at all tested walls up to 1,340 N/m, "
        "with the motor at its limit of 3 N. From there to 1,400 N/m it rests at some walls and buzzes at "
        "others."
    )
    assert page.answer.label.text() == best
    assert page.answer.sign.name == "info", "a limit of the motor is no success"
    point(page.chart, 2.0, 1344.0)
    assert page.point.text() == f"{best} Above this stiffness the handle buzzes."
    leave(page.chart)
    assert page.point.text() == ""
    page.table.copy()
    assert (
        QGuiApplication.clipboard().text()
        == "b N·s/m\tStable up to N/m\tPartly stable up to N/m\n0\t500\t–\n2\t1,340\t1,400"
    )
    found = json.loads(Path(write(tmp_path / "z.json", *page.exports())).read_text(encoding="utf-8"))
    assert [point["stiffness"] for point in found["points"]] == [500.0, 1344.0]
    assert found["conditions"]["push"] == 1.0


@pytest.mark.slow
def test_a_result_of_another_loop_is_out_of_date(page, window):
    page._fresh[SIMULATION].begin()
    page.show_result(made_up(clamped=False))
    studio = window.studio
    grip, loop = studio.grip, studio.loop
    changes = (
        ("the loop", lambda: studio.set_loop(rate=500.0), lambda: studio.set_loop(rate=loop.rate)),
        ("the hand", lambda: studio.set_loop(hand="released"), lambda: studio.set_loop(hand=grip)),
    )
    for what, change, back in changes:
        change()
        assert page.answer.label.text() == (
            f"The result is out of date, because {what} changed. Press Measure again."
        )
        assert page.answer.sign.name == "circle"
        assert page.chart.pale
        back()
        assert page.answer.sign.name == "check"
        assert not page.chart.pale


@pytest.mark.slow
def test_without_a_result_nothing_is_shown_and_a_result_is_not_cut_off(page, window, qapp):
    page.show_result(made_up())
    resize(qapp, window, (1280, 720))
    assert outside(page.chart) == misfits(window) == []
    page.where.button(DEVICE).click()
    assert page.answer.label.text().startswith("Press Measure to find the stiffest wall")
    assert not page.bar.export.isEnabled()
    assert page.walls.points == ()
    assert not page.table.isVisible()
    page.where.button(SIMULATION).click()
    assert page.answer.label.text().startswith("With damping b = 2 N·s/m")
    assert page.bar.export.isEnabled()


@pytest.mark.slow
def test_the_scene_shows_the_wall_being_tried(begun, window):
    assert window.studio.environment.key == "wall"
    begun.show_trial()
    assert begun.answer.label.text() == "Trying a wall of 200 N/m with a damping of 0 N·s/m"
    assert not begun.force.isEnabled()
    begun.bar.run.click()
    assert begun.bar.status.text() == "The measurement was cancelled"
    assert_over(begun, window)


def test_an_e_stop_ends_the_measurement_and_stays_latched(begun, window, qtbot):
    with qtbot.waitSignal(begun.job.failed):
        window.studio.stop()
    assert begun.answer.label.text() == "Stopped. Force is zero. Release the E-stop, then measure again."
    assert_over(begun, window)
    assert window.studio.engine.stopped
    reader = window.studio.engine.reader()
    seen = []
    qtbot.waitUntil(lambda: seen.extend(reader.read()) or len(seen) > 20)
    assert not np.array(seen)[:, rows.APPLIED_FORCE].any()


@pytest.mark.slow
def test_another_loop_view_or_scene_ends_the_measurement(begun, window, qtbot):
    window.studio.set_loop(delay=2e-3)
    assert begun.bar.status.text() == "The measurement ended, because the loop changed."
    assert_over(begun, window)
    begun.bar.run.click()
    qtbot.waitUntil(lambda: window.studio.engine.environment.key == "wall")
    window.views.show("live")
    assert begun.bar.status.text() == "The measurement ended, because the view was left."
    assert_over(begun, window)
    window.views.show("zwidth")
    begun.bar.run.click()
    qtbot.waitUntil(lambda: window.studio.engine.values.get("stiffness") == 200.0)
    window.studio.choose("damping")
    assert_over(begun, window, "damping")  # the newly selected scene is kept


@pytest.mark.slow
def test_an_instruction_is_shown_to_the_user(page, window):
    page.job._wanted = object()
    page.instructed.emit("Press gently into the wall and hold.")
    page._mode = DEVICE
    page.show_trial()
    assert page.answer.label.text() == "Press gently into the wall and hold."
    page.job._wanted = None
    page.force.box.entered.emit(9.0)
    assert (page.force.error.text(), page.force.value) == ("Force limit must be between 0.1 and 3 N.", 2.0)
    page.force.box.entered.emit(2.0)
    assert page.force.error.isHidden()


@pytest.mark.slow
def test_without_a_device_a_message_is_shown(shared_window):
    shared_window.views.show("zwidth")
    page = shared_window.views.page("zwidth")
    for index in (0, 1):
        page.where.show_index(index)
        page.bar.run.click()
        assert "device" in page.bar.status.text()
        assert not page.job.running
