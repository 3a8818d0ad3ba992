"""The window replays files of known signals; the test sets the clock."""

import math
import random
import warnings
from types import SimpleNamespace

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest

import hapkit_studio as hs
from hapkit_studio.devices import DeviceEntry
from hapkit_studio.devices.virtual_board import VirtualBoard, built, truth
from hapkit_studio.gui.live import export
from hapkit_studio.gui.live.replay import FRAME
from hapkit_studio.gui.state.background import end_all
from hapkit_studio.gui.state.device_link import LinkStatus
from hapkit_studio.gui.state.lock import Lock
from hapkit_studio.gui.state.undo import settings_of
from hapkit_studio.haptics import rows
from hapkit_studio.sessions.chunk import pack
from hapkit_studio.sessions.file import MARKER, SETTINGS, Event, SessionWriter
from tests.gui.demo_support import Clock
from tests.gui.live.test_export import read
from tests.gui.teach.test_demos import written
from tests.gui.window_support import SIMULATED
from tests.lateness import clear_lateness
from tests.sessions.damaged import mutate, set_value
from tests.sessions.test_chunk import QUANTUM

START, SECONDS, SPEED = 1000.0, 3.0, 0.005  # s, s, m/s
LOOP = {"rate_Hz": 1000.0, "delay_s": 0.004, "estimator": ["iir", {"cutoff": 20.0}], "controller": True}
WALL = {
    "environment": "wall",
    "parameters": {"stiffness": 700.0, "side": "left"},
    "grip": "firm",
    "max_force_N": 2.0,
    **LOOP,
}
SPRING = {"environment": "spring", "parameters": {"stiffness": 80.0}, "max_force_N": 2.0}
GONE = {"environment": "my_lost_law", "parameters": {}}


def write(path, *settings):
    """Write a ramp at 1 kHz whose settings change every second."""
    writer, count = SessionWriter(path), round(1000 * SECONDS)
    for number, what in enumerate(settings):
        writer.note(Event(START - 0.5 + number, SETTINGS, what))
    writer.note(Event(START + 1.0, MARKER, {"text": "here"}))
    table = np.zeros((count, rows.ROW_WIDTH))
    table[:, rows.TICK] = np.arange(count)
    table[:, rows.HOST_TIME] = START + 1e-3 * np.arange(count)
    table[:, rows.POSITION] = SPEED * 1e-3 * np.arange(count)
    for part in np.split(table, 10):
        writer.add(pack(part, QUANTUM, 0))
    writer.close()
    return path


def opened(window, qtbot, path):
    window.replay.open(path)
    qtbot.waitUntil(lambda: window.replay.history is not None or window.banners.get("replay") is not None)
    return window.replay


@pytest.fixture
def replay(reset_idle_window, qtbot, home):
    """Return the replay of a session, at its beginning, in this test file's window."""
    window = reset_idle_window
    window.replay._clock = Clock()
    shown = opened(window, qtbot, write(home / "a.hapkit", WALL, SPRING))
    shown.settle()
    yield shown
    window.replay.close()
    window.history.forget()


def pass_time(replay, seconds):
    replay._clock.now += seconds
    replay.tick()


@pytest.mark.slow
def test_a_replay_has_its_speed_pauses_at_the_end_and_restarts(replay, reset_idle_window):
    live = reset_idle_window.live
    for speed, passed, stands in ((1.0, 0.25, 0.25), (2.0, 0.4, 1.05), (0.1, 1.0, 1.15), (8.0, 0.2, 2.75)):
        replay.set_speed(speed)
        pass_time(replay, passed)
        assert replay.time == pytest.approx(stands, abs=1e-6)
    live.toggle_paused()
    pass_time(replay, 0.1)
    assert replay.time == pytest.approx(2.75, abs=1e-6)
    live.toggle_paused()
    pass_time(replay, 5.0)
    assert (replay.time, live.paused) == (pytest.approx(SECONDS - 1e-3), True)
    live.toggle_paused()
    assert replay.time == 0.0
    replay.set_speed(1.0)


