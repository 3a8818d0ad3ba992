"""The column that replaces the gallery.

It shows the list of lessons with the user's progress, or the open step.
"""

from functools import partial
from itertools import pairwise
from pathlib import Path

from PySide6.QtCore import QPoint, QRect, QSize, Qt, QUrl
from PySide6.QtGui import QDesktopServices, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QLayout, QPushButton, QScrollArea, QStackedWidget, QWidget

from hapkit_studio.errors import ParameterError, StudioError
from hapkit_studio.formatting import number
from hapkit_studio.gui.live.live import Live
from hapkit_studio.gui.pages.base import Page
from hapkit_studio.gui.pages.lessons.player import LessonPlayer
from hapkit_studio.gui.pages.lessons.tasks import CheckTask, HintPart, QuestionTask, Task, plot_part
from hapkit_studio.gui.pages.lessons.text import formula_label, text_label
from hapkit_studio.gui.state.stored import LESSONS_FOLDER, StoredSettings
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.gui.widgets import icons
from hapkit_studio.gui.widgets.dialogs import WordsDialog
from hapkit_studio.gui.widgets.parts import choose_file, hbox, hint, label, lay_out, primary, rule, vbox
from hapkit_studio.gui.widgets.style import mark
from hapkit_studio.gui.widgets.text import plain_tip
from hapkit_studio.gui.widgets.theme import theme
from hapkit_studio.lessons.lesson import Block, Check, Formula, Hint, Lesson, Plot, Question, Text
from hapkit_studio.lessons.library import Library, library
from hapkit_studio.lessons.progress import Progress, file_of

STUDENT = "lessons_student"
"""Key of the setting that stores the student's name."""
_SIDE = 14
_DOT, _LONGEST_NAME = 24, 60


class LessonColumn(QScrollArea):
    """A scrolling column of widgets."""

    def __init__(self, gap: int = 10) -> None:
        super().__init__()
        self.setWidgetResizable(True)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        body = QWidget(self.viewport())
        body.setObjectName("panelBody")
        self.column = vbox(into=body, margins=(_SIDE, 4, _SIDE, 12), gap=gap)
        self.setWidget(body)

    def show_parts(self, parts: list[QWidget]) -> None:
        """Replace all widgets and scroll to the top."""
        while item := self.column.takeAt(0):
            if old := item.widget():
                old.hide()
                old.deleteLater()
        for part in parts:
            self.column.addWidget(part)
        self.column.addStretch(1)
        self.verticalScrollBar().setValue(0)


class LessonRow(QPushButton):
    """A lesson in the list, with its title, its aim and the user's progress."""

    def __init__(self, lesson: Lesson, progress: Progress):
        super().__init__(autoDefault=True)
        self.setProperty("row", True)
        done, count = progress.counts
        state = f"{done} of {count} done" if progress.begun else f"{number(lesson.minutes, 0)} min"
        self.state = label(state, "hint", wrap=False)
        mark(self.state, "ink", "ok" if done == count else "accent" if progress.begun else "ink3")
        head = hbox((label(lesson.title, "strong"), 1), self.state)
        vbox(head, hint(lesson.aim), into=self, margins=(10, 7, 10, 8), gap=2)
        for part in self.findChildren(QWidget):
            part.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.setAccessibleName(f"{lesson.title}: {lesson.aim} {state}")

    def hasHeightForWidth(self) -> bool:
        return True

    def heightForWidth(self, width: int) -> int:
        return self._row.heightForWidth(width)

    @property
    def _row(self) -> QLayout:
        row = self.layout()
        assert row is not None
        return row


