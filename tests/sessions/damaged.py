"""Sessions with one value of a wrong type or size, whose row nevertheless has a correct checksum."""

import json
import math
import random
import sqlite3
import struct
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from hapkit_studio.sessions.file import TABLES, checksum

ESCAPES = "\x1b[2J\x1b]0;owned\x07\u202e\r\nnext"
NUMBERS = (0, -1, 2**31, 2**63 - 1, -(2**63), 0.5, -0.0, 1e308, -1e308, math.inf, -math.inf, math.nan)
WORDS = ("", "a", ESCAPES, "\ud800".encode("utf-8", "surrogatepass").decode("utf-8", "replace"), "9" * 5000)
IN_JSON: tuple[Any, ...] = (
    None, True, *NUMBERS, 10**400, *WORDS, [], [1], {}, {"": 1}, {"a": [{"b": None}]}, list(range(500)),
    {f"k{i}": i for i in range(500)},
)  # fmt: skip
BOMB = zlib.compress(bytes(4_000_000), 9)
HEAD = struct.Struct("<Bdq")


def mutate(path: Path, chance: random.Random) -> str:
    """Change one value of a session in place; return a description of the change."""
    kinds: tuple[Callable, ...] = (_json, _json, _json, _column, _column, _blob, _blob, _schema, _bytes)
    change = chance.choice(kinds)
    if change is _bytes:
        return _bytes(path, chance)
    with sqlite3.connect(path) as database:
        database.execute("PRAGMA synchronous=OFF")
        change_text = change(database, chance)
    database.close()
    return change_text


def set_value(path: Path, table: str, row: int, name: str, value: object) -> None:
    """Set a column of one row, and correct the row's checksum."""
    with sqlite3.connect(path) as database:
        _set(database, table, row, name, value)
    database.close()


def _set(database: sqlite3.Connection, table: str, row: int, name: str, value: object) -> None:
    database.execute(f"UPDATE {table} SET {name} = ? WHERE id = ?", (value, row))
    values = database.execute(
        f"SELECT {', '.join(TABLES[table])} FROM {table} WHERE id = ?", (row,)
    ).fetchone()
    database.execute(f"UPDATE {table} SET crc = ? WHERE id = ?", (checksum(values), row))


def _row(database: sqlite3.Connection, table: str, chance: random.Random) -> int:
    rows = [row for (row,) in database.execute(f"SELECT id FROM {table}")]
    return chance.choice(rows)


def _json(database: sqlite3.Connection, chance: random.Random) -> str:
    """Change one value in an event at any depth, or add a value."""
    row = _row(database, "event", chance)
    (text,) = database.execute("SELECT what FROM event WHERE id = ?", (row,)).fetchone()
    what, new = json.loads(text), chance.choice(IN_JSON)
    places = [((), what), *_places(what)]
    place, _ = chance.choice(places)
    if chance.random() < 0.05:
        text = chance.choice(
            ["[" * 50_000, "{" * 9, text[:-1], '{"a": ' + "9" * 9_000 + "}", " " * 70_000, text * 2]
        )
        place = ("text",)
    else:
        text = json.dumps(_replaced(what, place, new))
    _set(database, "event", row, "what", text)
    return f"event {row}, {'.'.join(map(str, place))} = {text[:60]}"


def _places(value: Any, at: tuple = ()) -> list[tuple[tuple, Any]]:
    """Return every location in a JSON value, with its content."""
    pairs = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    found = []
    for key, one in pairs:
        found += [((*at, key), one), *_places(one, (*at, key))]
    return found


def _replaced(value: Any, place: tuple, new: Any) -> Any:
    if not place:
        return new
    copied = dict(value) if isinstance(value, dict) else list(value)
    copied[place[0]] = _replaced(value[place[0]], place[1:], new)
    return copied


def _column(database: sqlite3.Connection, chance: random.Random) -> str:
    """Set a column of a row to a value of any type and size."""
    table = chance.choice(list(TABLES))
    row, name = _row(database, table, chance), chance.choice(list(TABLES[table]))
    finite = [number for number in NUMBERS if number == number]
    value = chance.choice([None, *finite, *WORDS, b"", b"\0" * 100, BOMB, bytes(200_000)])
    _set(database, table, row, name, value)
    return f"{table} {row}, {name} = {value!r:.40}"


def _blob(database: sqlite3.Connection, chance: random.Random) -> str:
    """Change the head, the length or a number of a compressed column."""
    row = _row(database, "chunk", chance)
    name = chance.choice([name for name, kind in TABLES["chunk"].items() if kind == "BLOB"])
    (count,) = database.execute("SELECT count FROM chunk WHERE id = ?", (row,)).fetchone()
    head = HEAD.pack(
        chance.choice([0, 1, 2, 4, 8, 3, 255]),
        chance.choice([1.0, 1e-6, *map(float, NUMBERS)]),
        chance.choice([0, 1, 2**63 - 1, -(2**63)]),
    )
    body = chance.choice([bytes, lambda n: b"\xff" * n, chance.randbytes])(
        chance.choice([0, 1, 4, 8]) * count
    )
    data = zlib.compress(head + body)
    data = data if chance.random() < 0.8 else data[: chance.randrange(len(data))]
    _set(database, "chunk", row, name, data)
    return f"chunk {row}, {name} = {head.hex()}, {len(body)} bytes"


def _schema(database: sqlite3.Connection, chance: random.Random) -> str:
    statement = chance.choice(
        [
            "CREATE TRIGGER t AFTER INSERT ON event BEGIN DELETE FROM chunk; END",
            "CREATE VIEW v AS SELECT load_extension('x')",
            "CREATE TABLE more (a DEFAULT (randomblob(1000000000)))",
            "CREATE INDEX i ON chunk (start)",
            "DROP TABLE chunk",
            "DELETE FROM chunk",
            "DELETE FROM event",
            "DELETE FROM signal",
            "PRAGMA user_version = 1",
            "PRAGMA user_version = 3",
            "PRAGMA user_version = -1",
            "PRAGMA application_id = 1",
        ]
    )
    database.execute(statement)
    return statement


def _bytes(path: Path, chance: random.Random) -> str:
    data = bytearray(path.read_bytes())
    if chance.random() < 0.3:
        path.write_bytes(data[: chance.randrange(len(data))])
        return "cut off"
    for _ in range(chance.choice([1, 10, 100])):
        data[chance.randrange(len(data))] = chance.randrange(256)
    path.write_bytes(data)
    return "other bytes"
