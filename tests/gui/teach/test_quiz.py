"""The quiz: it draws a value, hides it, and judges an estimate."""

import random
import re

import pytest
from PySide6.QtWidgets import QAbstractButton, QAbstractSpinBox, QLabel, QLineEdit, QWidget

from hapkit_studio.analysis.stability.verdict import VerdictInput
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.environments import discover
from hapkit_studio.errors import ParameterError
from hapkit_studio.gui.live.cursors import slope
from hapkit_studio.gui.state.lock import Lock
from hapkit_studio.gui.state.undo import settings_of
from hapkit_studio.gui.teach.demos import read, shipped
from hapkit_studio.gui.teach.quiz import asked_for, comparison, draw, first_calm
from hapkit_studio.haptics.engine import Engine
from hapkit_studio.quantity import Quantity
from tests.gui.shell.test_actions import press
from tests.gui.window_support import SIMULATED

LIBRARY = discover()
STIFFNESS = Quantity(LIBRARY["wall"].parameters[0])


def texts(window):
    """Yield every text, tooltip, accessible name and menu entry of a window, visible or not."""
    for part in (window, *window.findChildren(QWidget)):
        yield from (part.toolTip(), part.accessibleName(), part.statusTip(), part.windowTitle())
        if isinstance(part, QLabel | QAbstractButton | QLineEdit | QAbstractSpinBox):
            yield part.text()
    for action in window.actions():
        yield from (action.text(), action.toolTip())
    yield from (text for _, text in window.live.history.dividers)


@pytest.fixture
def asked(reset_window, qtbot):
    """Return a running window with the quiz on the wall and a hidden value."""
    window = reset_window
    window.quiz.begin(random.Random(7))
    qtbot.waitUntil(lambda: window.quiz.side.show_true.isEnabled())
    yield window
    window.quiz.end()


def test_only_laws_of_a_single_spring_or_damper_have_a_quiz():
    for key, name in {"spring": "stiffness", "wall": "stiffness", "damping": "damping"}.items():
        assert asked_for(LIBRARY[key], LIBRARY[key].values()).key == name
    for key in ("free", "friction", "texture", "puck"):
        assert asked_for(LIBRARY[key], LIBRARY[key].values()) is None


def test_values_are_multiples_of_the_step_from_half_to_four_times_the_default():
    """The values of the wall go from 120 (125 rounded to even) to 1,000 N/m.

    The default is 250 N/m, the step 10 N/m.
    """
    seen = set()
    for seed in range(40):
        drawn = draw(LIBRARY["wall"].parameters[0], random.Random(seed))
        assert drawn == draw(LIBRARY["wall"].parameters[0], random.Random(seed))
        assert len(set(drawn)) == len(drawn) == 20
        seen |= set(drawn)
    assert seen == {10.0 * step for step in range(12, 101)}


def test_the_first_calm_value_is_selected_and_none_if_all_buzz():
    """With a delay of 20 ms, a spring is passive below b / (T/2 + delay) = 0.5 / 0.0205 = 24 N/m."""
    spring, progress = LIBRARY["spring"], lambda _done, _of: None
    asked = VerdictInput(spring, spring.values(), LoopSettings(delay=0.02, hand="medium"))
    for drawn, found in (([1900.0, 1000.0, 20.0, 10.0], 20.0), ([1900.0, 1000.0], None)):
        assert first_calm(asked, "stiffness", drawn, progress) == found


@pytest.mark.parametrize(
    ("estimate", "true", "error", "text"),
    [
        (310.0, 340.0, -8.8235, "You entered 310 N/m. The true value is 340 N/m: 8.8 % too low."),
        (1500.0, 1000.0, 50.0, "You entered 1,500 N/m. The true value is 1,000 N/m: 50.0 % too high."),
        (340.0, 340.0, 0.0, "You entered 340 N/m. The true value is 340 N/m: right."),
    ],
)
def test_an_estimate_is_judged_in_one_sentence(estimate, true, error, text):
    found, sentence = comparison(STIFFNESS, estimate, true)
    assert found == pytest.approx(error, abs=1e-4)
    assert sentence == text