def test_while_dragging_plots_show_blocks_and_then_samples(replay, reset_idle_window):
    """No samples are read while dragging, and the replay does not advance."""
    time, phase = reset_idle_window.centre.time, reset_idle_window.centre.phase.canvas
    replay.history._read_chunks = 0, 0
    replay.seek(2.5)
    pass_time(replay, 0.3)
    assert replay.time == pytest.approx(2.5)
    apart = np.nanmedian(np.diff(time.shown.window.x))
    assert apart == pytest.approx(0.032)  # two values per block of 64 samples
    recent = phase._recent().x
    assert np.median(np.diff(recent)) == pytest.approx(0.032)
    assert 0.9 < np.ptp(recent) <= 1.0
    assert replay.history._read_chunks == (0, 0)
    replay.settle()
    assert len(phase._recent().x) == 2001  # 2 s, because the spring is active from 0.5 s on
    assert np.nanmedian(np.diff(time.shown.window.x)) < 0.032
    pass_time(replay, 0.3)
    assert replay.time == pytest.approx(2.8)


@pytest.mark.slow
@pytest.mark.parametrize("stop", [1e308, None, -1.0, 9e8, math.inf])
def test_a_session_with_an_absurd_end_is_refused_with_a_reason(reset_idle_window, qtbot, home, stop):
    path = write(home / "a.hapkit", WALL)
    for row in range(1, 11):
        set_value(path, "chunk", row, "stop", stop)
    replay = opened(reset_idle_window, qtbot, path)
    assert replay.history is None
    text = reset_idle_window.banners.get("replay").text
    assert text.startswith("a.hapkit has no readable samples. chunk 1: stop is ")
    reset_idle_window.banners.set("replay", None)


def test_a_chunk_with_an_absurd_end_is_left_out_of_a_replay(reset_idle_window, qtbot, home):
    path = write(home / "a.hapkit", WALL)
    set_value(path, "chunk", 10, "stop", 1e308)
    replay = opened(reset_idle_window, qtbot, path)
    assert replay.seconds == pytest.approx(0.9 * SECONDS - 1e-3)
    replay.close()


@pytest.mark.slow
def test_a_session_without_force_is_drawn(reset_idle_window, qtbot, home):
    """The force limit of the session is 0.0 or -0.0."""
    reset_idle_window.replay._clock = Clock()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for limit in (0.0, -0.0):
            settings = {**WALL, "max_force_N": limit}
            replay = opened(reset_idle_window, qtbot, write(home / f"{limit}.hapkit", settings))
            shown_everywhere(reset_idle_window, replay)
            replay.close()
    reset_idle_window.history.forget()


def shown_everywhere(window, replay):
    """Draw a replay at its beginning, middle and end, then while it runs, then over its whole length."""
    for part in (0.0, 0.5, 1.0):
        replay.seek(part * replay.seconds)
        replay.settle()
        replay.step(1)
        replay.step(-1, sample=True)
        window.centre.grab()
    span = window.centre.view.span
    window.centre.view.set_span(60.0)
    window.live.set_paused(False)
    pass_time(replay, 0.1)
    window.centre.grab()
    window.centre.view.set_span(span)


@pytest.mark.slow
@pytest.mark.parametrize("seeds", [range(4), pytest.param(range(4, 150), marks=pytest.mark.slow)])
def test_sessions_with_one_corrupted_value_are_replayed_or_refused(reset_idle_window, qtbot, home, seeds):
    """An exception in a slot fails the test."""
    window = reset_idle_window
    window.replay._clock = Clock()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for seed in seeds:
            path = write(home / f"{seed}.hapkit", WALL, SPRING)
            mutate(path, random.Random(seed))
            if opened(window, qtbot, path).history is not None:
                shown_everywhere(window, window.replay)
            window.replay.close()
            window.banners.set("replay", None)
    window.history.forget()


def test_scene_plots_and_bar_show_the_sample_at_the_replay_position(replay, reset_idle_window):
    window = reset_idle_window
    assert window.views.key == "live"
    assert window.replay_bar.isVisible()
    # times in s: forwards, then backwards; the replay first runs and is then paused
    for seconds in (0.5004, 2.9996, 0.0304):
        replay.seek(seconds)
        replay.settle()
        position = QUANTUM * round(SPEED * np.floor(1e3 * seconds) * 1e-3 / QUANTUM)
        assert window.centre.scene._motion.position == pytest.approx(1e3 * position, abs=0.011)
        assert window.centre.time.shown.now["position"] == pytest.approx(position, abs=1.1e-5)
        x = window.centre.time.shown.window.x
        assert x[np.isfinite(x)].max() == pytest.approx(START + seconds, abs=0.04)
        window.live.set_paused(True)
    replay.seek(2.5)
    assert window.replay_bar.time.text() == "0:02.5 / 0:02.9"
    assert [text for _, text in window.centre.time.shown.dividers] == ["Spring", "here"]
    cursors = window.centre.time.cursors
    cursors.show(True)
    for index, after in enumerate((1.0005, 2.0005)):
        cursors.move(index, START + after)
    assert len(cursors.between()["time"]) == 1001
    window.display.keep_curves()
    assert len(window.centre.kept_curves.curves) == 1
    window.centre.kept_curves.remove(0)


