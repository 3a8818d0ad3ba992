"""A generator of foreign files of every kind that the studio reads; a few values have another type or size.

Each file is determined by its kind and a seed. A changed SQLite row gets a new checksum, so that the studio
has to check the values themselves.
"""

import json
import random
import re
import sqlite3
from collections.abc import Callable, Iterator
from contextlib import closing, suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hapkit_studio as hs
from hapkit_studio import resources
from hapkit_studio.analysis import pointing, survey
from hapkit_studio.analysis.survey import Axes
from hapkit_studio.devices import calibration_file, profiles
from hapkit_studio.environments import discover
from hapkit_studio.gui.state import presets
from hapkit_studio.haptics import rows
from hapkit_studio.lessons import experiments, library, review
from hapkit_studio.lessons.hand_in import save_played
from hapkit_studio.lessons.play import play_lesson
from hapkit_studio.sessions.chunk import pack
from hapkit_studio.sessions.file import (
    ABOUT,
    FAULT,
    MARKER,
    NOTE,
    SETTINGS,
    STOP,
    Event,
    SessionWriter,
    checksum,
)
from tests.analysis.sweep_tasks import Serial

HIDDEN = "\x1b[31mred\x9b2J\x07\u202e"
"""A name with escape sequences, a bell, and a change of text direction."""
LONG = "a" * 70_000
DEEP = 5000
AXES = Axes(
    ("difference", "kalman"), (500.0, 2000.0), (0.0, 1e-3), ((0.0, 0.0, 0.0), (0.05, 4.0, 200.0)), (0.0, 1.5)
)
_NUMBERS = (
    *[
        "0",
        "-1",
        "1",
        "0.5",
        "2",
        "7",
        "127",
        "128",
        "255",
        "256",
        "300",
        "65535",
        "65536",
        "70000",
        "2147483648",
        "-2147483649",
        "99999999999",
    ],
    *["18446744073709551616", "1e-320", "1e39", "1e308", "-1e308"],
)
_HUGE = "9" * 400, "9" * 5000
_TEXTS = ("", " ", "x", "wall", "1", "Zoë 7", "../../x", "/dev/zero", "%s%n{0}", "=1+1", HIDDEN)
_OF_BOTH = (*_NUMBERS, *_HUGE, *map(json.dumps, (*_TEXTS, LONG)), "true", "false", "1e999", "[]", "[1]", "{}")
_OF_BOTH += ("[" * 40 + "]" * 40, "[" * DEEP, "[" * DEEP + "]" * DEEP)
JSON_VALUES = (
    *_OF_BOTH, "null", "NaN", "-Infinity", '"\\ud800"', "[null]", '["a", "b"]', "[[]]", '{"a": 1}',
    '{"": null}', '{"a":' * DEEP,
)  # fmt: skip
TOML_VALUES = (
    *_OF_BOTH, "nan", "-inf", "0x" + "f" * 60, "0x" + "f" * 9000, "[[1, 2]]", '["a", 1]', "{a = 1}",
    "1979-05-27", "{a.b.c = 1}", "07:32:00", "'''\n'''", "{a = " * DEEP, "{a" + ".a" * 20_000 + " = 1}",
)  # fmt: skip
SQL_VALUES = (
    None, 0, 1, -1, -5, 255, 2**31, 2**63 - 1, -(2**63), 0.5, -1.0, 1e308, float("inf"), *_TEXTS, LONG,
    b"", b"x", b"\xff" * 10, bytes(100_000),
)  # fmt: skip
INI_VALUES = (
    *_NUMBERS, *_TEXTS[1:], LONG, "purple", "true", "a, b", "@Invalid()", "@ByteArray()", "@Rect(x)",
    "@Size(1 1)", "@ByteArray(\\x1\\xd9\\xd0\\xcb)", "@Rect(0 0 99999999 -5)",
    "@Variant(\\0\\0\\0\\x7f\\0\\0)", "@Variant(\\0\\0\\0\\t\\xff)",
)  # fmt: skip
CSV_VALUES = (
    *_NUMBERS, *_HUGE, *_TEXTS, "nan", "inf", "1e999", "true", '"', '"1', "1,5", "1;5", "1\t5", "\0", "0x10",
)  # fmt: skip