@pytest.mark.slow
def test_the_hidden_value_is_rendered_but_shown_nowhere(asked):
    """Only the engine has the true value: no text contains it, and no setting can be changed."""
    window, studio = asked, asked.studio
    true = studio.engine.values["stiffness"]
    assert true != studio.values["stiffness"] == 250.0
    written = re.compile(rf"(?<![\d.,]){true:,.0f}(?!\d|,\d|\.[1-9])")
    window.live.tick()
    assert not [text for text in texts(window) if written.search(text)]
    side, phase = window.quiz.side, window.centre.phase
    assert side.isVisible()
    assert window.centre.time.isVisible()
    assert phase.canvas.isVisible()
    assert not window.panel.isVisible()
    assert not window.centre.toolbar.keep.isEnabled()
    assert not [part for part in phase.theory if part.isVisible()]
    assert window.centre.scene.accessibleName() == "Scene: Wall"
    with pytest.raises(ParameterError, match="hidden during the quiz"):
        studio.set_value("stiffness", 300.0)
    actions = window.actions_by_key.qt
    for key in ("view.hold", "view.projector", "session.export_kept", "session.copy_picture", "edit.undo"):
        assert not actions[key].isEnabled()


@pytest.mark.slow
def test_the_cursors_measure_the_hidden_stiffness_while_pushing_into_the_wall(asked, qtbot):
    """Without damping, the slope of force over position is the stiffness, to 1 % (Hooke's law).

    The hand pushes in, out and in again, each for 0.4 s in the loop's time.
    """
    window, studio = asked, asked.studio
    live, cursors = window.live, window.centre.time.cursors
    ramped = live.history.changes[-1] + 0.1
    depth = 1.5 / studio.engine.values["stiffness"]  # the depth at half the force limit
    try:
        studio.move_hand(0.0)
        qtbot.waitUntil(lambda: reached(live, ramped))
        begun = live.history.now
        # the target is three times as deep as the handle shall go, because the hand yields like a spring
        for target in (3.0 * depth, 0.0, 3.0 * depth):
            studio.move_hand(studio.values["position"] + target)
            until = live.history.now + 0.4
            qtbot.waitUntil(lambda until=until: reached(live, until))
    finally:
        studio.move_hand(None)
    cursors.show(True)
    cursors.move(0, begun)
    cursors.move(1, live.history.now)
    found, text = slope(cursors, cursors.between())
    assert found is not None, text
    assert found.slope == pytest.approx(-studio.engine.values["stiffness"], rel=0.01)
    window.centre.phase.cursors.refresh()
    assert window.centre.phase.cursors.slope.text() == text
    cursors.show(False)


def reached(live, time):
    """Read the new rows and return True if they extend beyond a time."""
    live.tick()
    return live.history.now > time


def test_actions_that_would_show_or_change_the_value_are_refused_in_one_line(asked):
    """Panel, projector, lock, A and B, presets, views, replay and demos are refused; stopping is not."""
    window, studio = asked, asked.studio
    before, side = settings_of(studio), window.quiz.side
    actions = window.actions_by_key
    for key in (
        "view.panel",
        "teach.switch",
        "teach.two_settings",
        "teach.lock",
        "teach.blind",
        "teach.quiz",
    ):
        actions.run(key)
        assert not actions.qt[key].isEnabled()
    press(window, "X")
    assert window.two.stored == []
    for refused, line in (
        (lambda: window.views.show("sessions"), "Values are hidden during the quiz."),
        (lambda: studio.choose("spring"), "Spring: values are hidden during the quiz."),
    ):
        refused()
        assert window.banners.get("undo").text == line
    demo = read(next(iter(shipped().values())), studio.environments)
    with pytest.raises(ParameterError, match="A demo cannot play while settings are locked or hidden"):
        window.demos.play(demo)
    assert (settings_of(studio), window.quiz.side, window.views.key) == (before, side, "live")
    assert side.isVisible()


@pytest.mark.slow
@pytest.mark.parametrize("size", [(1440, 900), (1100, 700)])
def test_the_quiz_column_is_visible_where_the_panel_is_a_drawer(reset_window, size):
    window = reset_window
    window.resize(*size)
    window.body.open_drawer(False)
    window.quiz.begin(random.Random(7))
    assert window.quiz.side.isVisible()
    window.quiz.end()
    assert not window.panel_open


