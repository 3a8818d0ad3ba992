"""The view Lessons: list, scene and locks of a step, checks on live data, answers, stored progress."""

import itertools
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QDesktopServices, QTextDocumentFragment
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QLabel

from hapkit_studio.errors import ParameterError
from hapkit_studio.gui.pages.lessons.page import StepDot
from hapkit_studio.gui.pages.lessons.player import scene_settings
from hapkit_studio.gui.pages.lessons.tasks import HintPart
from hapkit_studio.gui.pages.lessons.text import formula_label
from hapkit_studio.gui.state.undo import differing, settings_of
from hapkit_studio.gui.teach.demos import shipped
from hapkit_studio.gui.widgets.theme import theme
from hapkit_studio.lessons import library
from hapkit_studio.lessons.evaluate import WRONG, Result
from hapkit_studio.lessons.lesson import Formula
from hapkit_studio.lessons.progress import Progress, file_of
from tests.gui.shell.test_layout import resize
from tests.gui.window_support import delete_deferred
from tests.wide import wide

WALL = "virtual_wall"

SMALL = """+++
title = "Small"
aim = "Try everything."
minutes = 3
order = 1
environments = ["spring"]
hide = ["theory", "verdict", "map", "values", "energy"]
lock = ["stiffness", "loop", "environment"]
+++

Text with `$K d$` and <b>no HTML</b>.

## First

```math
F = -K\\,x
```

```hint
Move the *handle*.
```

```check
title = "Move the handle by 10 mm."
measure = "travel"
at_least = 0.010
seconds = 0.5
```

```question
text = "Which way?"
options = ["left", "right"]
answer = "right"
wrong = "Look again."
```

```question
text = "How stiff?"
value = 300
unit = "N/m"
tolerance = 10
```

## Second

```set
values = {stiffness = 500.0}
hide = []
lock = []
```

```question
text = "What did you feel?"
```
"""


@pytest.fixture
def page(reset_window, home):
    """Return the list of lessons in a running window."""
    reset_window.views.show("lessons")
    found = reset_window.views.page("lessons")
    found.choose_folder("")
    yield found
    found.player.leave()
    found.player._saving.wait()
    found.choose_folder("")


@pytest.fixture
def small(page, home):
    """Return the page with an open lesson from the instructor's folder."""
    folder = home / "own"
    folder.mkdir()
    (folder / "small.md").write_text(SMALL, encoding="utf-8")
    page.choose_folder(str(folder))
    page.open("small")
    delete_deferred()  # the parts of the step that was open before
    return page


def move_until(window, qtbot, done):
    """Move the simulated hand 24 mm back and forth until ``done()``."""
    targets = itertools.cycle([0.012] * 20 + [-0.012] * 20)

    def moved():
        window.studio.move_hand(next(targets))
        return done()

    qtbot.waitUntil(moved)


@pytest.mark.slow
def test_every_lesson_has_a_row_that_opens_it(page, reset_window):
    assert list(page.rows) == list(library().lessons)
    assert page.isVisible()
    assert not reset_window.gallery.isVisible()
    page.rows[WALL].click()
    assert page.player.lesson.key == WALL
    assert page.place.text() == "Step 1 of 5"


@pytest.mark.slow
@pytest.mark.parametrize("key", wide(library().lessons, lambda key: key == WALL))
def test_each_step_of_each_lesson_shows_its_scene(page, reset_window, key):
    page.open(key)
    studio = reset_window.studio
    for at, step in enumerate(page.player.lesson.steps):
        page.player.go(at)
        assert not differing(studio, scene_settings(step.scene))
        assert set(page.tasks) == {task.key for task in (*step.checks, *step.questions)}


def test_the_buttons_below_the_last_step_are_not_cut_off(page, reset_window, qapp):
    resize(qapp, reset_window, (1280, 720))
    page.open(WALL)
    page.player.go(len(page.player.lesson.steps) - 1)
    qapp.processEvents()
    assert page.next.text() == "Finish"
    for button in (page.back, page.again, page.next, page.report, page.hand_in):
        assert button.width() >= button.sizeHint().width(), button.text()


