"""Sessions: what was recorded, found again, looked at, exported."""

from collections.abc import Callable
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QSettings, QUrl
from PySide6.QtGui import QDesktopServices
from PySide6.QtWidgets import QFrame, QLineEdit, QPushButton

from hapkit_studio.charts.session import draw
from hapkit_studio.errors import StudioError
from hapkit_studio.formatting import number
from hapkit_studio.gui.background import Job, Progress
from hapkit_studio.gui.dialogs import WordsDialog
from hapkit_studio.gui.editor.controller import DeleteDialog
from hapkit_studio.gui.pages.base import Page, Pairs, SidePanel, View
from hapkit_studio.gui.pages.drawing import Drawing
from hapkit_studio.gui.pages.table import Column, Table
from hapkit_studio.gui.recording import clock, megabytes
from hapkit_studio.gui.widgets.parts import across, choose_file, down, hint, primary, rule
from hapkit_studio.gui.widgets.style import mark
from hapkit_studio.sessions.file import SUFFIX
from hapkit_studio.sessions.folder import files, folder
from hapkit_studio.sessions.overview import Overview, overview
from hapkit_studio.sessions.session import add_note

if TYPE_CHECKING:
    from hapkit_studio.gui.live.live import Live
    from hapkit_studio.gui.studio import Studio

_NONE = "Nothing is recorded yet. Press Record (R), or keep what already happened (Ctrl+Shift+S)."
_READING = "Reading the sessions…"
_CHOOSE = "Choose a session."
COMMA = "Table, decimal comma (*.csv)"
TABLES = f"Table (*.csv);;{COMMA};;Parquet (*.parquet);;MATLAB (*.mat)"
_SEARCH, _NOTES = 260, 30  # px; letters of the notes in the table
_LONGEST = 200  # letters of a note
_CHART = 190  # px

_OTHERS, _MOST_OTHERS = "sessions_elsewhere", 10

Known = dict[tuple[Path, float, int], Overview]


def look(paths: list[Path], known: Known, progress: Progress) -> Known:
    """Return each file's overview by what tells that it is the same file still; read those not known."""
    found: Known = {}
    for done, path in enumerate(paths):
        progress(done, len(paths))
        try:
            stat = path.stat()
            key = path, stat.st_mtime, stat.st_size
            found[key] = known.get(key) or overview(path)
        except OSError:  # it went away meanwhile
            continue
    return found


def recent(settings: QSettings) -> list[Path]:
    """Return the sessions opened last from other folders, as far as they are still there."""
    kept = settings.value(_OTHERS, [])
    paths = [Path(path) for path in (kept if isinstance(kept, list) else [kept]) if isinstance(path, str)]
    return [path for path in paths if path.is_file()]


def export(path: Path, output: str, decimal: str) -> str:
    """Write a session as a table by the name's ending; return in words what was written."""
    from hapkit_studio import api  # late: keeps start-up fast

    run = api.open_session(path)
    try:
        run.save(output, decimal)
    except OSError as error:
        raise StudioError(f"{Path(output).name} cannot be written: {error.strerror}.") from error
    return f"Saved {Path(output).name}: {len(run.time):,} samples"


