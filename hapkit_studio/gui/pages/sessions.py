"""The view Sessions: a list of recordings to search, view, replay, export, rename, copy and delete."""

import re
from collections.abc import Callable
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QFile, QSettings, QUrl
from PySide6.QtGui import QDesktopServices, QFontMetrics
from PySide6.QtWidgets import QFileDialog, QFrame, QLineEdit, QPushButton

from hapkit_studio.charts.session import draw
from hapkit_studio.errors import StudioError
from hapkit_studio.formatting import megabytes, number
from hapkit_studio.gui.editor.controller import DeleteDialog
from hapkit_studio.gui.live.export import COMMA, TABLES
from hapkit_studio.gui.live.replay import Replay
from hapkit_studio.gui.pages.base import Page, Pairs, SidePanel, View
from hapkit_studio.gui.pages.drawing import Drawing
from hapkit_studio.gui.pages.lessons.page import STUDENT
from hapkit_studio.gui.state.background import Job, Progress
from hapkit_studio.gui.state.stored import LESSONS_FOLDER
from hapkit_studio.gui.widgets.dialogs import WordsDialog
from hapkit_studio.gui.widgets.parts import choose_file, hbox, hint, primary, rule, vbox
from hapkit_studio.gui.widgets.style import mark
from hapkit_studio.gui.widgets.table import Table
from hapkit_studio.gui.widgets.theme import theme
from hapkit_studio.sessions.database import BESIDE
from hapkit_studio.sessions.event_values import one_line
from hapkit_studio.sessions.file import SUFFIX, SessionError
from hapkit_studio.sessions.folder import choose_folder, files, folder, rename
from hapkit_studio.sessions.overview import Overview, columns, date_text, overview
from hapkit_studio.sessions.session import Session, add_note

if TYPE_CHECKING:
    from hapkit_studio.gui.live.live import Live
    from hapkit_studio.gui.state.studio import Studio
    from hapkit_studio.lessons.hand_in import HandedIn
    from hapkit_studio.lessons.lesson import Lesson

_NONE = "Nothing is recorded yet in {}. Press Record (R), or save the last minutes (Ctrl+Shift+S)."
_READING = "Reading the sessions…"
_CHOOSE = "Choose a session in the table."
_SESSIONS = f"Sessions (*{SUFFIX})"
_SEARCH = 260  # px: width of the search field
_LONG_WORD = re.compile(r"\S{12,}")
_WIDE, _VALUE = 232, 140  # px: width of the texts in the panel, and of the values beside their names
_LONGEST = 200  # maximum number of letters in a note or a name
_MOST_LINES = 200  # maximum number of lines in the list of events
_CHART = 190  # px: minimum size of the chart

_OTHERS, _MOST_OTHERS = "sessions_elsewhere", 10

Known = dict[tuple[Path, float, int], Overview]


def read_overviews(paths: list[Path], known: Known, progress: Progress) -> Known:
    """Return the files' overviews; the key is a file's path, modification time and size.

    Files in ``known`` are not read again.
    """
    found: Known = {}
    for done, path in enumerate(paths):
        progress(done, len(paths))
        try:
            stat = path.stat()
            key = path, stat.st_mtime, stat.st_size
            found[key] = known.get(key) or overview(path)
        except OSError:  # the file was deleted meanwhile
            continue
    return found


def recent(settings: QSettings) -> list[Path]:
    """Return the recently opened sessions outside the recording folder that still exist."""
    kept = settings.value(_OTHERS, [])
    paths = [Path(path) for path in (kept if isinstance(kept, list) else [kept]) if isinstance(path, str)]
    return [path for path in paths if path.is_file()]


def export(path: Path, output: str, decimal: str) -> str:
    """Write a session as a table whose format follows from the file extension; return a report."""
    from hapkit_studio import api  # imported late to keep start-up fast

    run = api.open_session(path)
    try:
        run.save(output, decimal)
    except OSError as error:
        raise StudioError(f"The file {Path(output).name} cannot be written: {error.strerror}.") from error
    return f"The file {Path(output).name} was saved with {len(run.time):,} samples"