def literal_in_json(text: str, rng: random.Random) -> str:
    """Return a JSON text with one value, key or member replaced; raise ValueError for other text."""
    try:
        tree = json.loads(text)
    except RecursionError:
        raise ValueError from None
    places = [place for place in _places(tree) if place]
    place = rng.choice(places or [()])
    if not place:
        return rng.choice(JSON_VALUES)
    *above, last = place
    parent = tree
    for key in above:
        parent = parent[key]
    kind = rng.randrange(8)
    if kind == 0:
        del parent[last]
    elif kind == 1 and isinstance(parent, dict):
        parent[rng.choice(_TEXTS)] = parent.pop(last)
    else:
        parent[last] = _MARK
    return json.dumps(tree).replace(json.dumps(_MARK), rng.choice(JSON_VALUES))


_MARK = "the value that is replaced"


def mutated_json(text: str, rng: random.Random) -> str:
    """Return a JSON text with one value replaced, or an unchanged text if it is not valid JSON."""
    try:
        return literal_in_json(text, rng)
    except ValueError:
        return text


def _places(tree: Any) -> Iterator[tuple]:
    yield ()
    items = tree.items() if isinstance(tree, dict) else enumerate(tree) if isinstance(tree, list) else ()
    for key, part in items:
        yield from ((key, *place) for place in _places(part))


_TOKEN = re.compile(r"""-?[\w.+]+|"[^"\n]*"|'[^'\n]*'|\[.*\]|\{.*\}""")


def mutated_toml(text: str, rng: random.Random) -> str:
    """Return a TOML text with one value, key or table header replaced."""
    lines = text.split("\n")
    whole = [at for at, line in enumerate(lines) if line.strip() and not line.startswith("#")]
    at, value = rng.choice(whole), rng.choice(TOML_VALUES)
    name, equals, rest = lines[at].partition("=")
    if not equals:  # the line is a table header, or within a list
        lines[at] = rng.choice((f"x = {value}", "[[values]]", "[a.b]", f"[{json.dumps(HIDDEN)}]", ""))
    elif rng.random() < 0.15:
        lines[at] = rng.choice(
            (
                "",
                f"{json.dumps(rng.choice(_TEXTS))} ={rest}",
                f"a.{name}={rest}",
                lines[at] + "\n" + lines[at],
            )
        )
    else:
        parts = list(_TOKEN.finditer(rest.split("  #")[0]))
        inner = [
            part
            for found in parts
            if found[0][0] in "[{"
            for part in re.finditer(r"-?[\d.]+|\"[^\"]*\"", found[0])
        ]
        if inner and rng.random() < 0.6:
            part, first = rng.choice(inner), parts[0].start()
            rest = rest[: first + part.start()] + value + rest[first + part.end() :]
            lines[at] = f"{name}={rest}"
        else:
            lines[at] = f"{name}= {value}"
    return "\n".join(lines)


def mutated_csv(text: str, rng: random.Random) -> str:
    """Return a table with one value of its header, one name or one cell replaced."""
    lines = text.split("\n")
    comments = [at for at, line in enumerate(lines) if line.startswith("#")]
    data = len(comments) + 1
    kind = rng.randrange(4)
    if kind < 2 and comments:
        at = rng.choice(comments)
        try:
            lines[at] = "# " + literal_in_json(lines[at][1:], rng)
        except ValueError:  # the comment is not JSON, but a name and a value
            name, _, _ = lines[at].partition(":")
            lines[at] = f"{name}: {rng.choice(JSON_VALUES + CSV_VALUES)}"
    else:
        at = data - 1 if kind == 2 else rng.randrange(data, len(lines) - 1)
        cells = lines[at].split(",")
        if rng.random() < 0.2:
            cells = rng.choice((cells[:-1], [*cells, "1"], [], cells[:1] * 5000))
        else:
            cells[rng.randrange(len(cells))] = rng.choice(CSV_VALUES)
        lines[at] = ",".join(cells)
    return "\n".join(lines)