@pytest.mark.slow
def test_the_engine_receives_only_values_and_a_change_of_device_ends_the_quiz(
    reset_window, qtbot, monkeypatch
):
    """The quiz changes no other settings of the engine than the hidden value."""
    window, studio, calls = reset_window, reset_window.studio, []
    for name in ("stop", "release_stop", "clear_fault", "set_loop", "change_loop", "set_where"):
        monkeypatch.setattr(Engine, name, lambda *_given, name=name: calls.append(name))
    render = Engine.set_environment
    monkeypatch.setattr(Engine, "set_environment", lambda *given: calls.append(given[1:]) or render(*given))
    window.quiz.begin(random.Random(7))
    qtbot.waitUntil(lambda: window.quiz.side.show_true.isEnabled())
    hidden = studio.engine.values["stiffness"]
    window.quiz.end()
    same = [(studio.environment, {**studio.values, "stiffness": value}) for value in (250.0, hidden, 250.0)]
    assert calls == same
    monkeypatch.undo()
    window.quiz.begin(random.Random(7))
    studio.device.open(SIMULATED)
    qtbot.waitUntil(lambda: window.quiz.side is None and studio.link.state == "running")
    assert studio.engine.values == studio.values
    assert window.panel.isVisible()


def test_no_quiz_starts_while_the_value_is_locked_or_the_scene_is_in_use(reset_window, monkeypatch):
    window, studio = reset_window, reset_window.studio
    assert window.quiz.parameter.key == "stiffness"
    with studio.temporarily():  # a measurement or a replay changes the scene in this way
        assert window.quiz.parameter is None
    studio.permissions.set_lock(Lock(frozenset({("value", "wall", "stiffness")})))
    assert window.quiz.parameter is None
    studio.permissions.set_lock(Lock())
    for part, shows in ((window.projector, "on"), (window.demos, "demo")):
        with monkeypatch.context() as patch:
            patch.setattr(part, shows, True)
            window.actions_by_key.run("teach.quiz")
            assert window.quiz.side is None
    window.actions_by_key.run("teach.quiz")
    assert window.quiz.side is not None
    window.quiz.end()


def test_errors_are_averaged_and_all_settings_return(asked, qtbot):
    """One estimate is half the value, one is right: errors of 50 % and 0 % have a mean of 25 %."""
    window, studio, side = asked, asked.studio, asked.quiz.side
    before, undone = settings_of(studio), window.history.stack.count()
    for share, count in (
        (0.5, "Estimates: 1. Mean error: 50.0 %."),
        (1.0, "Estimates: 2. Mean error: 25.0 %."),
    ):
        side.box.setValue(share * studio.engine.values["stiffness"])
        side.show_true.click()
        assert side.count.text() == count
        side.compare()  # a second comparison of the same estimate is not counted
        if share < 1.0:
            side.more.click()
            qtbot.waitUntil(lambda: side.show_true.isEnabled())
    assert side.count.text() == "Estimates: 2. Mean error: 25.0 %."
    studio.stop()
    assert studio.stopped  # the stop is never locked
    studio.release_stop()
    side.leave.click()
    assert (settings_of(studio), window.history.stack.count()) == (before, undone)
    assert studio.engine.values == studio.values
    assert window.panel.isVisible()
    assert window.centre.toolbar.keep.isEnabled()
    assert [part for part in window.centre.phase.theory if part.isVisible()]


@pytest.mark.slow
def test_comparing_without_an_estimate_does_not_count(asked):
    side = asked.quiz.side
    for typed, text in ((0.0, "Enter your estimate first."), (6000.0, STIFFNESS.limits())):
        side.box.setValue(typed)
        side.show_true.click()
        assert side.answer.label.text() == text
    assert side.errors == []


def test_a_quiz_without_a_calm_value_says_so_and_a_measurement_ends_the_quiz(asked):
    side = asked.quiz.side
    side._render(None)
    assert side.answer.label.text().startswith("No stable value was found")
    with asked.studio.temporarily():
        asked.studio.set_value("stiffness", 400.0)
    assert asked.quiz.side is None
    assert asked.studio.engine.values["stiffness"] == 400.0