def save_copy(path: Path, output: Path) -> str:
    """Write all readable data of a session into one complete file; return a report."""
    with closing(Session(path)) as session:
        damage = session.repair(output)
    return " ".join([f"The copy {one_line(output.name)} was saved as one complete file.", *damage])


class SessionsPage(Page):
    """Shows a search field and a list.

    The chart of the chosen session is below the list, and the session's events are beside the list.
    """

    side: SidePanel

    def __init__(self, studio: "Studio", live: "Live"):
        super().__init__()
        self._studio, self._live = studio, live
        self._known: Known = {}
        self._settings = QSettings("hapkit-studio", "hapkit-studio")
        self._others = recent(self._settings)
        self._newest: tuple[Path, int] | None = None
        self._wanted: Path | None = None
        self.chosen: Overview | None = None
        self.search = QLineEdit(placeholderText="Search sessions", clearButtonEnabled=True)
        self.search.setAccessibleName("Search sessions")
        self.search.setToolTip(
            "Search names, environments, devices and notes. A session is found if it contains every word"
        )
        self.status, self.empty = hint(), hint(_READING)
        self.table = Table("Sessions", scrolls=True)
        self.chart = Drawing("Position over time", (_CHART, _CHART))
        self.side = SidePanel("Sessions", _CHOOSE)
        self.facts = Pairs()
        self.replay, self.export = primary(QPushButton("Replay")), QPushButton("Export…")
        self.note, self.rename = QPushButton("Note…"), QPushButton("Rename…")
        self.copy, self.delete = QPushButton("Save a copy…"), QPushButton("Delete…")
        self.review = QPushButton("Review…")
        self.review.setToolTip(
            "Give points and comments on a handed-in lesson, and save them in a separate file"
        )
        self.replay.setToolTip("Show the session in the view Live, with its own settings (Enter)")
        self._arrange()
        self._reading, self._saving, self._changing, self._opening = self._jobs = [
            Job(self, needs="") for _ in range(4)
        ]
        self._opening.finished.connect(self._show_review)
        self._reading.finished.connect(self._take)
        self._saving.finished.connect(self.show_text)
        self._changing.finished.connect(self._show_changed)
        for job in self._jobs:
            job.failed.connect(partial(self.show_text, danger=True))
        self.search.textChanged.connect(lambda _text: self._list())
        self.table.chosen.connect(self.show_session)
        self.table.activated.connect(lambda index: self._replay(self.table.content.rows[index.row()]))
        self.replay.clicked.connect(lambda: self._replay(self.chosen))
        self.export.clicked.connect(self.ask_export)
        self.note.clicked.connect(self.ask_note)
        self.rename.clicked.connect(self.ask_rename)
        self.copy.clicked.connect(self.ask_copy)
        self.delete.clicked.connect(self.ask_delete)
        self.review.clicked.connect(self.ask_review)
        studio.hidden_changed.connect(lambda: self.show_session(self.chosen))
        studio.recording.changed.connect(self._notice)
        self.show_session(None)

    # actions of the user

    def load(self) -> None:
        """Read the folder's sessions in a thread, except the file that is still being written."""
        progress, known = self._studio.recording.progress, self._known
        others = [path for path in self._others if path.parent != folder()]
        busy = progress.path if progress is not None else None

        def read(progress: Progress) -> Known:
            return read_overviews([path for path in (*files(), *others) if path != busy], known, progress)

        self._reading.start(read)

    def ask_open(self) -> None:
        """Ask for a session file in any folder, then add it to the list and select it."""
        choose_file(self, "Open a session", _SESSIONS, self.open_other)

    def ask_folder(self) -> None:
        """Ask for the folder for new recordings in a non-modal dialog."""
        dialog = QFileDialog(self, "Choose the folder for recordings", str(folder()))
        dialog.setFileMode(QFileDialog.FileMode.Directory)
        dialog.setOption(QFileDialog.Option.ShowDirsOnly)
        dialog.fileSelected.connect(self.record_into)
        dialog.setModal(False)
        dialog.finished.connect(dialog.deleteLater)
        dialog.show()

    def record_into(self, path: str) -> None:
        """Record into another folder and list its sessions."""
        try:
            choose_folder(Path(path))
        except SessionError as error:
            self.show_text(str(error), danger=True)
            return
        self.show_text(f"New sessions will be recorded into the folder {folder()}.")
        self.load()

    def open_other(self, path: str) -> None:
        """Add a session file from any folder to the list, and select it."""
        self._wanted = Path(path)
        self._others = [Path(path), *(other for other in self._others if other != Path(path))][:_MOST_OTHERS]
        self._settings.setValue(_OTHERS, [str(other) for other in self._others])
        self.search.clear()
        self.load()

    def show_session(self, found: Overview | None) -> None:
        """Show a session's overview; with None, clear the overview."""
        self.chosen = found
        self.side.heading.setText(_folded(found.name, "title", _WIDE) if found else "Sessions")
        self.side.label.setText(_folded(_overview_text(found), "hint", _WIDE) if found else _CHOOSE)
        self.facts.show_pairs(_pairs(found, self._titles) if found else [])
        self.happened.show_pairs(_story(found) if found else [])
        whole = found is not None and not found.error
        ended = found is not None and not found.unfinished
        self.replay.setEnabled(whole and not self._studio.hidden)
        self.note.setEnabled(found is not None and whole and ended and not found.damage)
        self.rename.setEnabled(ended)
        for button in (self.export, self.copy, self.review):
            button.setEnabled(whole)
        self.delete.setEnabled(found is not None)
        self.chart.setVisible(whole)
        if found is not None and whole:
            self.chart.show_drawing(lambda figure, c: draw(figure, c, found.trace, found.markers))
        self.changed.emit()

    def _replay(self, found: Overview | None) -> None:
        if found is not None and not found.error:
            self._live.replay_wanted.emit(found.path)

    def ask_export(self) -> None:
        """Ask for a file name in a non-modal dialog, then write the chosen session as a table."""
        if self.chosen is None:
            return
        path = self.chosen.path

        def save(output: str) -> None:
            decimal = "," if dialog.selectedNameFilter() == COMMA else "."
            self.show_text(f"Exporting {path.stem}…")
            self._saving.start(lambda _progress: export(path, output, decimal))

        dialog = choose_file(self, "Export", TABLES, save, save_as=f"{path.stem}.csv")

    def ask_review(self) -> None:
        """Open the review of the chosen session, if it is a handed-in lesson."""
        if self.chosen is None:
            return
        path, folder = self.chosen.path, str(self._settings.value(LESSONS_FOLDER, "")) or None
        known = self._studio.environments

        def work(_progress: Progress) -> "tuple[HandedIn, Lesson]":
            from hapkit_studio.lessons import library  # imported late to keep start-up fast
            from hapkit_studio.lessons.hand_in import read

            handed = read(path)
            return handed, library(folder, known).named(handed.lesson)

        self._opening.start(work)

    def _show_review(self, found: "tuple[HandedIn, Lesson]") -> None:
        from hapkit_studio.gui.pages.review import ReviewDialog  # imported late to keep start-up fast

        name, replay = str(self._settings.value(STUDENT, "")), self._live.findChild(Replay)
        ReviewDialog(*found, name, replay, self._live.replay_wanted.emit, self.window()).show()

    def ask_delete(self) -> None:
        """Ask for confirmation, then move the chosen session to the trash."""
        if self.chosen is not None:
            DeleteDialog(self.chosen.path, self._forget, self.window()).show()

    def _forget(self, path: Path) -> None:
        """After a session was moved to the trash, also move its accompanying files there."""
        for ending in BESIDE:
            if (beside := path.with_name(path.name + ending)).exists():
                QFile.moveToTrash(str(beside))
        self.load()

    def ask_note(self) -> None:
        """Ask for a note, then write it into the chosen session's file."""
        if self.chosen is None or self._changing.running:
            return
        found = self.chosen

        def add(text: str) -> None:
            def work(_progress: Progress) -> tuple[Path, str]:
                add_note(found.path, text)
                return found.path, f"The note was added to {found.name}."

            if text:
                self.show_text(f"Adding a note to {found.name}…")
                self._changing.start(work)

        WordsDialog("Add a note", f"Note on {found.name}", _LONGEST, add, self.window()).show()

    def ask_rename(self) -> None:
        """Ask for a new name for the chosen session's file."""
        if self.chosen is None or self._changing.running:
            return
        found = self.chosen

        def change(name: str) -> None:
            def work(_progress: Progress) -> tuple[Path, str]:
                new = rename(found.path, name)
                return new, f"{found.name} was renamed to {new.stem}."

            self._changing.start(work)

        WordsDialog(
            "Rename the session",
            "New name of the session",
            _LONGEST,
            change,
            self.window(),
            "Rename",
            found.name,
        ).show()

    def ask_copy(self) -> None:
        """Ask for a file name, then copy all readable data of the chosen session into that file."""
        if self.chosen is None or self._changing.running:
            return
        found = self.chosen

        def save(output: str) -> None:
            self.show_text(f"Copying {found.name}…")
            self._changing.start(lambda _progress: (Path(output), save_copy(found.path, Path(output))))

        choose_file(self, "Save a copy", _SESSIONS, save, save_as=f"{found.name} (copy){SUFFIX}")

    def _show_changed(self, changed: tuple[Path, str]) -> None:
        """Select a session that was changed, renamed or written, and report the change."""
        path, text = changed
        self.show_text(text)
        self._known = {key: found for key, found in self._known.items() if key[0] != path}
        if path.parent == folder():
            self._wanted = path
            self.search.clear()
            self.load()
        else:
            self.open_other(str(path))

    def show_text(self, text: str, danger: bool = False) -> None:
        """Show a status or an error."""
        self.status.setText(text)
        self.status.show()
        mark(self.status, "role", "error" if danger else "hint")

    def set_shown(self, on: bool) -> None:
        if on:
            self.load()

    # methods of the list

    @property
    def _titles(self) -> Callable[[str], str]:
        """Return a function from an environment's key to its title; it returns an unknown key unchanged."""
        known = self._studio.environments
        return lambda key: known[key].title if key in known else key

    def _notice(self) -> None:
        """Reload the list if a session was just written and the page is visible."""
        newest = self._studio.recording.newest
        if newest != self._newest:
            self._newest = newest
            self._wanted = newest[0] if newest is not None else self._wanted
            if newest is not None and self.isVisible():
                self.load()

    def _take(self, found: Known) -> None:
        self._known = found
        self.empty.setText(_NONE.format(folder()))
        self._list()

    def _list(self) -> None:
        """List the sessions that match the search, newest first; keep the selection if possible."""
        wanted = self._wanted or (self.chosen.path if self.chosen is not None else None)
        words = self.search.text().lower().split()
        rows = [row for row in self._known.values() if all(word in self._text(row) for word in words)]
        rows.sort(key=lambda row: row.saved, reverse=True)
        self.table.show_rows(columns(self._titles), rows)
        self.empty.setHidden(bool(self._known))
        paths = [row.path for row in rows]
        if paths:
            self.table.selectRow(paths.index(wanted) if wanted in paths else 0)
        else:
            self.show_session(None)
        if self._wanted in paths:
            self._wanted = None

    def _text(self, row: Overview) -> str:
        """Return a row's searchable text in lower case."""
        named = row.name, row.device, *map(self._titles, row.environments)
        return " ".join((*named, *row.noted)).lower()

    def _arrange(self) -> None:
        other, reveal, into = (
            QPushButton(part, autoDefault=True)
            for part in ("Open…", "Show folder", "Choose the folder for recordings…")
        )
        into.setToolTip("Choose the folder for recordings")
        other.clicked.connect(self.ask_open)
        reveal.clicked.connect(self._reveal)
        into.clicked.connect(self.ask_folder)
        self.search.setMaximumWidth(_SEARCH)
        card = QFrame()
        card.setProperty("card", True)
        bar = hbox((self.search, 1), None, other, reveal, into, margins=(12, 7, 12, 7), gap=10)
        for part in (self.status, self.empty):
            part.setContentsMargins(16, 8, 16, 8)
        self.status.hide()
        listed = hbox(self.table, margins=(10, 0, 10, 0))
        vbox(
            bar,
            rule(),
            self.status,
            self.empty,
            (listed, 3),
            rule(),
            (self.chart, 2),
            into=card,
            margins=(1, 1, 1, 1),
        )
        self.column.addWidget(card)
        self.side.add(self.facts)
        self.happened = Pairs(self.side.section("Events in this session"))
        self.side.add(self.happened)
        self.side.column.insertLayout(2, hbox(self.replay, self.export, None))
        self.side.column.insertLayout(3, hbox(self.note, self.rename, None))
        self.side.column.insertLayout(4, hbox(self.copy, self.delete, None))
        self.side.column.insertLayout(5, hbox(self.review, None))

    def _reveal(self) -> None:
        """Open the folder of the chosen session, or the default folder if no session is chosen."""
        place = self.chosen.path.parent if self.chosen is not None else folder()
        if not QDesktopServices.openUrl(QUrl.fromLocalFile(str(place))):
            self.show_text(f"The sessions are in {place}.")


