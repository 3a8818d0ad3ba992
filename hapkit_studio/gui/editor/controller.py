"""Connects the editor with the user's own environments: page actions become file operations."""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
from PySide6.QtCore import QFile, QFileSystemWatcher, QObject, QTimer, QUrl, Signal
from PySide6.QtGui import QDesktopServices
from PySide6.QtWidgets import QPushButton, QWidget

from hapkit_studio.errors import LawError
from hapkit_studio.gui.editor import code_page
from hapkit_studio.gui.editor.code_page import CodePage
from hapkit_studio.gui.editor.cycles import Cycles
from hapkit_studio.gui.editor.editor import Editor
from hapkit_studio.gui.state.own_environments import OwnEnvironments
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.gui.widgets.dialogs import TextDialog, text_dialog
from hapkit_studio.gui.widgets.parts import choose_file, hbox, label
from hapkit_studio.haptics import rows
from hapkit_studio.workshop import folder
from hapkit_studio.workshop.source import Source, is_trusted, read, trust_source, typed
from hapkit_studio.workshop.trying import TrialResult

_GOES_ON = "The previous law keeps running."
_SINCE = "Your later changes are not saved."
SETTLED_MS = 200
_LINE = re.compile(r"\bline (\d+)")


def outcome(verdict: TrialResult, unsaved: bool = False) -> tuple[str, str]:
    """Return a trial's outcome as a text with its tone; ``unsaved``: the text was changed after the trial."""
    since = [_SINCE] if unsaved else []
    if verdict.problems:
        return " ".join([*map(str, verdict.problems), _GOES_ON, *since]), "danger"
    tested = f"In a test, {verdict.calls:,} calls of the law took {verdict.ns_per_call:.0f} ns each."
    cost = [tested] if verdict.calls else []
    notes = [*verdict.warnings, *map(str, verdict.remarks)]
    return " ".join(["The law is running.", *(notes or cost), *since]), "warn" if notes else "ok"


def write_error(error: OSError) -> str:
    """Return a sentence with the reason why a file could not be written."""
    return f"The file was not saved: {error.strerror or error}. Your text is still in the editor."


