"""Messages of the window about the running device: faults, banners, gaps, incompatible values."""

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from hapkit_studio import errors
from hapkit_studio.dynamics.loop_settings import DELAY, RATE
from hapkit_studio.gui.live.time_plots import gaps
from hapkit_studio.gui.shell.banners import Notice
from hapkit_studio.haptics import arrays
from hapkit_studio.haptics.engine import Engine
from hapkit_studio.haptics.rows import HOST_TIME
from hapkit_studio.parameters import Parameter
from tests.gui.live.plot_support import colored
from tests.gui.window_support import SIMULATED


@pytest.mark.slow
def test_a_progress_bar_is_shown_while_the_loop_compiles(idle_window, qtbot):
    scene = idle_window.centre.scene
    first = scene._fraction
    qtbot.waitUntil(lambda: first < scene._fraction < 1.0)
    idle_window.studio.device.open(SIMULATED)
    qtbot.waitUntil(lambda: idle_window.studio.engine is not None)
    assert scene._fraction is None
    assert not idle_window.display._bar.isActive()


@pytest.mark.slow
def test_a_fault_shows_its_reason_and_is_cleared_by_the_user(reset_window, qtbot):
    window = reset_window
    window.studio.engine.arrays.control.fault[0] = arrays.OVER_SPEED
    window.studio.engine.arrays.tick.fault_value = 3.4
    window.live.refresh()
    (banner,) = window.banners.banners
    assert banner.title.text().startswith("Fault: the handle moved too fast, 3.4 m/s (limit ")
    assert banner.text.text() == "Force is zero. Hold the handle, then clear the fault."
    QTest.mouseClick(banner.buttons[0], Qt.MouseButton.LeftButton)
    qtbot.waitUntil(lambda: window.studio.fault is None)
    window.live.refresh()
    assert window.banners.banners == []


@pytest.mark.slow
def test_at_most_two_banners_are_shown_the_more_severe_first_and_a_new_text_replaces_the_old(
    reset_idle_window,
):
    """A measured value changes twice a second, and the banner's widgets must not be rebuilt each time."""
    banners, done = reset_idle_window.banners, []

    def notice(text, result, *more):
        ways = (("Do", lambda: done.append(result)), *more)
        return Notice("device", 2, "danger", "cross", text, "…", ways)

    banners.set("device", notice("181 N/m", 1))
    (banner,) = banners.banners
    banners.set("device", notice("182 N/m", 2))
    assert banners.banners == [banner]
    assert banner.title.text() == "182 N/m"
    assert banner.accessibleName().startswith("182")
    QTest.mouseClick(banner.buttons[0], Qt.MouseButton.LeftButton)
    assert done == [2]
    banners.set("device", notice("182 N/m", 2, ("Else", done.clear)))
    assert [button.text() for button in banners.banners[0].buttons] == ["Do", "Else"]
    banners.set("limit", Notice("limit", 3, "danger", "cross", "Third", "…"))
    reset_idle_window.studio.stop()
    assert [b.title.text() for b in banners.banners] == ["Stopped. Force is zero.", "182 N/m"]
    reset_idle_window.studio.release_stop()
    assert [b.title.text() for b in banners.banners] == ["182 N/m", "Third"]
    for key in ("device", "limit"):
        banners.set(key, None)
    assert banners.banners == []


def test_incompatible_values_are_refused_with_and_without_an_engine(reset_idle_window, reset_window):
    """A button's snap must begin within its travel; a reset changes both values at the same time."""
    for shown in (reset_idle_window, reset_window):
        studio = shown.studio
        studio.choose("button")
        studio.set_value("snap_start", 0.002)
        studio.set_value("travel", 0.003)
        with pytest.raises(errors.ParameterError, match="press depth"):
            studio.set_value("snap_start", 0.0035)
        assert studio.values["snap_start"] == 0.002
        studio.reset_values()
        assert studio.values == studio.environment.values()
    assert reset_window.studio.engine.values == studio.values


@pytest.mark.slow
def test_a_gap_is_hatched_and_labelled_in_the_plot(window, qtbot):
    """A gap is also marked if its beginning has left the plot."""
    history, plots = window.live.history, window.centre.time
    qtbot.waitUntil(lambda: window.live.tick() or len(history) > 200)
    window.live._reader = None  # from now on only the test's rows
    history._time[: history._end] -= 8.0
    rows = np.zeros((50, len(window.live.last)))
    rows[:, 0] = 10**6 + np.arange(50)
    rows[:, HOST_TIME] = history.now + 8.0 + 1e-3 * np.arange(50)
    history.append(rows)
    for span in (10.0, 5.0):
        plots.view.set_span(span)
        plots.refresh()
        ((start, stop),) = plots.shown.gaps
        assert stop - start == pytest.approx(8.0, abs=0.01)
        assert len(colored(plots.canvases[0].grab().toImage(), "warn")) > 20


@pytest.mark.parametrize(
    ("x", "before", "found"),
    [
        ([0.0, 0.1, np.nan, 2.1, 2.2, np.nan, 2.3, np.nan], None, [(0.1, 2.1)]),
        ([np.nan, 1.0], None, []),  # there is no gap before the first sample of a history
        ([np.nan, 5.0, 5.1], 1.0, [(1.0, 5.0)]),  # a gap that began before the window
        ([5.0, 5.1], 4.9, []),
        ([], 1.0, []),
    ],
)
def test_a_gap_extends_from_the_last_sample_to_the_next(x, before, found):
    assert gaps(np.array(x), **({} if before is None else {"before": before})) == found


def test_a_slider_sends_only_the_changed_value_and_it_is_checked_once(reset_window, monkeypatch):
    window, studio, checked, sent = reset_window, reset_window.studio, [], []
    studio.choose("wall")
    mine = {id(p) for p in (*studio.environment.parameters, RATE, DELAY)}
    check, put = Parameter.check, Engine.put_values

    def noted(parameter, value):
        checked.extend([parameter.key] if id(parameter) in mine else [])
        return check(parameter, value)

    monkeypatch.setattr(Parameter, "check", noted)
    monkeypatch.setattr(Engine, "put_values", lambda e, values: sent.append(dict(values)) or put(e, values))
    before = dict(studio.values)
    window.panel.parameters.rows["stiffness"].changed.emit("stiffness", 432.0)
    assert checked == ["stiffness"]
    assert sent == [{**before, "stiffness": 432.0}]
    checked.clear()
    studio.set_loop(delay=0.002)
    assert checked == ["delay"]
    assert studio.engine.loop.delay == 0.002