def mutated_ini(text: str, rng: random.Random) -> str:
    """Return the window's settings with one value replaced; of JSON, usually only a part is replaced."""
    lines = text.split("\n")
    at = rng.choice([at for at, line in enumerate(lines) if "=" in line])
    name, _, value = lines[at].partition("=")
    if value.startswith('"{') and rng.random() < 0.7:
        with suppress(ValueError):  # an earlier change may have damaged the JSON
            lines[at] = f'{name}="{_ini_quoted(literal_in_json(json.loads(value), rng))}"'
    else:
        value = rng.choice(INI_VALUES)
        lines[at] = f"{name}={value}" if value.startswith("@") else f'{name}="{_ini_quoted(value)}"'
    return "\n".join(lines)


def _ini_quoted(text: str) -> str:
    """Return a text in the quoted form of a Qt INI file."""
    plain = text.replace("\\", "\\\\").replace('"', '\\"')
    return "".join(c if " " <= c <= "~" else f"\\x{ord(c):x}" for c in plain)


def mutate_sqlite(path: Path, rng: random.Random) -> None:
    """Replace one value, or the row number, of one row of a database."""
    with closing(sqlite3.connect(path)) as database, database:
        tables = [name for (name,) in database.execute("SELECT name FROM sqlite_master WHERE type = 'table'")]
        table = rng.choice(tables)
        columns = [name for _, name, *_ in database.execute(f"PRAGMA table_info({table})")]
        row, values = _row(database, table, columns, rng)
        key = columns[0] if columns[0] in ("id", "row") else "rowid"
        at = rng.randrange(len(columns))
        if isinstance(values[at], str) and values[at].startswith(("[", "{")) and rng.random() < 0.8:
            with suppress(ValueError):  # an earlier change may have damaged the JSON
                values[at] = literal_in_json(values[at], rng)
        elif isinstance(values[at], bytes) and rng.random() < 0.3:
            values[at] = values[at][: rng.randrange(len(values[at]) + 1)] + rng.randbytes(rng.randrange(9))
        elif columns[at] == key:
            values[at] = rng.choice((-5, 0, 10**6, 2**63 - 1))
        else:
            values[at] = rng.choice(SQL_VALUES)
        try:
            database.execute(f"UPDATE {table} SET {columns[at]} = ? WHERE {key} = ?", (values[at], row))
        except (sqlite3.IntegrityError, sqlite3.OperationalError, UnicodeEncodeError):
            database.execute(f"DELETE FROM {table} WHERE {key} = ?", (row,))
        if "crc" in columns and columns[at] not in ("crc", key):
            # the checksum needs values as SQLite returns them: an integer in a REAL column is a float
            inner = ", ".join(columns[1:-1])
            for stored in database.execute(f"SELECT {inner} FROM {table} WHERE {key} = ?", (row,)).fetchall():
                database.execute(f"UPDATE {table} SET crc = ? WHERE {key} = ?", (checksum(stored), row))


def _row(
    database: sqlite3.Connection, table: str, columns: list[str], rng: random.Random
) -> tuple[int, list]:
    found = database.execute(f"SELECT rowid, {', '.join(columns)} FROM {table}").fetchall()
    row, *values = rng.choice(found or [(0, *[None] * len(columns))])
    return row, values


def truncated(data: bytes, rng: random.Random) -> bytes:
    return data[: rng.randrange(len(data))]


WHOLE: tuple[Callable[[bytes, random.Random], bytes], ...] = (
    truncated,
    lambda _data, rng: rng.randbytes(rng.randrange(2000)),
    lambda _data, _rng: b"",
    lambda data, _rng: b"\xef\xbb\xbf" + data,
    lambda data, _rng: data.replace(b"\n", b"\r\n"),
    lambda data, _rng: data.decode("latin-1").encode("utf-16"),
    lambda data, _rng: data + b"\xff\xfe",
    lambda data, rng: data[: (at := rng.randrange(len(data)))] + b"\0" + data[at:],
)
"""Functions that change a whole file."""
_SPARSE = 3 << 30  # bytes
_MOST_CHANGES = 3
_WHOLE_SHARE, _SPARSE_SHARE = 0.08, 0.02
TEXTS = {
    "settings": mutated_ini, "preset": mutated_toml, "demo": mutated_toml, "calibration": mutated_toml,
    "lesson": mutated_toml, "csv": mutated_csv, "review": mutated_json,
}  # fmt: skip
SUFFIXES = {
    "settings": ".conf", "session": ".hapkit", "preset": ".toml", "demo": ".toml", "calibration": ".toml",
    "csv": ".csv", "survey": ".survey", "lesson": ".md", "handed in": ".hapkit",
    "review": ".review", "experiment": ".hapkit",
}  # fmt: skip
COUNTS = {kind: {"settings": 140, "handed in": 60}.get(kind, 310) for kind in SUFFIXES}
"""Number of files of each kind: each settings file opens a window, and each handed-in file is drawn."""
FEW = range(1, 4)
"""Seeds of the files in quick tests."""
NAMES = ("mutant", "a file of someone else's", "\x1b[31mred\x07", "Zoë−\u202e", "-p", "100 %s")
"""Names of files without suffix."""


