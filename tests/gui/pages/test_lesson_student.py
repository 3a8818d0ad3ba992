"""A scripted student completes a lesson in the real window with mouse and keyboard events only."""

import itertools
import math
import time

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QDialogButtonBox, QFileDialog, QLineEdit

from hapkit_studio.gui.widgets.dialogs import WordsDialog
from hapkit_studio.lessons import library
from hapkit_studio.lessons.grade import grade_file
from hapkit_studio.lessons.hand_in import read
from tests.gui.window_support import PATIENCE_MS, sheet_of

LEFT, ALT, CONTROL = (
    Qt.MouseButton.LeftButton,
    Qt.KeyboardModifier.AltModifier,
    Qt.KeyboardModifier.ControlModifier,
)
KEY = "virtual_spring"


class Student:
    """Acts on a window as the user does: clicks, drags, types."""

    def __init__(self, window, qtbot):
        self.window, self.qtbot, self.scene = window, qtbot, window.centre.scene

    @property
    def page(self):
        return self.window.views.page("lessons")

    def click(self, part):
        """Click in the middle of a visible part."""
        self.qtbot.waitUntil(part.isVisible)  # a new step is laid out by the next events
        self.page.body.ensureWidgetVisible(part)
        QTest.mouseClick(part, LEFT, pos=part.rect().center())

    def type_into(self, field, text):
        """Click into a field, replace its text, and press Enter."""
        self.click(field)
        QTest.keyClick(field, Qt.Key.Key_A, CONTROL)
        QTest.keyClicks(field, text)
        QTest.keyClick(field, Qt.Key.Key_Return)

    def place(self, mm):
        """Return the scene's pixel whose target is nearest to a position in mm."""
        columns = range(self.scene.width())
        x = min(columns, key=lambda x: abs(self.scene.target_at(float(x)) - 1e-3 * mm))
        return QPoint(x, self.scene.height() // 3)

    def drag(self, path, until):
        """Drag the handle repeatedly along points (s, mm) until a condition holds, without releasing it."""
        times, places = zip(*path, strict=True)
        QTest.mousePress(self.scene, LEFT, pos=self.place(places[0]))
        start = time.monotonic()

        def moved():
            at = (time.monotonic() - start) % times[-1]
            QTest.mouseMove(self.scene, self.place(np.interp(at, times, places)))
            return until()

        self.qtbot.waitUntil(moved)

    def let_go(self):
        QTest.mouseRelease(self.scene, LEFT, pos=self.place(0))

    def correct(self, key):
        return lambda: self.page.player.progress.result(task_of(key)).state == "correct"


def task_of(key):
    return next(task for _, _, task in library().lessons[KEY].tasks() if task.key == key)


@pytest.mark.slow
def test_a_student_completes_a_lesson_and_hands_it_in(window, qtbot, home):
    student, studio = Student(window, qtbot), window.studio
    window.live.start()
    QTest.keyClick(window, Qt.Key.Key_L, CONTROL)
    page = student.page
    page.listed.ensureWidgetVisible(page.rows[KEY])
    QTest.mouseClick(page.rows[KEY], LEFT)
    assert page.place.text() == "Step 1 of 3"
    assert studio.environment.key == "spring"

    swing = [(0.0, 0), (0.5, 18), (1.5, -18), (2.5, 18), (3.0, 0)]
    student.drag(swing, student.correct("1.1"))
    student.let_go()
    assert page.tasks["1.1"].label.text().startswith("Stiffness: ")

    QTest.keyClick(window, Qt.Key.Key_Right, ALT)
    assert page.place.text() == "Step 2 of 3"
    box = window.panel.parameters.rows["stiffness"].box
    QTest.mouseClick(box.lineEdit(), LEFT)
    QTest.keyClick(box.lineEdit(), Qt.Key.Key_A, CONTROL)
    QTest.keyClicks(box.lineEdit(), "120")
    QTest.keyClick(box.lineEdit(), Qt.Key.Key_Return)
    assert studio.values["stiffness"] == 120.0
    student.drag([(t, 0.8 * mm) for t, mm in swing], student.correct("2.2"))
    student.let_go()
    energy = page.tasks["2.3"]
    student.type_into(energy.field, "12")
    assert energy.label.text() == f"12 mJ is too high. {task_of('2.3').wrong}"
    student.type_into(energy.field, f"{1e3 * 0.5 * 120 * 0.010**2:g}")
    assert energy.label.text() == "6 mJ is correct."

    student.click(page.next)
    assert page.place.text() == "Step 3 of 3"
    student.type_into(page.tasks["3.4"].field, f"{math.sqrt(80.0 / 0.044) / (2 * math.pi):.2f}")
    rests = student.correct("3.5")
    for _ in range(5):
        arrived = iter(itertools.count())
        student.drag([(0.0, 0), (0.8, 20), (60.0, 20)], lambda arrived=arrived: next(arrived) > 120)
        student.let_go()
        deadline = time.monotonic() + 8.0
        qtbot.waitUntil(lambda deadline=deadline: rests() or time.monotonic() > deadline)
        if rests():
            break
    assert rests(), page.tasks["3.5"].label.text()
    options = page.tasks["3.6"].options
    student.click(options[2])
    assert page.tasks["3.6"].label.text() == task_of("3.6").wrong
    for _ in range(2):  # select the first option with the keyboard
        QTest.keyClick(window.focusWidget(), Qt.Key.Key_Up)
    assert options[0].isChecked()
    assert page.player.progress.counts == (6, 6)

    student.click(page.hand_in)
    name = sheet_of(window, WordsDialog)
    QTest.keyClicks(name.text, "Ada L")
    QTest.keyClick(name.text, Qt.Key.Key_Return)
    dialog = window.findChild(QFileDialog)
    assert QTest.qWaitForWindowActive(dialog, PATIENCE_MS)
    path = home / "ada.hapkit"
    field = dialog.findChild(QLineEdit)
    field.setCompleter(None)  # the completer's list would receive the next click
    QTest.keyClick(field, Qt.Key.Key_A, CONTROL)
    QTest.keyClicks(field, str(path))
    save = dialog.findChild(QDialogButtonBox).button(QDialogButtonBox.StandardButton.Save)
    for _ in range(2):  # without a screen, the first click on Qt's dialog only ends the text entry
        if dialog.isVisible():
            QTest.mouseClick(save, LEFT)
    assert page.message.text().startswith("Saved as ada.hapkit, with 6 of 6 tasks done.")
    assert read(path).student == "Ada L"
    lesson = library().lessons[KEY]
    assert {row.state for row in grade_file(path, {KEY: lesson})} == {"correct"}

    student.click(page.next)  # the button is now labelled Finish
    assert page.rows[KEY].state.text() == "6 of 6 done"
    assert studio.environment.key == "wall"
