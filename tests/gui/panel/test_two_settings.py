"""Settings A and B, switched with one key and compared blind."""

import random

import pytest
from PySide6.QtCore import QPoint, QRect, Qt
from PySide6.QtWidgets import QLabel

from hapkit_studio.errors import ParameterError
from hapkit_studio.gui.panel.two_settings import TwoSettingsDialog
from hapkit_studio.gui.state.undo import settings_of
from hapkit_studio.gui.teach.blind import score
from hapkit_studio.gui.teach.demos import Demo, Step
from tests.gui.panel.test_stability_card import WALL, answer, asked
from tests.gui.shell.test_actions import press
from tests.gui.window_support import SIMULATED, label_texts, sheet_of

SOFT, STIFF = {"stiffness": 300.0}, {"stiffness": 900.0}


@pytest.fixture
def window(reset_idle_window):
    """Return this test file's window with no stored settings and an empty undo history."""
    reset_idle_window.two.forget()
    reset_idle_window.history.forget()
    return reset_idle_window


@pytest.fixture
def compared(window):
    """Return a window with a soft A and a stiff B, and a list of all rendered values."""
    for values in (SOFT, STIFF):
        window.studio.set_values(values)
        window.two.step()
    window.studio.set_value("stiffness", 500.0)
    rendered, hide = [], window.studio.hide_values

    def note(values, *why):
        rendered.append(values and values["stiffness"])
        hide(values, *why)

    window.studio.hide_values = note
    yield window, rendered
    window.studio.hide_values = hide
    window.studio.hide_values(None)


@pytest.mark.slow
def test_one_key_stores_a_then_b_then_switches_values_and_loop(window):
    studio, row, action = window.studio, window.panel.two, window.actions_by_key.qt["teach.switch"]
    assert row.isHidden()
    assert action.text() == "Store settings as A"
    press(window, Qt.Key.Key_X)
    press(window, Qt.Key.Key_X)
    assert len(window.two.stored) == 1  # the same settings are not stored twice
    assert (row.label.text(), row.button.isEnabled()) == ("Settings A are active", False)
    studio.set_values(STIFF)
    studio.set_loop(delay=0.002)
    assert (row.label.text(), row.button.text()) == (
        "These settings are neither A nor B",
        "Store settings as B",
    )
    press(window, Qt.Key.Key_X)
    steps = window.history.stack.count()
    for sign, stiffness, delay in (("A", 250.0, 0.0), ("B", 900.0, 0.002), ("A", 250.0, 0.0)):
        press(window, Qt.Key.Key_X)
        assert (studio.values["stiffness"], studio.loop.delay) == (stiffness, delay)
        assert row.label.text() == f"Settings {sign} are active"
    assert window.history.stack.count() == steps  # switching adds no undo step
    studio.choose("spring")
    assert row.isHidden()
    studio.choose("wall")
    studio.set_value("damping", 1.0)
    press(window, Qt.Key.Key_X)  # neither A nor B is active, so the key selects the one that was active last
    assert row.label.text() == "Settings A are active"


def test_the_active_settings_are_visible_in_the_smallest_window(window, qapp):
    window.stability.show_answer(answer(asked(900.0, environment=WALL)))
    window.resize(1280, 720)
    press(window, Qt.Key.Key_X)
    qapp.processEvents()
    row, panel = window.panel.two, window.panel
    assert panel.rect().contains(QRect(row.mapTo(panel, QPoint()), row.size()))
    assert row.height() >= row.sizeHint().height()
    assert row.mapTo(panel, QPoint()).y() >= panel.upper.geometry().bottom()


def test_differences_are_listed_and_different_loops_are_not_compared_blind(window):
    window.two.step()
    window.studio.set_values(STIFF)
    window.studio.set_loop(delay=0.002)
    window.two.step()
    window.actions_by_key.run("teach.two_settings")
    dialog = sheet_of(window, TwoSettingsDialog)
    heads = ("Setting", "A", "B")
    assert dialog.table.texts() == [
        heads,
        ("Stiffness, N/m", "250", "900"),
        ("Added delay, ms", "0.0", "2.0"),
    ]
    assert not dialog.begin.isEnabled()
    assert not window.actions_by_key.qt["teach.blind"].isEnabled()
    dialog.drop.click()
    assert window.two.stored == []


