"""The desk: joins editor and own environments; what was pressed on a page becomes what happens to a file."""

from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import QObject, Signal

from hapkit_studio.errors import LawError
from hapkit_studio.gui.editor import drafts, words
from hapkit_studio.gui.editor.code_page import CodePage
from hapkit_studio.gui.editor.cycles import Cycles
from hapkit_studio.gui.editor.editor import Editor
from hapkit_studio.gui.editor.leaving import Leaving
from hapkit_studio.gui.help_dialog import words_sheet
from hapkit_studio.gui.own import OwnEnvironments
from hapkit_studio.gui.studio import Studio
from hapkit_studio.workshop import folder, templates, trust
from hapkit_studio.workshop.source import Source, read, typed
from hapkit_studio.workshop.verdict import Verdict


class Desk(QObject):
    """Opens and saves laws. ``shown(bool)``: the editor is wanted in sight, or not any more."""

    shown = Signal(bool)
    own: OwnEnvironments
    leaving: Leaving
    page: CodePage

    def __init__(self, studio: Studio, own: OwnEnvironments, parent: QObject | None = None):
        super().__init__(parent)
        self._studio, self.own = studio, own
        self.editor = Editor(templates.templates())
        self.page, self.strip = self.editor.page, self.editor.page.strip
        self.leaving = Leaving(self.page, self.save, self._leave)
        self.cycles = Cycles(studio, own, self.page, self)
        self.editor.chooser.made.connect(self.create)
        self.editor.chooser.left.connect(self._back)
        self.editor.source.run_pressed.connect(self.agree)
        self.editor.source.left.connect(self._back)
        self.page.save_pressed.connect(self.save)
        self.page.close_pressed.connect(self.leaving.close)
        own.asked.connect(self.ask)
        own.chosen.connect(self._leave_source)
        own.changed.connect(self._leave_what_is_gone)
        studio.environment_changed.connect(self._leave_for_the_library)
        own.began.connect(self._show_began)
        own.judged.connect(self._show_verdict)

    @property
    def path(self) -> Path | None:
        """Return the file whose law is open, None for none."""
        return self.page.path

    # a file's way through the editor

    def begin_new(self) -> None:
        """Offer the templates."""
        self.editor.show_page(self.editor.chooser)
        self.shown.emit(True)
        self.editor.chooser.begin([file.title for file in self.own.files])

    def create(self, template, title: str) -> None:
        """Make a file from a template, open it and put it in force."""
        try:
            path = folder.new_path(title)
            source = self._write(path, templates.fill(template, title, path.stem))
        except OSError as error:
            self.editor.chooser.strip.say(words.not_saved(error), "danger")
            return
        self.own.run(source)
        self._open(source)

    def edit(self, path: Path) -> None:
        """Open a file's law; what nobody agreed to is only shown."""
        try:
            source = read(path)
        except LawError as error:
            words_sheet(path.name, [str(error)], self.editor.window()).show()
            return
        if not trust.is_trusted(source):
            self.ask(source)
        else:
            self._open(source)

    def _open(self, source: Source) -> None:
        path = source.path
        if path != self.path or (source.text != self.page.text and not self.page.unsaved):
            self.page.open(path, source.text)
        self.editor.show_page(self.page)
        self.shown.emit(True)
        self.page.code.setFocus()

    def save(self) -> None:
        """Write the law that is open and try it out; the old one goes on meanwhile."""
        if self.path is None:
            return
        try:
            source = self._write(self.path, self.page.text)
        except OSError as error:
            self.strip.say(words.not_saved(error), "danger")
            return
        self.page.note_saved()
        self.own.run(source)

    def ask(self, source: Source) -> None:
        """Show the source of a file nobody agreed to; nothing of it is executed."""
        self.editor.source.show_source(source)
        self.editor.show_page(self.editor.source)
        self.shown.emit(True)
        self.editor.source.leave.setFocus()

    def bring(self, path: Path) -> None:
        """Open a file from anywhere: one of the folder as it stands there, any other after asking."""
        if path in folder.own_files():
            self.own.choose(path)
            return
        try:
            self.ask(read(path))
        except LawError as error:
            words_sheet(path.name, [str(error)], self.editor.window()).show()

    def forget(self, path: Path) -> None:
        """Take note that a file is gone."""
        drafts.drop(path)
        if path == self.path:
            self.leaving.discard()
        self.own.refresh()

    def agree(self, source: Source) -> None:
        """Trust the very text that was shown, take it into the folder, and try it out."""
        path = source.path
        try:
            if path in folder.own_files():
                trust.trust(source)
            else:
                path = self._write(folder.new_path(path.stem), source.text).path
        except OSError as error:
            self.strip.say(words.not_saved(error), "danger")
            return
        self.own.choose(path)
        self.edit(path)

    def end(self) -> None:
        """Keep what is not saved and end a trial, before the window goes."""
        self.page.keep_draft()
        self.cycles.close()
        self.own.close()

    def _write(self, path: Path, text: str) -> Source:
        """Save a text, which is agreeing to it; return it as the file now is; raise OSError."""
        source = typed(path, text)
        folder.save(path, text)
        trust.trust(source)
        return source

    def ask_to_quit(self, quit_: Callable[[], object]) -> bool:
        """Say whether the window may go; where a law is not saved, bring it into sight and ask."""
        if self.page.unsaved:
            self.editor.show_page(self.page)
            self.shown.emit(True)
        return self.leaving.may_quit(quit_)

    def _leave(self) -> None:
        self.page.leave()
        self.shown.emit(False)

    def _back(self) -> None:
        """Go back from a page to the law that is open, if one is."""
        if self.path is None:
            self.shown.emit(False)
        else:
            self.editor.show_page(self.page)

    def _leave_for_the_library(self) -> None:
        """Close a stranger's source where the library was chosen instead; a trial may end beside it."""
        if self.own.in_force is None:
            self._leave_source()

    def _leave_what_is_gone(self) -> None:
        if not self.editor.source.source.path.exists():
            self._leave_source()

    def _leave_source(self) -> None:
        if self.editor.shows(self.editor.source):
            self._back()

    # how it stands

    def _show_began(self, path: Path) -> None:
        if path == self.path:
            self.strip.say("Checking line by line…", busy=True)

    def _show_verdict(self, path: Path, verdict: Verdict) -> None:
        if not verdict.ok and path != self.path:
            self.edit(path)
        if path != self.path:
            return
        self.page.code.mark([(p.line, p.text) for p in verdict.problems])
        self.strip.say(*words.of_verdict(verdict, self.page.unsaved))
        if verdict.problems and verdict.problems[0].line:
            self.page.code.bring_into_sight(verdict.problems[0].line)
