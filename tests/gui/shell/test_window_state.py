"""The next start restores scenes, loop, hand and view; a motor waits for Render."""

import json
from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from hapkit_studio.devices import DeviceEntry
from hapkit_studio.devices.virtual_board import VirtualBoard, built, truth
from hapkit_studio.dynamics.loop_settings import USUAL_LOOP
from hapkit_studio.gui.state.environment_library import usable
from hapkit_studio.haptics import rows
from tests.environments.calling import LIBRARY
from tests.gui.window_support import SIMULATED
from tests.lateness import clear_lateness

HAND, STIFFNESS = 0.014, 300.0


@pytest.fixture
def start(make_window):
    """Return a function that starts a window with the state of the previous one."""

    def begin(entries=(SIMULATED,)):
        window = make_window(entries)
        window.state.restore()
        window.closed.connect(lambda: window.state.save())
        return window

    return begin


@pytest.mark.slow
def test_a_window_opens_in_the_state_of_the_previous_one(start, qtbot):
    first = start()
    assert first.studio.environment.key == "wall"
    assert not first.studio.stop_state.restored
    first.studio.choose("friction")
    first.studio.choose("wall")
    first.studio.set_values({"stiffness": STIFFNESS, "position": -0.012, "side": 1.0})
    first.views.show("break_it")
    first.centre.trigger.set_value("event", 3.0)
    first.centre.trigger.set_value("force", -2.5)
    first.close()
    again = start()
    assert again.studio.environment.key == "wall"
    assert again.studio.values == LIBRARY["wall"].values(
        {"stiffness": STIFFNESS, "position": -0.012, "side": "left"}
    )
    assert again.panel.parameters.rows["stiffness"].box.text() == "300"
    assert again.views.key == "break_it"
    assert again.centre.trigger.values == first.centre.trigger.values
    assert again.centre.trigger.level.channel == "applied_force"
    again.studio.choose("cat")
    again.views.show("live")
    again.close()
    third = start()
    assert (third.studio.environment.key, third.views.key) == ("cat", "live")
    assert not again.settings.rejected
    assert not third.settings.rejected
    assert third.studio.values_of("wall") == again.studio.values_of("wall") != LIBRARY["wall"].values()


@pytest.mark.slow
@pytest.mark.parametrize("model", ["everything", "frictionless"])
def test_the_stability_request_is_the_same_after_a_restart(start, qtbot, model):
    """A verdict depends on scene, values, loop and grip, and all are restored."""
    loop = {
        "rate": 2000.0, "delay": 0.0015, "estimator": ("iir", {"cutoff": 20.0}), "hand": "firm",
        "controller": True, "model": model, "where": "board", "board_rate": 500.0,
    }  # fmt: skip
    asked = []
    for begins in (True, False):
        window = start()
        if begins:
            window.studio.set_value("stiffness", 1800.0)
            window.studio.set_loop(**loop)
        assert window.studio.loop == replace(USUAL_LOOP, **loop)
        window.studio.device.open(SIMULATED)
        qtbot.waitUntil(lambda window=window: window.studio.engine is not None)
        asked.append(window.stability.question())
        window.close()
    assert asked[0] == asked[1]
    setting = asked[1].asked.setting
    assert (setting.rate, setting.delay, setting.hand) == (2000.0, 0.0015, "firm")
    assert asked[1].asked.values["stiffness"] == 1800.0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("environment", "values", "view", "found"),
    [
        ("swamp", '{"stiffness": 300}', "moon", {}),
        ("wall", '{"wall": {"stiffness": 5001, "position": 0.01, "age": 7}}', "", {"position": 0.01}),
        (
            "wall",
            '{"wall": {"side": "up", "damping_mode": "both"}, "swamp": 1}',
            "",
            {"damping_mode": "both"},
        ),
        ("wall", '{"wall": {"stiffness": NaN}}', "", {}),
        ("wall", '{"wall": 300, "cat": [1]}', "", {}),
        ("wall", "[1, 2", "", {}),
        ("wall", "[1, 2]", "", {}),
        (["wall"], ["x"], ["live"], {}),
    ],
)
def test_unknown_and_out_of_range_settings_are_ignored(reset_idle_window, environment, values, view, found):
    window = reset_idle_window
    for name, value in (("environment", environment), ("values", values), ("view", view)):
        window.settings.setValue(name, value)
    window.state.restore()
    assert window.studio.environment.key == "wall"
    assert window.views.key == "live"
    assert window.studio.values == LIBRARY["wall"].values(found)


@pytest.mark.slow
@pytest.mark.parametrize("view", ["chain", "fidelity", "accuracy"])
def test_a_merged_view_opens_the_view_that_contains_it(reset_idle_window, view):
    reset_idle_window.settings.setValue("view", view)
    reset_idle_window.state.restore()
    assert reset_idle_window.views.key == "accuracy"
    reset_idle_window.views.show("live")