class EditorController(QObject):
    """Opens and saves laws; ``shown(bool)`` is emitted to show or hide the editor."""

    shown = Signal(bool)
    own: OwnEnvironments
    page: CodePage

    def __init__(self, studio: Studio, own: OwnEnvironments, parent: QObject | None = None):
        super().__init__(parent)
        self._studio, self.own = studio, own
        self.editor = Editor(folder.templates())
        self.page, self.message = self.editor.page, self.editor.page.message
        self._asked_to_quit = False
        self.cycles = Cycles(studio, own, self.page, self)
        self.editor.chooser.made.connect(self.create)
        self.editor.chooser.left.connect(self._back)
        self.editor.source.run_pressed.connect(self.agree)
        self.editor.source.left.connect(self._back)
        self.page.save_pressed.connect(self.save)
        self.page.close_pressed.connect(self.close)
        own.asked.connect(self.ask)
        own.chosen.connect(self._leave_source)
        own.changed.connect(self._leave_what_is_gone)
        studio.environment_changed.connect(self._leave_for_the_library)
        own.began.connect(self._show_began)
        own.judged.connect(self._show_verdict)

    @property
    def path(self) -> Path | None:
        """Return the path of the open law; None if no law is open."""
        return self.page.path

    # opening and saving a file

    def begin_new(self) -> None:
        """Show the templates for a new law."""
        self.editor.setCurrentWidget(self.editor.chooser)
        self.shown.emit(True)
        self.editor.chooser.begin([file.title for file in self.own.files])

    def create(self, template, title: str) -> None:
        """Make a file from a template, open it and apply it."""
        try:
            path = folder.new_path(title)
            source = self._write(path, folder.fill_template(template, title, path.stem))
        except OSError as error:
            self.editor.chooser.message.show_text(write_error(error), "danger")
            return
        self.own.run(source)
        self._open(source)

    def edit(self, path: Path) -> None:
        """Open a file's law; an untrusted law is shown without being executed."""
        source = self._read(path)
        if source is not None:
            (self._open if is_trusted(source) else self.ask)(source)

    def _open(self, source: Source) -> None:
        path = source.path
        if path != self.path or (source.text != self.page.text and not self.page.unsaved):
            self.page.open(path, source.text)
            loaded = self.own.loaded(path)
            if loaded is not None and loaded.source.text == self.page.text:
                self.page.code.mark((), [(r.line, r.text) for r in loaded.force.remarks])
        self.editor.setCurrentWidget(self.page)
        self.shown.emit(True)
        self.page.code.setFocus()

    def save(self) -> None:
        """Save the open law and try it; the previous version runs until the trial has succeeded."""
        if self.path is None:
            return
        try:
            source = self._write(self.path, self.page.text)
        except OSError as error:
            self.message.show_text(write_error(error), "danger")
            return
        self.page.note_saved()
        self.own.run(source)

    def ask(self, source: Source) -> None:
        """Show the source of an untrusted file without executing it."""
        self.editor.source.show_source(source)
        self.editor.setCurrentWidget(self.editor.source)
        self.shown.emit(True)
        self.editor.source.leave.setFocus()

    def bring(self, path: Path) -> None:
        """Open any file: directly if it is in the user's folder, otherwise after a question."""
        if path in folder.own_files():
            self.own.choose(path)
        elif (source := self._read(path)) is not None:
            self.ask(source)

    def _read(self, path: Path) -> Source | None:
        """Return a file's content; if it cannot be read, report the error and return None."""
        try:
            return read(path)
        except LawError as error:
            text_dialog(path.name, [str(error)], self.editor.window()).show()
            return None

    def forget(self, path: Path) -> None:
        """Close the law of a file that was deleted."""
        code_page.delete_draft(path)
        if path == self.path:
            self.discard()
        self.own.refresh()

    def agree(self, source: Source) -> None:
        """Trust the text that the user has read, copy it into the folder, and try it."""
        path = source.path
        try:
            if path in folder.own_files():
                trust_source(source)
            else:
                path = self._write(folder.new_path(path.stem), source.text).path
        except OSError as error:
            self.message.show_text(write_error(error), "danger")
            return
        self.own.choose(path)
        self.edit(path)

    def end(self) -> None:
        """Store unsaved text as a draft before the window closes."""
        self.page.keep_draft()

    def _write(self, path: Path, text: str) -> Source:
        """Save a text and trust it, because the user has saved it; return its Source."""
        source = typed(path, text)
        folder.save(path, text)
        trust_source(source)
        return source

    # unsaved text: the page's message line asks the user about it

    def close(self) -> None:
        """Close the law; if its text is unsaved, ask the user first."""
        if self.page.unsaved:
            self._ask(("Save", lambda: self._save_and(self._leave)), ("Discard changes", self.discard))
        else:
            self._leave()

    def discard(self) -> None:
        """Discard unsaved text and close the law."""
        self.page.note_saved()
        self._leave()

    def ask_to_quit(self, quit_: Callable[[], object]) -> bool:
        """Return True if the window may close; otherwise ask about unsaved text and close afterwards."""
        if not self.page.unsaved or self._asked_to_quit:
            return True
        self._asked_to_quit = True
        self.editor.setCurrentWidget(self.page)
        self.shown.emit(True)
        self._ask(("Save and quit", lambda: self._save_and(quit_)), ("Quit and keep a draft", quit_))
        return False

    def _ask(self, *buttons: tuple[str, Callable[[], object]]) -> None:
        name = self.path.name if self.path else ""
        self.message.show_text(
            f"The changes in {name} are not saved.", "warn", (*buttons, ("Continue editing", self._go_on))
        )
        self.message.buttons[0].setFocus()

    def _go_on(self) -> None:
        self._asked_to_quit = False
        self.message.show_text("")
        self.page.code.setFocus()

    def _save_and(self, then: Callable[[], object]) -> None:
        self.save()
        if not self.page.unsaved:
            then()

    def _leave(self) -> None:
        self.page.leave()
        self.shown.emit(False)

    def _back(self) -> None:
        """Return from a page to the open law; if no law is open, hide the editor."""
        if self.path is None:
            self.shown.emit(False)
        else:
            self.editor.setCurrentWidget(self.page)

    def _leave_for_the_library(self) -> None:
        """Close another person's source when the user selects a library environment.

        A running trial continues.
        """
        if self.own.active is None:
            self._leave_source()

    def _leave_what_is_gone(self) -> None:
        if not self.editor.source.source.path.exists():
            self._leave_source()

    def _leave_source(self) -> None:
        if self.editor.currentWidget() is self.editor.source:
            self._back()

    # messages about trials

    def _show_began(self, path: Path) -> None:
        if path == self.path:
            self.message.show_text("Checking the law line by line…", busy=True)

    def _show_verdict(self, path: Path, verdict: TrialResult) -> None:
        if not verdict.ok and path != self.path:
            self.edit(path)
        if path != self.path:
            return
        problems, remarks = ([(p.line, p.text) for p in s] for s in (verdict.problems, verdict.remarks))
        self.page.code.mark(problems, remarks)
        self.message.show_text(*outcome(verdict, self.page.unsaved))
        if verdict.problems and verdict.problems[0].line:
            self.page.code.scroll_to(verdict.problems[0].line)