class StepDot(QPushButton):
    """A round button with a step's number.

    It is filled while the step is open and shows a tick once it is done.
    """

    def __init__(self, number: int, title: str):
        super().__init__(autoDefault=True)
        self.number, self.done, self.current = number, False, False
        self.setToolTip(plain_tip(title))
        self._title = title
        theme.changed.connect(self._fit)
        self._fit()

    def sizeHint(self) -> QSize:
        return QSize(1, 1) * theme.px(_DOT)

    def _fit(self) -> None:
        self.setFixedSize(self.sizeHint())

    def show_state(self, done: bool, current: bool) -> None:
        """Show whether the step is done and whether it is open."""
        self.done, self.current = done, current
        text = ", done" if done else ""
        self.setAccessibleName(f"Step {self.number}{text}: {self._title}")
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        wide = min(self.width(), self.height()) - 4
        ring = QRect(0, 0, wide, wide)
        ring.moveCenter(self.rect().center())
        fill = "accent" if self.current else "accentsoft" if self.done else "side"
        painter.setBrush(theme.color(fill))
        edge = "accent" if self.current or self.done else "edge"
        painter.setPen(QPen(theme.color("ink" if self.hasFocus() else edge), 2.5 if self.hasFocus() else 1.5))
        painter.drawEllipse(ring)
        token = "onaccent" if self.current else "accent" if self.done else "ink2"
        if self.done and not self.current:
            side = theme.px(14)
            place = QPoint((self.width() - side) // 2, (self.height() - side) // 2)
            painter.drawPixmap(place, icons.pixmap("check", side, token, self.devicePixelRatioF()))
            return
        painter.setFont(theme.font("label"))
        painter.setPen(theme.color(token))
        painter.drawText(self.rect(), Qt.AlignmentFlag.AlignCenter, str(self.number))


class LessonsPage(Page):
    """Shows the list of lessons, or the open step of a lesson; a LessonPlayer controls the lesson."""

    beside = True

    def __init__(self, studio: Studio, live: Live):
        super().__init__()
        self.setObjectName("panelBody")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self._studio = studio
        self._settings = StoredSettings()
        self.library = Library({})
        self.player = LessonPlayer(studio, live, self)
        self.player.student = str(self._settings.value(STUDENT, ""))
        self.tasks: dict[str, Task] = {}
        self.rows: dict[str, LessonRow] = {}
        self.dots: list[StepDot] = []
        self.stack = QStackedWidget()
        self.message = hint()
        mark(self.message, "ink", "warn")
        self.message.setContentsMargins(_SIDE, 6, _SIDE, 6)
        self.message.hide()
        self.column.addWidget(self.message)
        self.column.addWidget(self.stack, 1)
        self.stack.addWidget(self._list_part())
        self.stack.addWidget(self._step_part())
        player = self.player
        player.opened.connect(self._show_opened)
        player.step_changed.connect(self.show_step)
        player.evaluated.connect(self.show_results)
        player.applied.connect(self._show_view)
        player.failed.connect(lambda what, why: self.show_text(f"{what} {why}"))
        self.load()

    # methods that the window calls

    def set_shown(self, on: bool) -> None:
        if on and self.player.lesson is None:
            self.load()

    def end(self) -> None:
        self.player.end()
        super().end()

    def show_text(self, text: str) -> None:
        """Show a message above the lesson; "" removes it."""
        self.message.setText(text)
        self.message.setVisible(bool(text))

    def load(self) -> None:
        """Read all lessons again."""
        folder = str(self._settings.value(LESSONS_FOLDER, "")) or None
        try:
            self.library = library(folder, self._studio.environments)
        except ParameterError as error:
            self.library = library(known=self._studio.environments)
            self.show_text(str(error))
        self._show_list()

    def open(self, key: str) -> None:
        """Open a lesson by its key; raise ParameterError for an unknown key."""
        self.show_text("")
        self.player.open(self.library.named(key))

    def go(self, steps: int) -> None:
        """Go forward by a number of steps, or back if negative; after the last step, show the list."""
        progress = self.player.progress
        if progress is None:
            return
        step = progress.step + steps
        if step >= len(progress.lesson.steps):
            self.player.leave()
        else:
            self.player.go(step)

    # the list

    def _list_part(self) -> QWidget:
        part = QWidget()
        self.listed = LessonColumn(gap=6)
        self.folder = QPushButton("Choose a folder…", autoDefault=True)
        self.folder.setToolTip("Show lessons of your own, from a folder")
        self.folder.clicked.connect(self.ask_folder)
        self.usual = QPushButton("Remove this folder", autoDefault=True)
        self.usual.setToolTip("Do not show the lessons of this folder any more")
        self.usual.clicked.connect(lambda: self.choose_folder(""))
        self.own = hint()
        foot = vbox(self.own, hbox(self.folder, self.usual, None), margins=(_SIDE, 10, _SIDE, 12), gap=6)
        head = label("Lessons", "title", wrap=False)
        head.setContentsMargins(_SIDE, 12, _SIDE, 6)
        vbox(head, (self.listed, 1), rule(), foot, into=part)
        return part

    def _show_list(self) -> None:
        self.rows = {
            key: LessonRow(lesson, self.player.progress_of(lesson))
            for key, lesson in self.library.lessons.items()
        }
        for key, row in self.rows.items():
            row.clicked.connect(partial(self.open, key))
        errors = [label(text, "error") for text in self.library.errors]
        self.listed.show_parts([*errors, *self.rows.values()])
        folder = str(self._settings.value(LESSONS_FOLDER, ""))
        self.own.setText(f"Your folder of lessons: {Path(folder).name}" if folder else "Lessons of your own:")
        self.own.setToolTip(plain_tip(folder))
        self.usual.setVisible(bool(folder))
        self._order([*self.rows.values(), self.folder, self.usual])

    def ask_folder(self) -> None:
        """Ask for the folder with an instructor's lessons."""
        choose_file(self, "Choose a folder with lessons", "", self.choose_folder, folder=True)

    def choose_folder(self, folder: str) -> None:
        """Also show the lessons of a folder; "" means no folder."""
        self.show_text("")
        self._settings.setValue(LESSONS_FOLDER, folder)
        self.load()

    # the open step

    def _step_part(self) -> QWidget:
        part = QWidget()
        self.back_to_list = QPushButton("All lessons", autoDefault=True)
        self.back_to_list.setProperty("link", True)
        self.back_to_list.setToolTip(
            "Leave the lesson; your progress is saved and your settings are restored"
        )
        icons.bind(self.back_to_list, "chevron_left", "accent", 16)
        self.back_to_list.clicked.connect(lambda: self.player.leave())
        self.place, self.title = label(role="hint", wrap=False), label(role="title")
        self.dot_row = hbox(gap=6)
        self.body = LessonColumn()
        self.back, self.next = (QPushButton(text, autoDefault=True) for text in ("Back", "Next"))
        icons.bind(self.back, "chevron_left", "ink", 16)
        self.back.setToolTip("Go to the previous step (Alt+Left)")
        self.back.clicked.connect(lambda: self.go(-1))
        self.next.setLayoutDirection(Qt.LayoutDirection.RightToLeft)
        icons.bind(self.next, "chevron_right", "onaccent", 16)
        self.next.clicked.connect(lambda: self.go(1))
        self.again = QPushButton("Reset step", autoDefault=True)
        self.again.setToolTip("Set the scene and values as they were at the start of this step")
        self.again.clicked.connect(lambda: self.player.set_up())
        self.report, self.hand_in = (QPushButton(w, autoDefault=True) for w in ("Report", "Hand in…"))
        self.report.setProperty("flat", True)
        self.report.setToolTip("Show a report with your answers and figures in the browser")
        icons.bind(self.report, "info", "ink2", 18)
        icons.bind(self.hand_in, "export", "ink", 18)
        self.hand_in.setToolTip(
            "Save your answers, the checks and the data of the checks as one file for your instructor"
        )
        self.report.clicked.connect(self.show_report)
        self.hand_in.clicked.connect(self.ask_hand_in)
        head = QWidget()
        vbox(
            hbox(self.back_to_list, None, self.place), self.title, self.dot_row,
            into=head, margins=(_SIDE, 8, _SIDE, 8), gap=6,
        )  # fmt: skip
        # a gap of 8 would cut off "Reset step" beside "Finish"
        moves = hbox(self.back, self.again, None, primary(self.next), margins=(_SIDE, 10, _SIDE, 10), gap=4)
        files = hbox(self.report, None, self.hand_in, margins=(_SIDE, 8, _SIDE, 10))
        vbox(head, (self.body, 1), rule(), moves, rule(), files, into=part)
        return part

    def _show_opened(self) -> None:
        """Show the list, or the lesson that was opened."""
        lesson = self.player.lesson
        self.stays = lesson is not None
        self.stack.setCurrentIndex(int(self.stays))
        if lesson is None:
            self._show_list()
        else:
            self.title.setText(lesson.title)
            for old in self.dots:
                self.dot_row.removeWidget(old)
                old.hide()
                old.deleteLater()
            self.dots = [StepDot(at, step.title) for at, step in enumerate(lesson.steps, 1)]
            while self.dot_row.takeAt(0):
                pass
            for at, dot in enumerate(self.dots):
                dot.clicked.connect(partial(self.player.go, at))
                self.dot_row.addWidget(dot)
            self.dot_row.addStretch(1)
        self.changed.emit()

    def show_step(self) -> None:
        """Show the open step's text and tasks."""
        progress, step = self.player.progress, self.player.step
        if progress is None or step is None:
            return
        at, count = progress.step, len(progress.lesson.steps)
        self.place.setText(f"Step {at + 1} of {count}")
        self.back.setEnabled(at > 0)
        last = at + 1 == count
        self.next.setText("Finish" if last else "Next")
        self.next.setToolTip("Go back to the list of lessons" if last else "Go to the next step (Alt+Right)")
        blocks = [*(progress.lesson.intro if at == 0 else ()), *step.blocks]
        self.tasks = {}
        parts = [self._part(block) for block in blocks]
        self.body.show_parts([label(step.title, "headline"), *parts])
        self.show_results()
        stops = [stop for part in parts if isinstance(part, Task | HintPart) for stop in part.stops()]
        self._order(
            [self.back_to_list, *self.dots, *stops, self.back, self.again, self.next, self.report,
             self.hand_in]
        )  # fmt: skip
        self.changed.emit()

    def _part(self, block: Block) -> QWidget:
        if isinstance(block, Text):
            return text_label(block.tokens)
        if isinstance(block, Formula):
            return formula_label(block.tex)
        if isinstance(block, Hint):
            return HintPart(block)
        if isinstance(block, Plot):
            return plot_part(block)
        if isinstance(block, Question):
            assert self.player.progress is not None
            task = QuestionTask(block, self.player.progress.answers.get(block.key, ""))
            task.answered.connect(partial(self.player.answer, block))
            self.tasks[block.key] = task
            return task
        self.tasks[block.key] = CheckTask(block)
        return self.tasks[block.key]

    def show_results(self) -> None:
        """Update the state of checks, questions and steps."""
        progress, step = self.player.progress, self.player.step
        if progress is None or step is None:
            return
        for block in step.blocks:
            if isinstance(block, Check | Question):
                self.tasks[block.key].show_result(progress.result(block))
        for at, dot in enumerate(self.dots):
            dot.show_state(progress.step_done(at), at == progress.step)
        lay_out(self.body)

    def _show_view(self) -> None:
        step = self.player.step
        if step is not None:
            self.view_wanted.emit("lessons" if step.scene.view == "live" else step.scene.view)
            over = [block.over for block in step.blocks if isinstance(block, Plot)]
            if channel := next((one for one in over if one != "time"), ""):
                self.plot_wanted.emit(channel)

    def _order(self, parts: list[QWidget]) -> None:
        """Set the order in which the Tab key moves through these widgets."""
        for before, part in pairwise(parts):
            if before.window() is part.window():
                QWidget.setTabOrder(before, part)

    # files

    def show_report(self) -> None:
        """Write the report and open it in the browser."""
        from hapkit_studio.lessons.hand_in import read  # imported late because it takes a while
        from hapkit_studio.lessons.report import report

        progress = self.player.progress
        if progress is None:
            return
        path = file_of(progress.lesson)
        page = path.with_suffix(".html")
        try:
            self.player.write(path, self.player.student)
            page.write_text(report(read(path), progress.lesson), encoding="utf-8")
        except (StudioError, OSError) as error:
            self.show_text(f"The report could not be written. {error}")
            return
        self.show_text(
            ""
            if QDesktopServices.openUrl(QUrl.fromLocalFile(str(page)))
            else f"The report was saved as {page}."
        )

    def ask_hand_in(self) -> None:
        """Ask for the student's name, then for the file."""
        WordsDialog(
            "Hand in", "Your name", _LONGEST_NAME, self._ask_file, self.window(), button="Choose the file…",
            text=self.player.student,
        ).show()  # fmt: skip

    def _ask_file(self, student: str) -> None:
        lesson = self.player.lesson
        if lesson is None:
            return
        if not student:
            self.show_text("Nothing was handed in. Enter your name first.")
            return
        self.player.student = student
        self._settings.setValue(STUDENT, student)
        name = "".join(letter if letter.isalnum() else "_" for letter in student)
        kinds = "Handed-in lessons (*.hapkit)"
        choose_file(self, "Hand in", kinds, self.save_handed_in, save_as=f"{name}_{lesson.key}.hapkit")

    def save_handed_in(self, path: str) -> None:
        """Write the file that the student hands in."""
        progress = self.player.progress
        if progress is None:
            return
        try:
            self.player.write(Path(path), self.player.student)
        except StudioError as error:
            self.show_text(f"Nothing was handed in. {error}")
            return
        done, count = progress.counts
        self.show_text(
            f"Saved as {Path(path).name}, with {done} of {count} tasks done. Give it to your instructor."
        )