@pytest.mark.parametrize(
    ("loop", "found", "grip"),
    [
        ({"rate": 10001, "delay": 0.1, "grip": "iron"}, {"delay": 0.1}, "medium"),
        ({"rate": True, "delay": None, "estimator": "none", "grip": "light"}, {}, "light"),
        ({"estimator": "iir", "options": {"cutoff": -1, "age": 7}}, {"estimator": "iir"}, "medium"),
        ({"model": [], "where": "moon", "board_rate": 3.0, "controller": 1, "options": 5}, {}, "medium"),
    ],
)
def test_invalid_loop_settings_are_ignored_individually(reset_idle_window, loop, found, grip):
    window = reset_idle_window
    window.settings.setValue("environment", "wall")
    window.settings.setValue("loop", json.dumps(loop))
    window.state.restore()
    assert (window.studio.loop, window.studio.grip) == (replace(USUAL_LOOP, **found, hand=grip), grip)


@pytest.mark.slow
def test_the_drag_hint_is_not_shown_again_after_the_first_drag(start, qtbot):
    for hinted in (True, False):
        window = start()
        assert window.centre.scene._hint == hinted
        window.centre.scene.set_preparing(False)
        window.centre.scene.set_hand_enabled(True)
        qtbot.mouseClick(window.centre.scene, Qt.MouseButton.LeftButton)
        window.close()


def test_incompatible_values_are_replaced_by_the_defaults():
    """For example, a button's snap must begin within its travel."""
    assert usable(LIBRARY["button"], {"travel": 0.003, "snap_start": 0.0035}) == LIBRARY["button"].values()


@pytest.mark.slow
def test_a_named_environment_starts_with_defaults_and_a_picture_changes_no_settings(start_window):
    for options, before, left in (
        ([], 250.0, STIFFNESS),
        (["--environment", "wall"], 250.0, STIFFNESS),
        (["--screenshot", "x.png"], STIFFNESS, 400.0),
        ([], STIFFNESS, STIFFNESS),
    ):
        window = start_window(*options)
        assert window.studio.values["stiffness"] == before
        assert window.studio.stop_state.restored == (before == STIFFNESS)
        window.studio.set_value("stiffness", left)
        window.close()


@pytest.mark.slow
def test_the_simulated_device_does_not_wait_and_its_stop_does_not_require_render(start, qtbot):
    start().close()
    window = start()
    window.studio.device.open(SIMULATED)
    qtbot.waitUntil(lambda: window.studio.engine is not None)
    assert not window.studio.engine.stopped
    window.studio.stop()
    assert window.banners.banners[0].title.text() == "Stopped. Force is zero."
    window.studio.release_stop()
    assert window.studio.stop_state.restored


@pytest.mark.skipif(not built(), reason="the virtual board is not built")
@pytest.mark.parametrize("where", ["computer", "board"])
def test_a_motor_gives_no_force_before_render_is_pressed(start, qtbot, tmp_path, where):
    """Before Render, neither the rows nor the handle show a force; then the restored wall pushes the hand."""
    first = start()
    first.studio.set_value("stiffness", STIFFNESS)
    first.studio.set_loop(where=where)
    first.close()
    board = VirtualBoard("lockstep", log=tmp_path / "truth.bin")
    entry = DeviceEntry("virtual-board", "Virtual board", lambda: board)
    window = start((SIMULATED, entry))
    studio, history = window.studio, window.live.history
    studio.device.open(entry)
    qtbot.waitUntil(lambda: studio.engine is not None)
    studio.move_hand(HAND)

    def kept():
        clear_lateness(studio)
        window.live.tick()
        return history.between(-np.inf, np.inf).known().y

    qtbot.waitUntil(lambda: len(kept()["position"]) > 300 and kept()["position"][-1] > 0.009)
    assert not np.any(kept()["applied_force"])
    (banner,) = window.banners.banners
    assert (banner.title.text(), window.header.stop.word.text()) == (
        "The motor is off until you press Render.",
        "STOPPED",
    )
    (render,) = banner.buttons
    assert render.text() == "Render"
    before = window.live.last[rows.BOARD_TIME]
    QTest.mouseClick(render, Qt.MouseButton.LeftButton)
    qtbot.waitUntil(lambda: kept()["applied_force"][-1] < -0.3)
    assert window.banners.get("stop") is None
    # on a busy computer, a banner on late samples may remain for a moment
    qtbot.waitUntil(lambda: window.banners.banners == [])
    window.live.stop()
    studio.close()
    log = truth(tmp_path / "truth.bin")
    assert not np.any(log.motor_force[log.time < before])
    assert np.any(log.motor_force)