def test_a_longer_result_is_complete_in_the_next_frame(page, reset_window, qapp, monkeypatch):
    page.open(WALL)
    resize(qapp, reset_window, (1280, 720))
    task, long = next(iter(page.tasks.values())), Result(WRONG, "The value is too high. Press again. " * 6)
    short = task.label.height()
    monkeypatch.setattr(Progress, "result", lambda self, block: long)
    page.show_results()
    assert task.label.height() > short
    for part in (task.title, task.label):
        assert part.height() >= part.heightForWidth(part.width())


@pytest.mark.slow
def test_every_formula_is_narrower_than_the_column(page, reset_window, qapp):
    page.open(WALL)
    resize(qapp, reset_window, (1280, 720))
    column = page.body
    room = column.column.contentsRect().width() - column.verticalScrollBar().sizeHint().width()
    formulas = {
        b.tex
        for one in library().lessons.values()
        for s in one.steps
        for b in s.blocks
        if isinstance(b, Formula)
    }
    assert len(formulas) > 15
    assert [tex for tex in formulas if formula_label(tex).sizeHint().width() > room] == []


@pytest.mark.slow
def test_formulas_are_pictures_and_html_in_a_lesson_is_text(small):
    texts = [part.text() for part in small.body.findChildren(QLabel)]
    assert sum(text.count("<img src=") for text in texts) == 2
    assert not [text for text in texts if "<code" in text or "<b>no" in text]


def test_html_in_a_steps_title_is_text_in_its_tooltip(qapp):
    title = '<b>Press</b> <img src="file:///a.png">'
    tip = StepDot(1, title).toolTip()
    assert "<img" not in tip
    assert QTextDocumentFragment.fromHtml(tip).toPlainText() == title


def test_locks_and_hidden_parts_of_a_step_end_with_it(small, reset_window):
    window, studio = reset_window, reset_window.studio
    with pytest.raises(ParameterError, match="locked by the lesson"):
        studio.set_value("stiffness", 100.0)
    with pytest.raises(ParameterError, match="locked by the lesson"):
        studio.set_loop(delay=0.01)
    studio.choose("wall")
    assert studio.environment.key == "spring"
    window.views.show("stability")
    assert window.views.key == "lessons"
    assert not window.panel.parameters.isVisible()
    assert window.stability.question() is None
    assert not [part for part in window.centre.phase.theory if part.isVisible()]
    small.go(1)
    studio.set_value("stiffness", 100.0)
    assert window.panel.parameters.isVisible()
    window.views.show("stability")
    assert window.views.key == "stability"
    assert small.isVisible()  # an open lesson stays visible beside every view


@pytest.mark.slow
def test_formulas_follow_the_theme(small):
    def pictures():
        return [text for part in small.body.findChildren(QLabel) if "<img" in (text := part.text())]

    delete_deferred()
    light = pictures()
    theme.set_mode("dark")
    assert len(pictures()) == len(light) == 2
    assert not set(pictures()) & set(light)


@pytest.mark.slow
def test_a_step_shows_the_plot_that_it_names(page, reset_window):
    """The friction lesson first shows force over velocity, the spring lesson force over position."""
    phase = reset_window.centre.phase
    for key, channel in (("friction", "velocity"), ("virtual_spring", "position")):
        page.open(key)
        assert phase.plots[phase.switch.index].channel == channel


@pytest.mark.slow
def test_leaving_a_lesson_restores_everything(page, reset_window):
    studio = reset_window.studio
    studio.set_value("stiffness", 420.0)
    studio.set_loop(delay=0.003, hand="firm")
    before = settings_of(studio)
    page.open(WALL)
    page.go(2)
    studio.set_value("stiffness", 1234.0)
    page.back_to_list.click()
    assert settings_of(studio) == before
    assert not studio.why_fixed("value", "wall", "damping")
    assert page.player.lesson is None
    reset_window.views.show("live")
    assert reset_window.gallery.isVisible()
    assert not page.isVisible()


