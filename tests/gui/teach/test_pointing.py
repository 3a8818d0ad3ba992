"""The pointing experiment in the window: targets in the scene, hidden friction, trials in the recording."""

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from hapkit_studio.analysis import pointing
from hapkit_studio.analysis.pointing import BY_MODEL, CONDITIONS, LOW, Target
from hapkit_studio.gui.state import permissions
from hapkit_studio.gui.state.lock import Lock
from hapkit_studio.gui.teach.experiment import ResultDialog
from hapkit_studio.gui.teach.pointing import PointingDialog
from hapkit_studio.lessons import experiments
from tests.gui.window_support import label_texts, sheet_of

TARGETS = [Target(CONDITIONS[0], 0.020, 0.006, 1), Target(CONDITIONS[1], 0.020, 0.006, -1)]


@pytest.fixture
def pointed(reset_window, qtbot):
    """Return a running window in the experiment, with two targets."""
    window = reset_window
    window.studio.set_loop(hand="firm")
    window.pointing.begin(TARGETS)
    qtbot.waitUntil(lambda: window.pointing.page is not None)
    yield window
    window.pointing.end()
    qtbot.waitUntil(lambda: window.studio.recording.progress is None)


def rendered(window):
    return window.studio.engine.values["kinetic_force"]


def hold(window, qtbot, goal, until):
    """Pull the handle to a position, with an extra distance to overcome friction, until a condition holds."""
    pull = 0.0

    def follow():
        nonlocal pull
        window.live.tick()
        pull += 0.02 * (goal - window.centre.scene._motion.position / 1e3)
        pull = max(-0.008, min(pull, 0.008))
        window.studio.move_hand(goal + pull)
        return until()

    qtbot.waitUntil(follow)


@pytest.mark.slow
def test_a_whole_experiment_is_recorded_and_evaluated(pointed, qtbot):
    window, page = pointed, pointed.pointing.page
    assert window.studio.hidden == permissions.POINTING
    assert window.centre.scene.isVisible()
    for at, target in enumerate(TARGETS):
        assert rendered(window) == target.condition.force
        zone = window.centre.scene._zone
        assert (zone.name, 0.5 * (zone.low + zone.high)) == ("start", pytest.approx(target.start))
        hold(window, qtbot, target.start, lambda: page.run.going)
        zone = window.centre.scene._zone
        assert zone == pytest.approx((target.middle - 0.003, target.middle + 0.003, "target", "ok"))
        hold(window, qtbot, target.middle, lambda at=at: len(page.run.done) > at)
    assert window.pointing.page is None
    assert not window.studio.hidden
    assert window.centre.scene._zone is None
    assert len(page.run.done) == 2
    text = " ".join(label_texts(sheet_of(window, ResultDialog)))
    assert "Trials: 2." in text
    qtbot.waitUntil(lambda: window.studio.recording.newest is not None)
    path, _ = window.studio.recording.newest
    assert path.name in text
    found = experiments.read(path)
    assert found.trials == tuple(page.run.done)
    assert found.remarks == ()


def test_the_scene_shows_neither_friction_nor_force(pointed):
    """Only the handle is drawn, because bristles and the force arrow would reveal the condition."""
    scene = pointed.centre.scene
    assert scene._scene.environment.key == "free"
    assert not scene._shows_force
    assert "force" not in scene.accessibleDescription()
    assert not pointed.centre.time.isVisible()
    pointed.pointing.end()
    assert scene._shows_force
    assert scene._scene.environment.key == "friction"


def test_a_stopped_experiment_shows_the_results_so_far(pointed, qtbot):
    page = pointed.pointing.page
    qtbot.mouseClick(page.stop, Qt.MouseButton.LeftButton)
    assert pointed.pointing.page is None
    assert "No trial was completed." in label_texts(sheet_of(pointed))


def test_an_e_stop_restarts_the_trial(pointed, qtbot):
    window, page = pointed, pointed.pointing.page
    hold(window, qtbot, TARGETS[0].start, lambda: page.run.going)
    window.studio.stop()
    assert not page.run.going
    assert page.sign.text() == "Release the E-stop to continue"
    window.studio.release_stop()
    assert page.sign.text() == "Hold the handle in the start range"
    assert page.run.target == TARGETS[0]


def test_the_dialog_is_operated_by_keyboard(reset_window, qtbot):
    """The plan has 2 rounds of 8 conditions and 9 pairs of distance and width: 144 trials."""
    window = reset_window
    window.actions_by_key.run("teach.pointing")
    dialog = sheet_of(window, PointingDialog)
    begun = []
    dialog.begun.disconnect()
    dialog.begun.connect(begun.append)
    dialog.conditions.setFocus()
    QTest.keyClick(dialog.conditions, Qt.Key.Key_Down)
    assert dialog.conditions.currentData() == BY_MODEL
    QTest.keyClick(dialog.rounds, Qt.Key.Key_Up)
    assert dialog.rounds.currentText() == "2 rounds, 144 trials"
    QTest.keyClick(dialog, Qt.Key.Key_Return)
    (targets,) = begun
    assert len(targets) == 144
    assert {one.condition.force for one in targets} == {0.0, LOW}


def test_no_experiment_starts_while_friction_is_locked(reset_window, qtbot):
    window = reset_window
    window.studio.choose("friction")
    window.studio.permissions.set_lock(Lock((("value", "friction", "kinetic_force"),)))
    try:
        window.pointing.begin(pointing.plan(seed=0))
        assert window.pointing.page is None
        assert window.studio.recording.progress is None
        assert "locked" in window.banners.get("undo").text.lower()
    finally:
        window.studio.permissions.set_lock(Lock())
