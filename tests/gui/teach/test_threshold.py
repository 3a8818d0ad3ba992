"""The just-noticeable difference in the window: a staircase chooses the step, every answer is recorded."""

import random

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from hapkit_studio.analysis import discrimination
from hapkit_studio.gui.state import permissions
from hapkit_studio.gui.state.lock import Lock
from hapkit_studio.gui.teach.experiment import ResultDialog
from hapkit_studio.gui.teach.threshold import ThresholdDialog, comparable, room
from hapkit_studio.lessons import experiments
from tests.gui.shell.test_actions import press
from tests.gui.window_support import label_texts, sheet_of


@pytest.fixture
def compared(reset_window, qtbot):
    """Return a running window that compares stiffnesses about 100 N/m."""
    window = reset_window
    window.studio.choose("spring")
    qtbot.waitUntil(lambda: window.studio.environment.key == "spring")
    window.studio.set_value("stiffness", 100.0)
    window.studio.note_ranges({})
    (parameter,) = [one for one in comparable(window.studio) if one.key == "stiffness"]
    window.threshold.begin(parameter, random.Random(3))
    yield window
    window.threshold.end()
    qtbot.waitUntil(lambda: window.studio.recording.progress is None)


def right_place(page):
    """Return the index of the correct button, which belongs to the interval with the larger value."""
    values = [page._values[at]["stiffness"] for at in page._order]
    return values.index(max(values))


@pytest.mark.slow
def test_the_staircase_ends_the_experiment_and_every_answer_is_recorded(compared, qtbot, monkeypatch):
    """The staircase has three reversals instead of twelve, and each of its steps is rendered."""
    monkeypatch.setattr(discrimination, "REVERSALS", 3)
    window, page = compared, compared.threshold.page
    observer, chance = discrimination.Observer(0.1), random.Random(5)
    while window.threshold.page is not None:
        assert sorted(one["stiffness"] for one in page._values) == pytest.approx(
            [100.0, 100.0 * (1.0 + page.stairs.step)]
        )
        right = chance.random() < observer.share(page.stairs.step)
        page.choices[right_place(page) if right else 1 - right_place(page)].click()
    assert len(page.stairs.reversals) == discrimination.REVERSALS
    assert not window.studio.hidden
    assert window.studio.engine.values["stiffness"] == 100.0
    text = " ".join(label_texts(sheet_of(window, ResultDialog)))
    assert "Weber fraction" in text
    qtbot.waitUntil(lambda: window.studio.recording.newest is not None)
    path, _ = window.studio.recording.newest
    found = experiments.read(path)
    assert found.comparisons == tuple(page.found)
    assert {one.parameter for one in found.comparisons} == {"stiffness"}


def test_the_key_x_switches_between_the_two(compared):
    window, page = compared, compared.threshold.page
    assert window.studio.hidden == permissions.THRESHOLD
    first = window.studio.engine.values["stiffness"]
    press(window, Qt.Key.Key_X)
    second = window.studio.engine.values["stiffness"]
    assert sorted((first, second)) == [100.0, 150.0]
    assert page.sign.text() == "Setting 2 is active"
    press(window, Qt.Key.Key_X)
    assert window.studio.engine.values["stiffness"] == first


def test_an_experiment_that_is_stopped_says_so(compared):
    page = compared.threshold.page
    page.choices[right_place(page)].click()
    QTest.mouseClick(page.end_button, Qt.MouseButton.LeftButton)
    assert compared.threshold.page is None
    texts = label_texts(sheet_of(compared, ResultDialog))
    assert "You stopped after 1 answer, so the result is uncertain." in texts


def test_only_what_can_be_raised_within_the_stable_range_is_compared(reset_window):
    studio = reset_window.studio
    studio.choose("wall")
    studio.set_values({"stiffness": 300.0, "damping": 0.0})
    studio.note_ranges({})
    (stiffness,) = comparable(studio)  # damping is left out, because a fraction of 0 is 0
    assert room(studio, stiffness) == pytest.approx(1.0)
    studio.note_ranges({"stiffness": [(400.0, 5000.0)]})
    assert room(studio, stiffness) == pytest.approx(1.0 / 3.0)
    studio.note_ranges({"stiffness": [(310.0, 5000.0)]})
    assert comparable(studio) == []
    studio.note_ranges({})


def test_the_dialog_names_the_parameters_and_begins_by_keyboard(reset_window):
    window = reset_window
    window.studio.note_ranges({})
    window.actions_by_key.run("teach.threshold")
    dialog = sheet_of(window, ThresholdDialog)
    assert dialog.parameter.itemText(0) == "Stiffness, 250 N/m"
    begun = []
    dialog.begun.disconnect()
    dialog.begun.connect(begun.append)
    QTest.keyClick(dialog, Qt.Key.Key_Return)
    assert [one.key for one in begun] == ["stiffness"]


def test_an_environment_without_such_a_parameter_says_so(reset_window, qtbot):
    window = reset_window
    window.studio.choose("free")
    qtbot.waitUntil(lambda: window.studio.environment.key == "free")
    window.actions_by_key.run("teach.threshold")
    dialog = sheet_of(window, ThresholdDialog)
    assert not dialog.start.isEnabled()
    assert "no stiffness, damping or force" in dialog.verdict.label.text()


def test_a_locked_parameter_is_not_compared(reset_window):
    window = reset_window
    (parameter, *_) = comparable(window.studio)
    window.studio.permissions.set_lock(Lock((("value", "wall", "stiffness"),)))
    try:
        for seed in range(4):  # test both orders of the two intervals
            window.threshold.begin(parameter, random.Random(seed))
            assert window.threshold.page is None
        assert window.studio.recording.progress is None
    finally:
        window.studio.permissions.set_lock(Lock())