def test_recorded_settings_are_active_during_the_replay_and_restored_afterwards(replay, reset_idle_window):
    studio, window = reset_idle_window.studio, reset_idle_window
    assert (studio.environment.key, studio.values["stiffness"], studio.values["side"]) == ("wall", 700.0, 1.0)
    assert (studio.loop.delay, studio.loop.method, studio.loop.controller) == (0.004, "iir", True)
    assert (studio.loop.options, studio.grip) == ({"cutoff": 20.0}, "firm")
    assert window.panel.parameters.rows["stiffness"].box.text() == "700"
    assert window.display.max_force == 2.0
    replay.seek(0.499)
    assert studio.environment.key == "wall"
    replay.seek(0.501)
    assert (studio.environment.key, studio.values["stiffness"]) == ("spring", 80.0)
    window.replay_bar.leave.click()
    assert not window.replay_bar.isVisible()
    assert (studio.environment.key, studio.values) == ("wall", studio.environment.values())
    assert (studio.loop.delay, studio.grip, studio.temporary) == (0.0, "medium", False)
    assert not window.history.stack.count()
    assert studio.stop_state.restored


def test_changing_a_setting_ends_the_replay_and_is_one_undo_step(replay, reset_idle_window, qtbot):
    studio, stack = reset_idle_window.studio, reset_idle_window.history.stack
    studio.set_value("damping", 3.0)
    qtbot.waitUntil(lambda: replay.history is None)
    assert studio.values == studio.environment.values({"damping": 3.0})
    assert stack.count() == 1
    reset_idle_window.history.undo()
    assert studio.values == studio.environment.values()


def test_the_scene_is_visible_while_a_device_is_prepared(replay, reset_idle_window, monkeypatch):
    window = reset_idle_window
    with monkeypatch.context() as patched:
        patched.setattr(window.studio.device, "link", LinkStatus("preparing"))
        window.display.show_link()
        assert not window.centre.scene._preparing
        replay.close()
        assert window.centre.scene._preparing
    window.display.show_link()


def test_keys_step_and_a_press_on_the_line_seeks(replay, reset_idle_window):
    window = reset_idle_window
    window.centre.scene.setFocus()
    replay.seek(1.0)
    for key, modifier, moved in (
        (Qt.Key.Key_Right, Qt.KeyboardModifier.NoModifier, FRAME),
        (Qt.Key.Key_Left, Qt.KeyboardModifier.NoModifier, -FRAME),
        (Qt.Key.Key_Right, Qt.KeyboardModifier.ShiftModifier, 1e-3),
        (Qt.Key.Key_Left, Qt.KeyboardModifier.ShiftModifier, -1e-3),
    ):
        before = replay.time
        QTest.keyClick(window.centre.scene, key, modifier)
        assert replay.time - before == pytest.approx(moved, abs=1e-6)
    assert window.live.paused
    line = window.replay_bar.line
    QTest.mouseClick(line, Qt.MouseButton.LeftButton, pos=QPoint(round(line.place(2.0)), 5))
    assert replay.time == pytest.approx(2.0, abs=SECONDS / line.width())
    assert [text for _, text in line.markers] == ["here"]
    replay.close()
    QTest.keyClick(window.centre.scene, Qt.Key.Key_Right)
    assert replay.time == 0.0


def test_a_missing_law_is_reported_and_the_plots_continue(reset_idle_window, qtbot, home):
    window = reset_idle_window
    replay = opened(window, qtbot, write(home / "b.hapkit", GONE, SPRING))
    assert window.replay_bar.label.text().startswith("The environment my_lost_law is not installed")
    assert window.studio.environment.key == "wall"
    assert window.centre.time.shown.now is not None
    replay.seek(0.6)
    assert not window.replay_bar.label.isVisible()
    assert window.studio.environment.key == "spring"
    replay.close()