def _folded(text: str, role: str = "body", width: int = _VALUE) -> str:
    """Break words that are wider than ``width`` px into several lines."""
    metrics, most = QFontMetrics(theme.font(role)), theme.px(width)

    def fold(found: re.Match) -> str:
        lines = [""]
        for letter in found[0]:
            if metrics.horizontalAdvance(lines[-1] + letter) > most:
                lines.append("")
            lines[-1] += letter
        return "\n".join(lines)

    return _LONG_WORD.sub(fold, text)


def _overview_text(found: Overview) -> str:
    if found.error:
        return one_line(found.error)
    size = f"{number(found.seconds, 1)} s, {found.samples:,} samples"
    return ". ".join([size, *map(one_line, found.damage), *([found.unfinished] if found.unfinished else [])])


def _pairs(found: Overview, title: Callable[[str], str]) -> list[tuple[str, str]]:
    pairs = [
        ("Saved", date_text(found.saved)),
        ("Size", megabytes(found.size)),
        ("Folder", found.path.parent.name),
    ]
    if not found.error:
        pairs += [("Device", found.device), ("Environments", ", ".join(map(title, found.environments)))]
        pairs += [("Note", text) for text in found.notes]
    return [(name, _folded(value)) for name, value in pairs]


def _story(found: Overview) -> list[tuple[str, str]]:
    """Return the time and the description of each marker and each change of settings, sorted by time."""
    happened = sorted((*found.markers, *found.changes))
    more = len(happened) - _MOST_LINES
    lines = [(f"{when:.2f} s", _folded(text)) for when, text in happened[:_MOST_LINES]]
    return (
        [*lines, ("", f"{more:,} more events: run “hapkit-studio sessions show” in a terminal to list them")]
        if more > 0
        else lines
    )


VIEW = View("sessions", "Sessions", 70, SessionsPage, scene=False)
