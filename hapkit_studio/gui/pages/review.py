"""The dialog of a peer review: the reviewer's points and comments, and all reviews with their replies."""

import math
import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt, QUrl
from PySide6.QtGui import QDesktopServices
from PySide6.QtWidgets import (
    QComboBox,
    QGridLayout,
    QLineEdit,
    QPushButton,
    QSpinBox,
    QStackedWidget,
    QWidget,
)

from hapkit_studio.formatting import number
from hapkit_studio.gui.state.background import Job, end_all
from hapkit_studio.gui.widgets.dialogs import TextDialog
from hapkit_studio.gui.widgets.parts import AnswerLine, ScrollColumn, hbox, label, primary, refill, rule, vbox
from hapkit_studio.gui.widgets.segmented import Segmented
from hapkit_studio.lessons import review
from hapkit_studio.lessons.hand_in import HandedIn
from hapkit_studio.lessons.lesson import Lesson
from hapkit_studio.lessons.review import LONGEST, Comment, Review, ReviewError

if TYPE_CHECKING:
    from PySide6.QtGui import QCloseEvent

    from hapkit_studio.gui.live.replay import Replay

_SIZE = (640, 470)  # px: size of the dialog
_NONE = -1  # value of a points field that is still empty
_PARTS = "My review", "All reviews"