def test_an_invalid_file_gives_a_reason_and_changes_nothing(reset_idle_window, qtbot, home):
    window = reset_idle_window
    (home / "c.hapkit").write_text("a letter")
    opened(window, qtbot, home / "c.hapkit")
    assert window.replay.history is None
    assert window.banners.get("replay").text == "c.hapkit is not a session of Hapkit Studio."


@pytest.mark.skipif(not built(), reason="the virtual board is not built")
def test_a_motor_gives_no_force_from_the_replay_on_until_render(make_window, qtbot, home, tmp_path):
    """The test reads the force on the paddle; the hand stays in a wall before, during and after replay."""
    board = VirtualBoard("lockstep", log=tmp_path / "truth.bin")
    entry = DeviceEntry("virtual-board", "Virtual board", lambda: board)
    window = make_window((SIMULATED, entry))
    studio, replay = window.studio, window.replay
    studio.device.open(entry)
    qtbot.waitUntil(lambda: studio.engine is not None)
    studio.move_hand(0.014)

    def newest(column, samples=300):
        """Wait for this many new samples; return the newest value of a column."""
        seen = window.live.last[rows.TICK] if window.live.last is not None else 0.0

        def came():
            clear_lateness(studio)
            window.live.tick()
            return window.live.last is not None and window.live.last[rows.TICK] >= seen + samples

        qtbot.waitUntil(came)
        return window.live.last[column]

    qtbot.waitUntil(lambda: newest(rows.APPLIED_FORCE, 10) < -0.3)
    opened(window, qtbot, write(home / "a.hapkit", {**WALL, "parameters": {"stiffness": 5000.0}}))
    since = newest(rows.BOARD_TIME)
    assert studio.values["stiffness"] == 5000.0
    assert newest(rows.APPLIED_FORCE) == 0.0
    replay.close()
    assert newest(rows.APPLIED_FORCE) == 0.0
    assert window.banners.get("stop").title == "The motor is off until you press Render."
    until = newest(rows.BOARD_TIME, 1)
    studio.release_stop()
    qtbot.waitUntil(lambda: newest(rows.APPLIED_FORCE, 10) < -0.3)
    window.live.stop()
    studio.close()
    log = truth(tmp_path / "truth.bin")
    assert not np.any(log.motor_force[(log.time > since) & (log.time < until)])
    assert np.any(log.motor_force[log.time > until])


@pytest.mark.slow
def test_pressing_render_during_a_replay_ends_it(board_window, qtbot, home):
    studio, replay = board_window.studio, board_window.replay
    rate = studio.loop.rate
    opened(board_window, qtbot, write(home / "a.hapkit", {**WALL, "rate_Hz": 500.0}))
    assert studio.engine.stopped
    assert studio.waits_for_render
    assert studio.loop.rate == rate
    studio.release_stop()
    assert replay.history is None
    assert not studio.engine.stopped
    assert studio.values == studio.environment.values()


def test_zoomed_plots_do_not_move_until_the_user_seeks(replay, reset_idle_window):
    window, view = reset_idle_window, reset_idle_window.centre.view
    axis = window.centre.time.canvases[-1].view
    for go in (lambda: replay.seek(2.0), lambda: replay.step(-1)):
        replay.seek(2.5)
        axis.setXRange(-1.5, -1.0, padding=0)
        stood = view.stretch
        assert stood == pytest.approx((START + 1.0, START + 1.5), abs=1e-6)
        replay.settle()
        pass_time(replay, 0.2)
        assert view.stretch == stood
        go()
        assert view.zero + view.right == pytest.approx(replay.history.now)
    window.centre.scene.setFocus()
    QTest.keyClick(window.centre.scene, Qt.Key.Key_Backspace)
    assert replay.history is None


