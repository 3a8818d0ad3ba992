"""The command for recorded sessions: list, show, export, check, repair, rename, and choose their folder."""

import argparse
import math
import os
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

from hapkit_studio import api
from hapkit_studio import environments as library
from hapkit_studio.columns import Column, text_lines
from hapkit_studio.commands.base import Command, Result, option, with_files
from hapkit_studio.errors import ParameterError
from hapkit_studio.formatting import plain
from hapkit_studio.sessions.export import DECIMALS, WRITERS
from hapkit_studio.sessions.file import ABOUT, MARKER, SETTINGS, SUFFIX
from hapkit_studio.sessions.folder import choose_folder, chosen_folder, folder, rename
from hapkit_studio.sessions.overview import Overview, columns, overview
from hapkit_studio.sessions.session import Session
from hapkit_studio.sessions.settings_events import changes

DAMAGED = 2
"""Exit code if a session has lost data."""


def _list(options: argparse.Namespace) -> Result:
    place = Path(options.path or ".")
    if not os.path.isdir(place):
        raise ParameterError(f"sessions list takes a folder, not {options.path}.")
    rows, found = [], []
    for path in sorted(place.glob(f"*{SUFFIX}")):
        try:
            row = overview(path)
        except OSError:  # the file was deleted after the listing
            continue
        rows.append(row)
        if row.error:
            found.append({"path": str(path), "error": row.error})
        else:
            with closing(Session(path)) as session:
                found.append(_facts(session))
    remarks = Column("Remarks", lambda row: row.error or ". ".join(_remarks(row)), right=False)
    lines = text_lines((*columns(_title), remarks), rows) if rows else [f"No sessions in {place}."]
    return Result("\n".join(lines), {"sessions": found})


def _title(key: str) -> str:
    found = library.discover().get(key)
    return found.title if found else key


def _show(options: argparse.Namespace) -> Result:
    with closing(Session(_named(options))) as session:
        start, stop = session.starts[0], session.stops[-1]
        about = [f"{name.replace('_', ' ')}: {value}" for name, value in session.latest(ABOUT).items()]
        changed = changes(session.events, start, stop)
        notes = [f"note: {text}" for text in session.notes]
        marks = [e for e in session.events if e.kind == MARKER]
        notes += [f"At {mark.time - start:.2f} s: {mark.what['text']}" for mark in marks]
        lines = [_line(session), *about, *notes, *changed, *_remarks(session)]
        return Result("\n".join(lines), _facts(session))


def _export(options: argparse.Namespace) -> Result:
    path = _named(options)
    run = api.open_session(path, options.start, options.stop)
    output = options.output or str(path.with_suffix(".csv"))
    if Path(output).exists():
        raise ParameterError(f"{output} exists already: choose another file with --output.")
    run.save(output, options.decimal)
    lines = [f"{len(run.time):,} samples", *run.warnings]
    return with_files("\n".join(lines), {"samples": len(run.time), "warnings": list(run.warnings)}, [output])


def _check(options: argparse.Namespace) -> Result:
    with closing(Session(_named(options))) as session:
        damage = session.check()
        remarks = _remarks(session) if damage else ["Nothing is damaged.", *_remarks(session)]
        return Result("\n".join([_line(session), *remarks]), _facts(session), DAMAGED if damage else 0)


def _repair(options: argparse.Namespace) -> Result:
    path = _named(options)
    output = options.output or str(path.with_stem(f"{path.stem}-repaired"))
    with closing(Session(path)) as session:
        damage = session.repair(output)
    return with_files("\n".join(damage or ("Nothing is damaged.",)), {"damage": list(damage)}, [output])


def _rename(options: argparse.Namespace) -> Result:
    path = _named(options)
    if options.name is None:
        raise ParameterError("sessions rename takes a session and its new name: sessions rename FILE NAME.")
    renamed = rename(path, options.name)
    return Result(f"{path.name} is now {renamed.name}.", {"path": str(renamed)})


def _where(options: argparse.Namespace) -> Result:
    """Print the folder into which the window records, or choose a different folder."""
    if options.path is not None:
        choose_folder(Path(options.path))
    chosen_folder()  # raise an error if the stored choice cannot be read
    return Result(str(folder()), {"folder": str(folder())})


ACTIONS: dict[str, Callable[[argparse.Namespace], Result]] = {
    "list": _list,
    "show": _show,
    "export": _export,
    "check": _check,
    "repair": _repair,
    "rename": _rename,
    "where": _where,
}


def _named(options: argparse.Namespace) -> Path:
    if options.path is None:
        raise ParameterError(f"sessions {options.action} takes a session: name its file.")
    return Path(options.path)


def _line(session: Session) -> str:
    settings = session.latest(SETTINGS)
    rate = f"{settings.get('rate_Hz', 0.0):,g} Hz"
    parts = [f"{session.seconds:,.1f} s", f"{session.counts.sum():,} samples", rate]
    parts += [settings.get("environment", ""), session.latest(ABOUT).get("device", "")]
    return ", ".join(word for word in parts if word)


def _remarks(session: Session | Overview) -> list[str]:
    """Return the damage found, and how to repair a recording that was not finished."""
    return [*session.damage, *([session.unfinished] if session.unfinished else [])]


def _facts(session: Session) -> dict:
    return {
        "path": str(session.path),
        "complete": session.complete,
        "damage": list(session.damage),
        "seconds": session.seconds,
        "samples": int(session.counts.sum()),
        "bytes": session.path.stat().st_size,
        "notes": session.notes,
        "about": plain(session.latest(ABOUT)),
        "settings": plain(session.latest(SETTINGS)),
    }


def run(options: argparse.Namespace) -> Result:
    """Run one of ACTIONS; raise StudioError if it fails."""
    if options.name is not None and options.action != "rename":
        raise ParameterError(f"sessions {options.action} takes one path, not {options.name!r} as well.")
    return ACTIONS[options.action](options)


OPTIONS = (
    option("action", choices=tuple(ACTIONS)),
    option("path", nargs="?", help="a session; for list a folder; for where the folder to record into"),
    option("name", nargs="?", help="the new name, for rename"),
    option(
        "--output", metavar="PATH", help=f"of export ({', '.join(WRITERS)}) or repair; never an existing file"
    ),
    option(
        "--from",
        dest="start",
        type=float,
        default=0.0,
        metavar="s",
        help="start of the export, from the session's start",
    ),
    option("--to", dest="stop", type=float, default=math.inf, metavar="s", help="end of the export"),
    option("--decimal", choices=DECIMALS, default=".", help="the decimal mark in a CSV"),
)
COMMAND = Command(
    "sessions", "list, show, export, check, repair or rename recorded sessions", run, OPTIONS, 15
)