class SessionsPage(Page):
    """Search and list; below it where the handle was in the chosen session, beside it what happened."""

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
        self.search = QLineEdit(placeholderText="Search", clearButtonEnabled=True)
        self.search.setAccessibleName("Search")
        self.search.setToolTip("Names, environments, devices, notes; every word must be found")
        self.status, self.empty = hint(), hint(_READING)
        self.table = Table("Sessions", scrolls=True)
        self.chart = Drawing("Position over time", (_CHART, _CHART))
        self.side = SidePanel("Sessions", _CHOOSE)
        self.facts = Pairs()
        self.replay, self.export = primary(QPushButton("Replay")), QPushButton("Export…")
        self.note, self.delete = QPushButton("Note…"), QPushButton("Delete…")
        self.replay.setToolTip("Show it in the Live view, with the settings of then (Enter)")
        self._arrange()
        self._reading, self._saving, self._noting = self._jobs = [Job(self, needs="") for _ in range(3)]
        self._reading.finished.connect(self._take)
        self._saving.finished.connect(self.say)
        self._noting.finished.connect(self._show_noted)
        for job in self._jobs:
            job.failed.connect(partial(self.say, danger=True))
        self.search.textChanged.connect(lambda _text: self._list())
        self.table.chosen.connect(self.show_session)
        self.table.activated.connect(lambda index: self._replay(self.table.content.rows[index.row()]))
        self.replay.clicked.connect(lambda: self._replay(self.chosen))
        self.export.clicked.connect(self.ask_export)
        self.note.clicked.connect(self.ask_note)
        self.delete.clicked.connect(self.ask_delete)
        studio.hidden_changed.connect(lambda: self.show_session(self.chosen))
        studio.recording.changed.connect(self._notice)
        self.show_session(None)

    # what a person does

    def load(self) -> None:
        """Read what is in the folder now, in a thread; the file that is being written is left out."""
        progress, known = self._studio.recording.progress, self._known
        others = [path for path in self._others if path.parent != folder()]
        busy = progress.path if progress is not None else None

        def read(progress: Progress) -> Known:
            return look([path for path in (*files(), *others) if path != busy], known, progress)

        self._reading.start(read)

    def open_other(self, path: str) -> None:
        """List a session from anywhere, and choose it."""
        self._wanted = Path(path)
        self._others = [Path(path), *(other for other in self._others if other != Path(path))][:_MOST_OTHERS]
        self._settings.setValue(_OTHERS, [str(other) for other in self._others])
        self.search.clear()
        self.load()

    def show_session(self, found: Overview | None) -> None:
        """Show one session at a glance, None for none."""
        self.chosen = found
        self.side.heading.setText(found.path.stem if found else "Sessions")
        self.side.words.setText(_words(found) if found else _CHOOSE)
        self.facts.show_pairs(_pairs(found, self._titles) if found else [])
        self.happened.show_pairs(_story(found) if found else [])
        whole = found is not None and not found.error
        self.replay.setEnabled(whole and not self._studio.hidden)
        self.note.setEnabled(found is not None and not (found.error or found.damage))
        self.export.setEnabled(whole)
        self.delete.setEnabled(found is not None)
        self.chart.setVisible(whole)
        if found is not None and whole:
            self.chart.show_drawing(lambda figure, c: draw(figure, c, found.trace, found.markers))

    def _replay(self, found: Overview | None) -> None:
        if found is not None and not found.error:
            self._live.replay_wanted.emit(found.path)

    def ask_export(self) -> None:
        """Ask for a file's name beside the window, then write the chosen session as a table."""
        if self.chosen is None:
            return
        path = self.chosen.path

        def save(output: str) -> None:
            decimal = "," if dialog.selectedNameFilter() == COMMA else "."
            self.say(f"Exporting {path.stem}…")
            self._saving.start(lambda _progress: export(path, output, decimal))

        dialog = choose_file(self, "Export", TABLES, save, save_as=f"{path.stem}.csv")

    def ask_delete(self) -> None:
        """Ask, then move the chosen session to the system's bin."""
        if self.chosen is not None:
            DeleteDialog(self.chosen.path, lambda _path: self.load(), self.window()).show()

    def ask_note(self) -> None:
        """Ask for a line, then write it into the chosen session's file."""
        if self.chosen is None or self._noting.running:
            return
        path = self.chosen.path

        def add(text: str) -> None:
            def work(_progress: Progress) -> Path:
                add_note(path, text)
                return path

            if text:
                self.say(f"Adding a note to {path.stem}…")
                self._noting.start(work)

        WordsDialog("Note", f"About {path.stem}", _LONGEST, add, self.window()).show()

    def _show_noted(self, path: Path) -> None:
        self.say(f"Noted in {path.name}")
        self._known = {key: found for key, found in self._known.items() if key[0] != path}
        self.load()

    def say(self, text: str, danger: bool = False) -> None:
        """Show what was done, or what failed."""
        self.status.setText(text)
        self.status.show()
        mark(self.status, "role", "error" if danger else "hint")

    def set_shown(self, on: bool) -> None:
        if on:
            self.load()

    def end(self) -> None:
        for job in self._jobs:
            job.end()

    # the list

    @property
    def _titles(self) -> Callable[[str], str]:
        """Return what gives an environment's title by its key, the key where there is none."""
        known = self._studio.environments
        return lambda key: known[key].title if key in known else key

    def _notice(self) -> None:
        """Show a session that was just written, if the page is in sight."""
        newest = self._studio.recording.newest
        if newest != self._newest:
            self._newest = newest
            self._wanted = newest[0] if newest is not None else self._wanted
            if newest is not None and self.isVisible():
                self.load()

    def _take(self, found: Known) -> None:
        self._known = found
        self.empty.setText(_NONE)
        self._list()

    def _list(self) -> None:
        """List what the search finds, the newest first; choose what was chosen, else the first."""
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
        """Return all that is searched, in small letters."""
        named = row.path.stem, row.device, *map(self._titles, row.environments)
        return " ".join((*named, *_noted(row))).lower()

    def _arrange(self) -> None:
        other, reveal = (
            QPushButton("Open other…", autoDefault=True),
            QPushButton("Show folder", autoDefault=True),
        )
        kinds = f"Sessions (*{SUFFIX})"
        other.clicked.connect(lambda: choose_file(self, "Open a session", kinds, self.open_other))
        reveal.clicked.connect(self._reveal)
        self.search.setMaximumWidth(_SEARCH)
        card = QFrame()
        card.setProperty("card", True)
        bar = across((self.search, 1), None, other, reveal, margins=(12, 7, 12, 7), gap=10)
        for words in (self.status, self.empty):
            words.setContentsMargins(16, 8, 16, 8)
        self.status.hide()
        listed = across(self.table, margins=(10, 0, 10, 0))
        down(
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
        self.happened = Pairs(self.side.section("What happened"))
        self.side.add(self.happened)
        self.side.column.insertLayout(2, across(self.replay, self.export, None))
        self.side.column.insertLayout(3, across(self.note, self.delete, None))

    def _reveal(self) -> None:
        """Open the folder of the chosen session, without one that of all."""
        place = self.chosen.path.parent if self.chosen is not None else folder()
        if not QDesktopServices.openUrl(QUrl.fromLocalFile(str(place))):
            self.say(f"The sessions are in {place}.")


def columns(title: Callable[[str], str]) -> tuple[Column, ...]:
    """Return the list's columns; title gives an environment's."""

    def quiet(row: Overview) -> str:
        return "warn" if row.error or row.damage else "ink2"

    return (
        Column("Name", lambda row: row.path.stem, right=False),
        Column("Environment", lambda row: _some([title(key) for key in row.environments]), right=False),
        Column("Device", lambda row: row.device, right=False, token=quiet),
        Column("Notes", _notes, right=False, token=quiet),
        Column("Written", lambda row: _date(row.saved), lambda row: row.saved, quiet),
        Column("Length", lambda row: "" if row.error else clock(row.seconds), lambda row: row.seconds),
        Column("Size", lambda row: megabytes(row.size), lambda row: row.size, quiet),
    )


def _date(seconds: float) -> str:
    return f"{datetime.fromtimestamp(seconds):%Y-%m-%d %H:%M}"


def _some(titles: list[str]) -> str:
    """Name the first of several, and how many there are more."""
    return f"{titles[0]} + {len(titles) - 1}" if len(titles) > 1 else "".join(titles)


def _notes(row: Overview) -> str:
    if row.error or row.damage:
        return "Cannot be read" if row.error else "Damaged"
    words = ", ".join(_noted(row))
    return words if len(words) <= _NOTES else f"{words[: _NOTES - 1]}…"


def _noted(row: Overview) -> list[str]:
    """Return all that a person noted, on all of it first."""
    return [*row.notes, *(text for _, text in row.markers)]


def _words(found: Overview) -> str:
    return found.error or " ".join(found.damage) or f"{number(found.seconds, 1)} s, {found.samples:,} samples"


def _pairs(found: Overview, title: Callable[[str], str]) -> list[tuple[str, str]]:
    pairs = [
        ("Written", _date(found.saved)),
        ("Size", megabytes(found.size)),
        ("Folder", found.path.parent.name),
    ]
    if not found.error:
        pairs += [("Device", found.device), ("Environments", ", ".join(map(title, found.environments)))]
        pairs += [("Note", text) for text in found.notes]
    return pairs


def _story(found: Overview) -> list[tuple[str, str]]:
    """Return when something was set or noted, and what, in the order in which it came."""
    return [(f"{when:.2f} s", words) for when, words in sorted((*found.markers, *found.changes))]


VIEW = View("sessions", "Sessions", 60, SessionsPage, scene=False)