@pytest.mark.slow
@pytest.mark.parametrize(
    ("way", "start", "stop", "then"),
    [("visible", 1.0004, 1.5004, SPRING), ("selected", 0.0995, 0.4005, WALL)],
)
def test_an_export_contains_the_session_samples_and_their_settings(
    replay, reset_idle_window, home, monkeypatch, way, start, stop, then
):
    """The spring is active from 0.5 s on. Each cursor is on a sample, which belongs to the exported range."""
    window, saves = reset_idle_window, []
    replay.seek(2.5004)
    replay.settle()
    window.centre.time.canvases[-1].view.setXRange(-1.5, -1.0, padding=0)
    window.centre.time.cursors.show(True)
    for index, at in enumerate((0.4005, 0.1005)):
        window.centre.time.cursors.move(index, START + at)
    stretch = getattr(window.export, way)
    replay.history.complete = False  # as while dragging; the export must be complete nevertheless
    dialog = SimpleNamespace(selectedNameFilter=lambda: "Table (*.csv)")
    monkeypatch.setattr(export, "choose_file", lambda *given, **_: saves.append(given[3]) or dialog)
    window.export.ask(stretch)
    saves[0](str(home / "a.csv"))
    end_all(window.export)
    settings, found = read(home / "a.csv")
    expected = hs.open_session(home / "a.hapkit", start, stop)
    np.testing.assert_allclose(found["position_m"], expected.position, rtol=1e-8)
    np.testing.assert_allclose(found["energy_J"], expected.energy, rtol=1e-8)
    assert settings["environment"] == then["environment"]
    assert settings["stiffness"] == f"{then['parameters']['stiffness']:g}"
    assert not [name for name in settings if " at " in name]


def test_a_replay_adds_no_dividers_but_later_changes_by_the_user_do(replay, reset_idle_window, qtbot):
    live, studio = reset_idle_window.live, reset_idle_window.studio
    live.history.append(np.zeros((1, rows.ROW_WIDTH)))
    live.history.dividers.clear()
    replay.seek(0.6)
    replay.seek(0.1)
    assert not live.history.dividers
    studio.set_value("damping", 3.0)
    qtbot.waitUntil(lambda: replay.history is None)
    assert [text for _, text in live.history.dividers] == ["Damping 0.0 → 3.0 N·s/m"]
    live.history.clear()


def test_locked_settings_are_not_changed_and_the_plots_continue(reset_idle_window, qtbot, home):
    window, studio = reset_idle_window, reset_idle_window.studio
    studio.permissions.set_lock(Lock.closed([("environment",)], "1234"))
    replay = opened(window, qtbot, write(home / "a.hapkit", WALL, SPRING))
    assert studio.values["stiffness"] == 700.0
    replay.seek(2.5)
    assert studio.environment.key == "wall"
    assert window.replay_bar.label.text().startswith("Some of these settings are locked")
    assert window.centre.time.shown.now["position"] == pytest.approx(2.5 * SPEED, abs=QUANTUM)
    replay.close()
    studio.permissions.set_lock(Lock())
    assert studio.values == studio.environment.values()


def test_replay_and_blind_comparison_exclude_each_other(reset_idle_window, qtbot, home):
    window, studio = reset_idle_window, reset_idle_window.studio
    for stiffness in (300.0, 900.0):
        studio.set_value("stiffness", stiffness)
        window.two.step()
    page = window.views.page("sessions")
    window.blind.begin()
    replay = opened(window, qtbot, write(home / "a.hapkit", WALL))
    assert (replay.history, bool(studio.hidden), page.replay.isEnabled()) == (None, True, False)
    assert window.banners.get("replay").text == "Values are hidden during the blind comparison."
    window.blind.page.finish()
    window.banners.set("replay", None)
    opened(window, qtbot, home / "a.hapkit")
    window.actions_by_key.refresh()
    assert not window.actions_by_key.qt["teach.blind"].isEnabled()
    replay.close()
    window.two.forget()


def test_a_replay_ends_a_demo_and_restores_the_settings_before_it(reset_idle_window, qtbot, home, tmp_path):
    window, studio = reset_idle_window, reset_idle_window.studio
    before = settings_of(studio)
    window.play_demo(written(tmp_path))
    with studio.temporarily():
        studio.set_value("stiffness", 900.0)  # the demo's first step sets this value
    window.demos._ours = settings_of(studio)
    replay = opened(window, qtbot, write(home / "a.hapkit", WALL))
    qtbot.wait(1)
    assert window.demos.demo is None
    assert studio.values["stiffness"] == 700.0
    window.actions_by_key.refresh()
    assert not window.actions_by_key.qt["teach.open_demo"].isEnabled()
    replay.close()
    assert settings_of(studio) == before