class ReviewDialog(TextDialog):
    """A dialog to review a handed-in file; it does not change that file.

    A comment gets the current time of ``replay``. The reviewers' names are hidden if the lesson requires
    this.
    """

    def __init__(
        self,
        handed: HandedIn,
        lesson: Lesson,
        reviewer: str,
        replay: "Replay | None",
        show_replay: Callable[[Path], object],
        parent: QWidget,
    ):
        who = "" if lesson.hide_names else f", {handed.student}"
        super().__init__(f"Review: {lesson.title}{who}", parent)
        self._handed, self._lesson, self._replay = handed, lesson, replay
        self._path: Path | None = None
        self.comments: list[Comment] = []
        self._job = Job(self, needs="")
        self._job.finished.connect(self._open)
        self._job.failed.connect(self._warn)
        self.report, self.watch = QPushButton("Open the report"), QPushButton("Show the replay")
        self.parts = Segmented("Reviews shown", _PARTS)
        self.name = QLineEdit(reviewer, maxLength=100, placeholderText="Your name")
        self.points = [QSpinBox(minimum=_NONE, maximum=one.points) for one in lesson.rubric]
        self.remarks = [QLineEdit(maxLength=LONGEST, placeholderText="Comment") for _ in lesson.rubric]
        self.place, self.text = QComboBox(), QLineEdit(maxLength=LONGEST, placeholderText="Comment")
        self.add, self.save = QPushButton("Add comment"), primary(QPushButton("Save review"))
        self.written, self.all = QWidget(), label()
        self.to, self.answer_text = QComboBox(), QLineEdit(maxLength=LONGEST, placeholderText="Reply")
        self.reply, self.answer = QPushButton("Reply"), AnswerLine()
        self._arrange()
        self.parts.chosen.connect(self._show_part)
        self.parts.show_index(0)
        self.report.clicked.connect(self._write_report)
        self.watch.clicked.connect(lambda: show_replay(handed.path))
        self.add.clicked.connect(self._add)
        self.text.returnPressed.connect(self._add)
        self.save.clicked.connect(self._save)
        self.reply.clicked.connect(self._reply)
        self.answer_text.returnPressed.connect(self._reply)
        if replay is not None:
            replay.moved.connect(self._show_time)
            replay.changed.connect(self._show_time)
        self._load()

    def _show_part(self, index: int) -> None:
        self._stack.setCurrentIndex(index)
        self.save.setVisible(index == 0)

    # my review

    @property
    def review(self) -> Review:
        """Return the entered review; raise ReviewError if it is invalid."""
        blank = review.blank(self._handed, self._lesson, self.name.text())
        rows = tuple(
            replace(row, points=None if box.value() == _NONE else box.value(), comment=self._line(line))
            for row, box, line in zip(blank.rows, self.points, self.remarks, strict=True)
        )
        # read the file again, because replies may have been added to it
        replies = () if self._path is None else review.read(self._path).replies
        return replace(blank, rows=rows, comments=tuple(self.comments), replies=replies)

    @staticmethod
    def _line(field: QLineEdit) -> str:
        return " ".join(field.text().split())

    def _add(self) -> None:
        text = self._line(self.text)
        if not text:
            return
        kind, value = self.place.currentData()
        if kind == "time":
            value = round(self._replay.time, 3) if self._replay is not None else 0.0
        self.comments.append(Comment(text, **({kind: value} if kind else {})))
        self.text.clear()
        self._show_comments()

    def _remove(self, comment: Comment) -> None:
        self.comments.remove(comment)
        self._show_comments()

    def _show_comments(self) -> None:
        rows = []
        for one in self.comments:
            row, drop = QWidget(), QPushButton("Remove")
            drop.setAccessibleName(f"Remove the comment: {one.text}")
            drop.clicked.connect(lambda _on=False, one=one: self._remove(one))
            hbox((label(f"{one.place}: {one.text}".removeprefix(": ")), 1), drop, into=row)
            rows.append(row)
        refill(self._listed, rows)

    def _save(self) -> None:
        """Write the review to its file; it may replace an older review by the same reviewer."""
        try:
            mine = self.review
            path = self._path or review.path_of(self._handed.path, mine.reviewer)
            review.write(path, mine, replace_file=path == self._path)
        except ReviewError as error:
            self._warn(str(error))
            return
        self._path = path
        missing = "" if mine.complete else " Some criteria have no points yet."
        self.answer.show_text(f"The review was saved as {path.name}.{missing}", "check", "ok")
        self._show_all()

    # all reviews

    def _load(self) -> None:
        """Show all reviews, and fill the fields with the reviewer's own review."""
        self._show_all()
        self._show_time()
        name = self.name.text().strip()
        for path, one in [found for found in self._reviews.found.items() if found[1].reviewer == name][:1]:
            self._path, self.comments = path, list(one.comments)
            given = {(row.criterion, row.most): row for row in one.rows}
            for rubric, box, line in zip(self._lesson.rubric, self.points, self.remarks, strict=True):
                row = given.get((rubric.text, rubric.points))
                if row is not None:
                    box.setValue(_NONE if row.points is None else row.points)
                    line.setText(row.comment)
        self._show_comments()

    def _show_all(self) -> None:
        self._reviews = review.reviews_of(self._handed)
        shown = review.hidden_names(self._reviews) if self._lesson.hide_names else self._reviews
        found = list(shown.found.values())
        blocks = ["\n".join(review.lines(one)) for one in found]
        mean = ""
        if math.isfinite(shown.mean):
            mean = f"Mean of the complete reviews: {number(100.0 * shown.mean, 0)} % of the points."
        nothing = "" if found else "There is no review in the folder of this file yet."
        self.all.setText("\n\n".join(filter(None, (mean, *blocks, nothing, *shown.errors))))
        self.to.clear()
        for path, one in shown.found.items():
            self.to.addItem(f"Reply to {one.reviewer}", path)
        for part in (self.to, self.answer_text, self.reply):
            part.setEnabled(bool(found))

    def _reply(self) -> None:
        path = self.to.currentData()
        if path is None or not self._line(self.answer_text):
            return
        try:
            review.reply(path, self.answer_text.text())
        except ReviewError as error:
            self._warn(str(error))
            return
        self.answer_text.clear()
        self.answer.show_text(
            "The reply was saved in the file of the review. Send this file to the reviewer.", "check", "ok"
        )
        self._show_all()

    def _warn(self, why: str) -> None:
        self.answer.show_text(why, "triangle", "warn")

    # report and replay

    def _write_report(self) -> None:
        handed, lesson, found = self._handed, self._lesson, self._reviews
        self.answer.show_text("Writing the report…")

        def write(_progress: object) -> Path:
            from hapkit_studio.lessons.report import report  # imported late, because it imports matplotlib

            path = Path(tempfile.mkdtemp(prefix="hapkit-")) / f"{lesson.key}.html"
            path.write_text(report(handed, lesson, found), encoding="utf-8")
            return path

        self._job.start(write)

    def _open(self, path: Path) -> None:
        shown = QDesktopServices.openUrl(QUrl.fromLocalFile(str(path)))
        self.answer.show_text(
            "The report is open in the browser." if shown else f"The report was saved as {path}."
        )

    def _show_time(self) -> None:
        """While this file is being replayed, offer the replay's current time as the time of a comment."""
        replay, chosen = self._replay, self.place.currentIndex()
        shown = replay is not None and replay.history is not None
        shown = shown and replay.history.session.path == self._handed.path  # type: ignore[union-attr]
        places: list[tuple[str, tuple[str, object]]] = [("The whole work", ("", None))]
        if shown and replay is not None:
            places.append((f"At {number(replay.time, 2)} s of the recording", ("time", None)))
        places += [(f"Step {at}: {s.title}", ("step", at)) for at, s in enumerate(self._lesson.steps, 1)]
        if self.place.count() == len(places):
            for at, (text, _) in enumerate(places):
                self.place.setItemText(at, text)
            return
        self.place.clear()
        for text, data in places:
            self.place.addItem(text, data)
        self.place.setCurrentIndex(1 if shown else max(min(chosen, 0), 0))

    def closeEvent(self, event: "QCloseEvent") -> None:
        end_all(self)
        super().closeEvent(event)

    def _arrange(self) -> None:
        self._stack = QStackedWidget()
        mine, both = ScrollColumn(top=4), ScrollColumn(top=4)
        grid = QGridLayout()
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setColumnStretch(0, 1)
        grid.setColumnStretch(2, 1)
        fields = zip(self._lesson.rubric, self.points, self.remarks, strict=True)
        for row, (one, box, line) in enumerate(fields):
            box.setSpecialValueText("–")
            box.setValue(_NONE)
            box.setAlignment(Qt.AlignmentFlag.AlignRight)
            box.setSuffix(f" of {one.points}")
            box.setAccessibleName(f"Points: {one.text}")
            line.setAccessibleName(f"Comment: {one.text}")
            grid.addWidget(label(one.text), row, 0)
            grid.addWidget(box, row, 1)
            grid.addWidget(line, row, 2)
        self.name.setAccessibleName("Your name")
        self.place.setAccessibleName("What the comment is about")
        self.text.setAccessibleName("Comment")
        self.to.setAccessibleName("Review to reply to")
        self.answer_text.setAccessibleName("Reply")
        self._listed = vbox(into=self.written, gap=6)
        rubric, adding, replying, named = QWidget(), QWidget(), QWidget(), QWidget()
        rubric.setLayout(grid)
        hbox(label("Your name", "axis", wrap=False), (self.name, 1), into=named)
        hbox(self.place, (self.text, 1), self.add, into=adding)
        hbox(self.to, (self.answer_text, 1), self.reply, into=replying)
        mine.add(named, rubric, rule(), self.written, adding)
        self.all.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        both.add(self.all, rule(), replying)
        for part in (mine, both):
            self._stack.addWidget(part)
        self._stack.setMinimumSize(*_SIZE)
        self.column.addLayout(hbox(self.parts, None, self.watch, self.report))
        self.column.addWidget(self._stack, 1)
        self.column.addWidget(self.answer)
        self.column.addLayout(hbox(None, self.save, self.leave))