def write(kind: str, seed: int, original: bytes, folder: Path) -> Path:
    """Write the file of a kind and a seed into a folder; return its path."""
    rng = random.Random(f"{kind} {seed}")
    name = NAMES[0] if rng.random() < 0.8 else rng.choice(NAMES)
    path = folder / f"{name}{SUFFIXES[kind]}"
    path.write_bytes(original)
    share = rng.random()
    if share < _SPARSE_SHARE:
        with open(path, "r+b") as file:
            file.truncate(_SPARSE)
    elif share < _SPARSE_SHARE + _WHOLE_SHARE:
        path.write_bytes(rng.choice(WHOLE)(original, rng))
    elif kind in TEXTS:
        text = original.decode()
        for _ in range(rng.randint(1, _MOST_CHANGES)):
            text = TEXTS[kind](text, rng) if len(text) < len(original) + 100_000 else text
        path.write_bytes(text.encode("utf-8", "surrogatepass"))
    else:
        for _ in range(rng.randint(1, _MOST_CHANGES)):
            mutate_sqlite(path, rng)
    return path


# --- valid files, which are changed


def _preset(folder: Path) -> Path:
    environment = discover()["wall"]
    settings = {("value", "wall", name): value for name, value in environment.values().items()}
    settings |= {
        ("loop", "rate"): 2000.0,
        ("loop", "delay"): 0.001,
        ("loop", "estimator"): ("iir", {"cutoff": 20.0}),
    }
    settings |= {
        ("loop", "controller"): True,
        ("loop", "model"): "everything",
    }
    return presets.write(environment, "good", {**settings, ("loop", "hand"): "firm"})


def _session(folder: Path) -> Path:
    path, count = folder / "good.hapkit", 600
    table = np.zeros((count, rows.ROW_WIDTH))
    table[:, rows.TICK], table[:, rows.HOST_TIME] = np.arange(count), 100.0 + 1e-3 * np.arange(count)
    table[:, rows.BOARD_TIME] = table[:, rows.HOST_TIME]
    table[:, rows.POSITION] = 0.01 * np.sin(0.05 * np.arange(count))
    table[:, rows.FORCE] = table[:, rows.APPLIED_FORCE] = -100.0 * table[:, rows.POSITION]
    settings = {
        "environment": "wall", "parameters": {"stiffness": 300.0, "damping": 0.0, "side": "right"},
        "units": {"stiffness": "N/m", "damping": "N·s/m"}, "state_names": [], "hand": "own", "grip": "medium",
        "render": "computer", "rate_Hz": 1000.0, "delay_s": 0.0, "estimator": ["iir", {"cutoff": 20.0}],
        "controller": False, "max_force_N": 3.0,
        "device": {"mass": 0.044, "damping": 0.5, "coulomb_force": 0.1},
    }  # fmt: skip
    writer = SessionWriter(path)
    writer.note(Event(95.0, ABOUT, {"device": "Simulated Hapkit", "quantum_m": 2e-5, "studio": "1.0"}))
    writer.note(Event(99.0, SETTINGS, settings))
    writer.note(Event(100.2, SETTINGS, {**settings, "rate_Hz": 2000.0}))
    writer.note(Event(100.25, MARKER, {"text": "a quarter"}))
    writer.note(Event(100.3, STOP, {"stopped": True}))
    writer.note(Event(100.4, FAULT, {"text": "No sensor reading arrived for 20 ms."}))
    for first in range(0, count, 300):
        writer.add(pack(table[first : first + 300], 2e-5, 0))
    writer.note(Event(100.599, NOTE, {"text": "seen"}))
    writer.close()
    return path


