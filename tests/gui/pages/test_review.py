"""The review dialog: points, comments on a step and a time, replies; the data are unchanged."""

import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QDesktopServices
from PySide6.QtTest import QTest

from hapkit_studio.gui.live.replay import Replay
from hapkit_studio.gui.pages.review import ReviewDialog
from hapkit_studio.lessons import library, review
from hapkit_studio.lessons.hand_in import save_played
from hapkit_studio.lessons.play import play_lesson
from hapkit_studio.sessions.folder import folder
from tests.gui.window_support import sheet_of
from tests.sessions.test_overview import motion, write

KEY = "virtual_spring"


@pytest.fixture(scope="module")
def handed_in(tmp_path_factory):
    path, lesson = tmp_path_factory.mktemp("handed") / "ada.hapkit", library().lessons[KEY]
    save_played(path, lesson, play_lesson(lesson), "Ada L")
    return path.read_bytes()


@pytest.fixture
def page(reset_idle_window, qtbot, home, handed_in):
    """Return the sessions page with a handed-in session, which is selected, and another recording."""
    folder().mkdir(exist_ok=True)
    (folder() / "ada.hapkit").write_bytes(handed_in)
    write(folder() / "plain.hapkit", motion(0.5))
    window = reset_idle_window
    shown = window.views.page("sessions")
    window.views.show("sessions")
    choose(shown, qtbot, "ada")
    yield shown
    for dialog in window.findChildren(ReviewDialog):
        dialog.close()


def choose(page, qtbot, name):
    page._wanted = folder() / f"{name}.hapkit"
    page.load()
    qtbot.waitUntil(lambda: not page._reading.running)
    assert page.chosen.name == name


@pytest.fixture
def dialog(page, qtbot):
    """Return the dialog for the handed-in file, opened by its button."""
    QTest.mouseClick(page.review, Qt.MouseButton.LeftButton)
    qtbot.waitUntil(lambda: not page._opening.running)
    return sheet_of(page.window(), ReviewDialog)


def written(name="Bob"):
    return review.read(review.path_of(folder() / "ada.hapkit", name))


def typed(field, text):
    field.setFocus()
    field.selectAll()
    QTest.keyClicks(field, text)


@pytest.mark.slow
def test_points_and_comments_are_entered_by_keyboard_and_the_data_are_unchanged(dialog, handed_in):
    typed(dialog.name, "Bob")
    dialog.points[0].setFocus()
    for _ in range(3):
        QTest.keyClick(dialog.points[0], Qt.Key.Key_Up)  # the keys select 0, 1 and 2 points instead of none
    typed(dialog.remarks[0], "Good slope")
    dialog.place.setFocus()
    QTest.keyClick(dialog.place, Qt.Key.Key_Down)
    typed(dialog.text, "Why?")
    QTest.keyClick(dialog.text, Qt.Key.Key_Return)
    QTest.keyClick(dialog.save, Qt.Key.Key_Return)
    found = written()
    assert [row.points for row in found.rows] == [2, None, None]
    assert found.rows[0].comment == "Good slope"
    assert found.comments == (review.Comment("Why?", step=1),)
    assert "Some criteria have no points yet" in dialog.answer.label.text()
    assert (folder() / "ada.hapkit").read_bytes() == handed_in


def test_changing_a_saved_review_keeps_a_new_reply(dialog):
    typed(dialog.name, "Bob")
    dialog.save.click()
    review.reply(review.path_of(folder() / "ada.hapkit", "Bob"), "Thank you")
    dialog.points[1].setValue(1)
    dialog.save.click()
    found = written()
    assert found.rows[1].points == 1
    assert found.replies == ("Thank you",)


def test_a_review_without_a_name_is_not_saved(dialog):
    typed(dialog.name, " ")
    dialog.save.click()
    assert "needs the reviewer's name" in dialog.answer.label.text()
    assert not list(folder().glob("*.review"))


@pytest.mark.slow
def test_a_comment_can_have_the_replays_time(dialog, qtbot):
    window = dialog.parent()
    QTest.mouseClick(dialog.watch, Qt.MouseButton.LeftButton)
    replay = window.findChild(Replay)
    try:
        qtbot.waitUntil(lambda: replay.history is not None)
        replay.seek(3.2)
        assert dialog.place.currentText() == "At 3.20 s of the recording"
        typed(dialog.text, "Here")
        dialog.add.click()
        assert dialog.comments == [review.Comment("Here", time=3.2)]
    finally:
        replay.close()
    assert dialog.place.findData(("time", None)) < 0


@pytest.mark.slow
def test_all_reviews_are_shown_and_answered(page, qtbot):
    path = folder() / "ada.hapkit"
    from hapkit_studio.lessons.hand_in import read

    for name in ("Bob", "Eve"):
        one = review.blank(read(path), library().lessons[KEY], name)
        review.write(review.path_of(path, name), one)
    (folder() / "broken.review").write_text("{")
    page.ask_review()
    qtbot.waitUntil(lambda: not page._opening.running)
    dialog = sheet_of(page.window(), ReviewDialog)
    QTest.mouseClick(dialog.parts.button(1), Qt.MouseButton.LeftButton)
    shown = dialog.all.text()
    for text in ("Bob on ada.hapkit", "Eve on ada.hapkit", "broken.review"):
        assert text in shown
    assert not dialog.save.isVisible()
    dialog.to.setCurrentIndex(dialog.to.findText("Reply to Eve"))
    typed(dialog.answer_text, "Thank you")
    QTest.keyClick(dialog.answer_text, Qt.Key.Key_Return)
    assert written("Eve").replies == ("Thank you",)
    assert written("Bob").replies == ()


@pytest.mark.slow
def test_a_recording_that_was_not_handed_in_says_so(page, qtbot):
    choose(page, qtbot, "plain")
    page.ask_review()
    qtbot.waitUntil(lambda: not page._opening.running)
    assert "not a file that was handed in" in page.status.text()


@pytest.mark.slow
def test_the_report_is_written_and_opened(dialog, qtbot, monkeypatch):
    opened = []
    monkeypatch.setattr(QDesktopServices, "openUrl", lambda url: opened.append(url.toLocalFile()) or True)
    monkeypatch.setattr("hapkit_studio.lessons.report.report", lambda handed, *_: f"<p>{handed.student}</p>")
    dialog.report.click()
    qtbot.waitUntil(lambda: bool(opened))
    with open(opened[0], encoding="utf-8") as file:
        assert file.read() == "<p>Ada L</p>"