@pytest.mark.slow
def test_answers_are_judged_in_a_sentence(small):
    choice, number = small.tasks["1.2"], small.tasks["1.3"]
    assert not choice.label.isVisible()
    choice.options[0].click()
    assert choice.label.text() == "Look again."
    choice.options[1].click()
    assert choice.label.text() == "Your answer is correct."
    QTest.keyClicks(number.field, "350")
    QTest.keyClick(number.field, Qt.Key.Key_Return)
    assert number.label.text() == "350 N/m is too high."
    assert not small.player.progress.step_done(0)
    number.field.setText("305")
    QTest.keyClick(number.field, Qt.Key.Key_Return)
    assert number.label.text() == "305 N/m is correct."


@pytest.mark.slow
def test_a_check_uses_live_data_and_marks_its_interval(small, reset_window, qtbot):
    """The task's text explains what is missing; the user does not have to press Record."""
    window, task = reset_window, small.tasks["1.1"]
    move_until(window, qtbot, lambda: "correct" in task.label.text())
    assert task.label.text().startswith("Distance moved: ")
    window.live.tick()
    window.centre.time.refresh()
    start, stop = window.centre.time.shown.evaluated
    assert start < stop <= 0.0
    small.player.save()
    small.player._saving.wait()
    assert file_of(small.player.lesson).exists()


@pytest.mark.slow
def test_answers_step_and_checks_are_restored_after_a_restart(small, reset_window, qtbot):
    window = reset_window
    small.tasks["1.2"].options[1].click()
    move_until(window, qtbot, lambda: "correct" in small.tasks["1.1"].label.text())
    small.go(1)
    QTest.keyClicks(small.tasks["2.4"].text, "Like a spring.")
    small.player.leave()
    small.player._saving.wait()
    small._show_list()
    assert small.rows["small"].state.text() == "3 of 4 done"
    small.rows["small"].click()
    assert small.place.text() == "Step 2 of 2"
    assert small.tasks["2.4"].text.toPlainText() == "Like a spring."
    small.go(-1)
    assert small.tasks["1.2"].options[1].isChecked()
    assert "correct" in small.tasks["1.1"].label.text()


@pytest.mark.slow
def test_an_invalid_lesson_shows_one_line_and_the_others_are_listed(page, home):
    (home / "wrong.md").write_text(SMALL.replace('measure = "travel"', 'measure = "taste"'), encoding="utf-8")
    (home / "right.md").write_text(SMALL, encoding="utf-8")
    page.choose_folder(str(home))
    assert "right" in page.rows
    assert "wrong" not in page.rows
    (line,) = page.library.errors
    assert line.startswith("wrong.md, line 25: measure must be one of")
    assert line in [part.text() for part in page.listed.findChildren(type(page.title))]


def test_a_missing_folder_gives_a_message_and_the_studios_lessons_are_listed(page, home):
    page.choose_folder(str(home / "gone"))
    assert page.message.text().startswith("There is no folder ")
    assert list(page.rows) == list(library().lessons)


@pytest.mark.slow
def test_a_folder_may_be_given_by_an_option(start_window, home):
    (home / "mine.md").write_text(SMALL, encoding="utf-8")
    window = start_window("--lessons", str(home))
    window.views.show("lessons")
    assert "mine" in window.views.page("lessons").rows


@pytest.mark.slow
def test_next_and_back_have_keys(small, reset_window):
    window = reset_window
    window.centre.scene.setFocus()
    alt = Qt.KeyboardModifier.AltModifier
    QTest.keyClick(window, Qt.Key.Key_Right, alt)
    assert small.place.text() == "Step 2 of 2"
    QTest.keyClick(window, Qt.Key.Key_Left, alt)
    assert small.place.text() == "Step 1 of 2"
    small.player.leave()
    assert not window.actions_by_key.qt["teach.lesson_next"].isEnabled()


@pytest.mark.slow
def test_tab_follows_the_order_of_a_step(small):
    wanted = [
        small.back_to_list, *small.dots, *small.tasks["1.2"].options, small.tasks["1.3"].field,
        small.again, small.next,
    ]  # fmt: skip
    stop, found = small.back_to_list, []
    for _ in range(60):
        if stop in wanted:
            found.append(stop)
        stop = stop.nextInFocusChain()
    assert found[: len(wanted)] == wanted