def test_blind_answers_are_counted_and_nothing_reveals_the_settings(compared):
    """The rendered stiffness determines the right answer; seven of the eight answers are right."""
    window, rendered = compared
    before = settings_of(window.studio)
    window.blind.begin(random.Random(15))
    page = window.blind.page
    assert page is not None
    assert window.panel.isHidden()
    assert not window.header.tabs.isEnabled()
    first = []
    for number in range(8):
        first.append(rendered[-1])
        stiffer = int(rendered[-1] == SOFT["stiffness"])
        press(window, Qt.Key.Key_X)
        assert {first[-1], rendered[-1]} == {300.0, 900.0}
        assert settings_of(window.studio) == before
        texts = [part.text() for part in window.findChildren(QLabel) if part.isVisible()]
        assert not [text for text in texts if "300" in text or "900" in text]
        page.choices[stiffer if number != 4 else 1 - stiffer].click()
    assert set(first) == {300.0, 900.0}  # each of the two settings came first in some trials
    page.end_button.click()
    assert rendered[-1] is None
    assert settings_of(window.studio) == before
    assert not window.studio.hidden
    assert window.panel.isVisible()
    assert label_texts(sheet_of(window)) == [
        "Blind comparison",
        "7 of 8 answers are correct. Guessing would give 4.",
    ]


@pytest.mark.slow
def test_a_device_renders_hidden_values_also_after_a_reconnect(make_window, qtbot):
    window = make_window()
    studio = window.studio
    for values in (SOFT, STIFF):
        studio.set_values(values)
        window.two.step()
    studio.set_value("stiffness", 500.0)
    window.blind.begin(random.Random(2))
    for turn in (False, True):
        if turn:
            press(window, Qt.Key.Key_X)
        studio.device.open(SIMULATED)
        qtbot.waitUntil(lambda: studio.link.state == "running")
        hidden = studio.engine.values["stiffness"]
        assert hidden == (SOFT, STIFF)[window.blind.page._order[turn]]["stiffness"]
        assert window.centre.scene.accessibleName() == "Scene: Free"
    window.blind.page.finish()
    assert studio.engine.values["stiffness"] == 500.0
    assert window.centre.scene.accessibleName() == "Scene: Wall"


def test_hidden_settings_cannot_be_changed(compared):
    window, _ = compared
    studio, run = window.studio, window.actions_by_key.run
    window.blind.begin(random.Random(1))
    before = settings_of(studio)
    for change in (
        lambda: studio.set_value("stiffness", 1.0),
        lambda: studio.set_loop(rate=500.0),
        lambda: studio.set_loop(hand="firm"),
    ):
        with pytest.raises(ParameterError, match="hidden during the blind comparison"):
            change()
    studio.set_loop(rate=studio.loop.rate)  # an unchanged value is not refused
    press(window, "1")
    for key in ("environment.reset", "edit.undo", "view.tab.stability"):
        run(key)
    assert settings_of(studio) == before
    assert window.views.key == "live"
    assert studio.hidden
    run("session.stop")
    assert studio.stopped  # stopping is never locked
    run("session.release")
    with studio.temporarily():  # a measurement changes settings in this way, and ends the comparison
        studio.set_value("stiffness", 400.0)
    assert not studio.hidden
    assert window.blind.page is None
    assert studio.values["stiffness"] == 400.0


def test_a_demo_ends_when_a_comparison_starts_or_one_line_gives_the_reason(compared):
    window, rendered = compared
    before = settings_of(window.studio)
    step = Step(0.0, before | {("value", "wall", "stiffness"): 100.0}, "", ())
    window.demos.play(Demo("Soft", 9.0, (step,)))
    window.demos._apply(step)  # the window does this as soon as it has a device
    window.blind.begin(random.Random(3))
    assert (window.demos.demo, rendered[-1] in (300.0, 900.0)) == (None, True)
    assert window.blind.page.isVisible()
    window.blind.page.finish()
    assert settings_of(window.studio) == before
    window.studio.choose("spring")
    window.demos.play(Demo("Soft", 9.0, (step,)))
    window.demos._apply(step)
    window.blind.begin()
    assert (window.demos.demo, window.blind.page) == (None, None)
    assert window.studio.environment.key == "spring"
    assert "they belong to the environment of the demo" in window.banners.get("undo").text
    window.studio.choose("wall")


@pytest.mark.parametrize(
    ("right", "answers", "text"),
    [(0, 0, "No answer was given."), (2, 3, "2 of 3 answers are correct. Guessing would give 1.5.")],
)
def test_the_score_states_the_average_of_guessing(right, answers, text):
    assert score(right, answers) == text