class FileActions:
    """Opens file dialogs; they never block the window, because the motor may be on."""

    def __init__(self, controller: EditorController, window: QWidget):
        self._controller, self._window = controller, window

    def open(self) -> None:
        """Ask for any file; its source is shown before it is executed."""
        labels = "Open an environment", "Python files (*.py)"
        choose_file(self._window, *labels, lambda name: self._controller.bring(Path(name)))

    def reveal(self, path: Path) -> None:
        """Open a file's folder."""
        QDesktopServices.openUrl(QUrl.fromLocalFile(str(path.parent)))

    def delete(self, path: Path) -> None:
        """Ask for confirmation, then move a file to the trash."""
        DeleteDialog(path, self._controller.forget, self._window).show()


class DeleteDialog(TextDialog):
    """Asks before deleting a file, and calls ``forget`` afterwards; the focus is on the safe answer."""

    def __init__(self, path: Path, forget: Callable[[Path], object], parent: QWidget):
        super().__init__(f"Delete {path.name}?", parent)
        self._path, self._forget = path, forget
        self.label = label("The file is moved to the trash, from which you can restore it.")
        self.label.setMinimumWidth(360)
        self.keep, self.delete = QPushButton("Keep the file"), QPushButton("Move to the trash")
        self.keep.clicked.connect(self.close)
        self.delete.clicked.connect(self._delete)
        self.column.addWidget(self.label)
        self.column.addLayout(hbox(None, self.keep, self.delete))
        self.keep.setFocus()

    def _delete(self) -> None:
        if QFile.moveToTrash(str(self._path)):
            self._forget(self._path)
            self.close()
        else:
            self.label.setText(
                f"The folder {self._path.parent} has no trash. Delete the file there with your file manager."
            )
            self.delete.hide()


class FileWatcher(QObject):
    """Reports changes of files to the page of the open law."""

    def __init__(self, studio: Studio, controller: EditorController, parent: QObject | None = None):
        super().__init__(parent)
        self._studio, self._controller = studio, controller
        self._fault = ""
        self._soon = QTimer(self, interval=SETTLED_MS, singleShot=True)
        self._soon.timeout.connect(self.check_files)
        self._files = QFileSystemWatcher(self)
        self._files.directoryChanged.connect(self._soon.start)
        self._files.fileChanged.connect(self._soon.start)
        controller.own.changed.connect(self._watch)
        self._watch()

    def check_files(self) -> None:
        """Detect changes by other programs; the open law is read again unless it has unsaved changes."""
        controller = self._controller
        controller.own.refresh()
        self._watch()
        if controller.path is None or controller.page.unsaved:
            return
        try:
            text = controller.own.seen(controller.path).text
        except LawError:
            return
        if text != controller.page.text:
            controller.page.open(controller.path, text)
            controller.message.show_text(
                "Another program has changed this file. Read the new text, then press Ctrl+S to run it.",
                "warn",
            )

    def _watch(self) -> None:
        """Watch the folder and its files; if the folder does not exist, watch its nearest existing parent."""
        files = [file.path for file in self._controller.own.files]
        wanted = {str(path) for path in (folder.existing(), *files)}
        heard = {*self._files.directories(), *self._files.files()}
        if heard - wanted:
            self._files.removePaths(sorted(heard - wanted))
        if wanted - heard:
            self._files.addPaths(sorted(wanted - heard))

    def on_row(self, row: np.ndarray, _clamped: bool) -> None:
        """Mark the line that caused a fault of the open law, once per fault."""
        if not int(row[rows.FLAGS]) & rows.FAULT:
            self._fault = ""
            return
        fault = self._studio.fault
        if fault is None or fault.text == self._fault:
            return
        self._fault = fault.text
        line = _LINE.search(fault.text)
        controller = self._controller
        if line is None or controller.path is None or controller.path != controller.own.active:
            return
        # in unsaved text the line numbers may differ from those of the running law
        if not controller.page.unsaved:
            controller.page.code.mark([(int(line[1]), fault.text.removeprefix("Fault: "))])
        controller.message.show_text(fault.text, "danger")