@pytest.mark.slow
def test_closing_the_window_in_a_lesson_stores_the_previous_settings(make_window, qtbot, home):
    from tests.gui.window_support import SIMULATED

    window = make_window()
    window.studio.device.open(SIMULATED)
    qtbot.waitUntil(lambda: window.studio.engine is not None)
    window.closed.connect(window.state.save)
    window.views.show("lessons")
    window.views.page("lessons").open("virtual_spring")
    assert window.studio.environment.key == "spring"
    window.close()
    assert window.settings.value("environment") == "wall"


def test_a_motor_waits_for_render_at_each_step_that_changes_settings(board_window, home):
    """The user has not chosen the step's settings, and perhaps does not hold the handle yet."""
    studio = board_window.studio
    if studio.stopped:
        studio.release_stop()
    board_window.views.show("lessons")
    page = board_window.views.page("lessons")
    page.open(WALL)
    assert studio.stopped
    assert studio.waits_for_render
    studio.release_stop()
    page.go(1)  # the next step has the same scene
    assert not studio.stopped
    page.go(1)  # another stiffness and delay
    assert studio.stopped
    studio.release_stop()
    page.player.leave()
    assert studio.stopped


@pytest.mark.slow
def test_opening_a_lesson_ends_a_demo_without_applying_its_settings(page, reset_window):
    window = reset_window
    before = settings_of(window.studio)
    window.play_demo(next(iter(shipped().values())))
    assert window.demos.demo is not None
    page.open(WALL)
    assert window.demos.demo is None
    page.player.leave()
    assert settings_of(window.studio) == before


@pytest.mark.slow
def test_the_report_is_opened_in_the_browser(small, reset_window, qtbot, monkeypatch):
    opened = []
    monkeypatch.setattr(QDesktopServices, "openUrl", lambda url: opened.append(url.toLocalFile()) or True)
    small.tasks["1.2"].options[1].click()
    qtbot.waitUntil(lambda: len(small.player._recent.rows().tables) > 0)
    small.report.click()
    (path,) = opened
    text = Path(path).read_text(encoding="utf-8")
    assert "<h1>Small</h1>" in text
    assert "<pre>right</pre>" in text
    assert not small.message.isVisible()


@pytest.mark.slow
def test_nothing_is_handed_in_without_a_name_or_samples(small, home):
    small._ask_file("")
    assert small.message.text() == "Nothing was handed in. Enter your name first."
    small.player._recent.follow(None)
    small.save_handed_in(str(home / "x.hapkit"))
    assert small.message.text().startswith("Nothing was handed in. There is nothing to save yet")
    assert not (home / "x.hapkit").exists()


def test_a_damaged_progress_file_is_renamed_and_the_lesson_starts_from_the_beginning(page, home):
    path = file_of(library().lessons[WALL])
    path.parent.mkdir(parents=True)
    path.write_bytes(b"no session")
    page.rows[WALL].click()
    assert page.place.text() == "Step 1 of 5"
    assert path.with_suffix(".damaged").read_bytes() == b"no session"


@pytest.mark.slow
def test_a_hint_opens_and_closes(small, qtbot):
    (hint,) = small.body.findChildren(HintPart)[-1:]
    assert not hint.label.isVisibleTo(hint)
    hint.button.click()
    assert hint.label.isVisibleTo(hint)
    hint.button.click()
    assert not hint.label.isVisibleTo(hint)


@pytest.mark.slow
def test_a_session_recorded_during_a_lesson_is_remembered_for_handing_in(small, reset_window, home):
    recording = reset_window.studio.recording
    recording.newest = (home / "trials.hapkit", 1)
    recording.changed.emit()
    assert small.player._recordings() == {"small": [str(home / "trials.hapkit")]}
    small.player.leave()
    recording.newest = (home / "later.hapkit", 1)
    recording.changed.emit()
    assert small.player._recordings() == {"small": [str(home / "trials.hapkit")]}


@pytest.mark.slow
def test_what_was_set_in_a_lesson_cannot_be_undone_after_it(page, reset_window):
    studio, undo = reset_window.studio, reset_window.actions_by_key.qt["edit.undo"]
    page.open(WALL)
    assert not undo.isEnabled()
    studio.set_value("stiffness", 777.0)
    assert undo.isEnabled()
    page.player.leave()
    assert not undo.isEnabled()