def _handed_in(folder: Path) -> Path:
    path, lesson = folder / "handed.hapkit", library().lessons["first_touch"]
    save_played(path, lesson, play_lesson(lesson), "Ada")
    return path


def _review(folder: Path) -> Path:
    path = folder / "good.review"
    rows = review.Row("Clear", 3, 2, "yes"), review.Row("Complete", 4)
    comments = review.Comment("why?", time=1.5), review.Comment("good", step=2), review.Comment("well done")
    review.write(path, review.Review("a.hapkit", "0" * 64, "first_touch", "Bob", rows, comments, ("thanks",)))
    return path


def _experiment(folder: Path) -> Path:
    path, targets = folder / "pointing.hapkit", pointing.plan(distances=(0.02,), rounds=1, seed=0)
    experiments.save_pointing(path, pointing.Subject(), targets, seed=0)
    return path


def _csv(folder: Path) -> Path:
    path = folder / "good.csv"
    hs.simulate("wall", {"stiffness": 300.0}, hand="press", seconds=0.15).save(str(path))
    return path


def _survey(folder: Path) -> Path:
    path = folder / "good.survey"
    survey.compute(path, AXES, Serial())
    return path


_SETTINGS = {
    "environment": "wall", "view": "live", "theme": "dark", "grid": "true", "single_keys": "true",
    "padding": "0", "dragged": "true", "loop_folded": "true", "loop_more": "false", "panel_width": "300.5",
    "gallery_width": "200", "scene_height": "240", "phase_width": "400",
    "sessions_elsewhere": "/nowhere/x.hapkit", "frameless": "@Rect(10 10 1280 720)",
    "geometry": "@ByteArray(\\x1\\xd9\\xd0\\xcb\\0\\x3\\0\\0\\0\\0\\0\\n\\0\\0\\0\\n)",
}  # fmt: skip
_JSON_SETTINGS = {
    "values": {"wall": {"stiffness": 300.0, "damping": 1.0, "side": "left"}, "cat": {}, "spring": {}},
    "loop": {
        "rate": 2000.0, "delay": 0.001, "estimator": "iir", "options": {"cutoff": 20.0}, "controller": True,
        "model": "everything", "where": "computer", "board_rate": 500.0, "grip": "firm",
    },
    "presets": {"wall": "good"},
    "trigger": {"event": "force", "force": -2.0, "edge": "rising", "again": "single", "before": 20.0},
    "lock": {"places": [["loop"], ["value", "wall", "stiffness"]], "salt": "0" * 32, "digest": "f" * 128},
}  # fmt: skip


def _settings(folder: Path) -> Path:
    path = folder / "good.conf"
    values = {name: f'"{_ini_quoted(json.dumps(value))}"' for name, value in _JSON_SETTINGS.items()}
    lines = [f"{name}={value}" for name, value in (_SETTINGS | values).items()]
    path.write_text("\n".join(["[General]", *lines, "", "[projected]", "wall=stiffness damping", ""]))
    return path


ORIGINALS: dict[str, Callable[[Path], Path]] = {
    "settings": _settings,
    "session": _session,
    "preset": _preset,
    "demo": lambda _folder: resources.path("demos", "buzzing_wall.toml"),
    "calibration": lambda _folder: calibration_file.write(profiles.default().board, {}),
    "csv": _csv,
    "survey": _survey,
    "lesson": lambda _folder: resources.path("templates", "lesson.md"),
    "handed in": _handed_in,
    "review": _review,
    "experiment": _experiment,
}
"""Functions that write a valid file of each kind into a folder, or into the user's own folder."""


def originals(folder: Path) -> dict[str, bytes]:
    """Write a valid file of each kind into an empty folder; return the bytes by kind."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(calibration_file.VARIABLE, str(folder))
        return {kind: make(folder).read_bytes() for kind, make in ORIGINALS.items()}
