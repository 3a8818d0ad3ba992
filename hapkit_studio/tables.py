"""Reads tables of samples from text files that the studio or other programs have written.

Delimiter and decimal sign are detected from the rows; UTF-8, UTF-16 and Windows code pages are supported.
Columns are chosen by name and converted to SI by their unit.
"""

import codecs
import csv
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path

import numpy as np

from hapkit_studio.errors import FileError, ParameterError
from hapkit_studio.files import read_bytes
from hapkit_studio.formatting import printable, quoted, shortened

MOST_BYTES = 256 << 20  # maximum number of bytes: ten minutes of the studio's own columns at 4 kHz
DELIMITERS = (";", "\t", ",", "|", " ")
"""The possible delimiters in order of preference."""
UNITS: dict[str, dict[str, float]] = {
    "time": {"s": 1.0, "ms": 1e-3, "µs": 1e-6, "us": 1e-6, "min": 60.0},
    "position": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "µm": 1e-6, "um": 1e-6},
    "velocity": {"m/s": 1.0, "cm/s": 1e-2, "mm/s": 1e-3},
    "force": {"N": 1.0, "mN": 1e-3},
}
"""The possible units of each quantity, with their values in SI."""
NEEDED = ("time", "position", "force")
"""The required quantities; a missing velocity is computed from the positions."""

_DIALECT_LINES = 200  # maximum number of lines that are used to detect the dialect
_LONGEST_LINE = 65_536  # maximum number of characters in a line
_PREVIEW_ROWS = 4  # number of rows in a preview
_LISTED_COLUMNS = 12  # maximum number of columns that a message lists
_PADDING = "".join(DELIMITERS)
_BLANK_CHARACTERS = _PADDING + '"'  # a line is empty if it has only these characters
_NUMBER = re.compile(r"[-+]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:e[-+]?\d+)?|[-+]?(?:inf|nan)", re.I)
_MARKS = {
    codecs.BOM_UTF8: "utf-8-sig", codecs.BOM_UTF16_LE: "utf-16", codecs.BOM_UTF16_BE: "utf-16",
}  # fmt: skip
# prefixes of a column's name in lower case, by quantity
_NAME_PREFIXES = {
    "velocity": ("velocity", "vel", "speed", "dx", "v"),
    "time": ("time", "timestamp", "zeit", "t"),
    "position": ("position", "pos", "displacement", "weg", "x"),
    "force": ("force", "kraft", "f"),
}
_MORE_UNITS = {"mms": "mm/s", "mm_s": "mm/s", "m_s": "m/s", "ms-1": "m/s", "sec": "s", "seconds": "s"}


@dataclass(frozen=True)
class TableColumn:
    """A column's name in the file, and the unit of its numbers."""

    name: str
    unit: str

    def __str__(self) -> str:
        return f"{self.name}:{self.unit}"


TableColumns = Mapping[str, TableColumn]
"""The columns by quantity; the quantities are the keys of UNITS."""


def parse_column(quantity: str, text: str) -> TableColumn:
    """Return the column that a text NAME:UNIT describes; raise ParameterError for any other text."""
    name, colon, unit = text.rpartition(":")
    unit = unit.strip()
    if not colon or not name or unit not in UNITS[quantity]:
        known = ", ".join(UNITS[quantity])
        raise ParameterError(
            f"The column of the {quantity} is NAME:UNIT, the unit one of {known}, not {quoted(text)}."
        )
    return TableColumn(name.strip(), unit)


class UnknownColumnsError(FileError):
    """Raised if the studio does not know a file's columns, so that the user must name them.

    ``table`` is the file's table.
    """

    def __init__(self, table: "Table", missing: str):
        found = guess(table.names)
        columns = {quantity: f"{shortened(column.name)}:{column.unit}" for quantity, column in found.items()}
        like = " ".join(f"--{quantity} {columns.get(quantity, 'NAME:UNIT')}" for quantity in NEEDED)
        more = ["…"][: len(table.names) - _LISTED_COLUMNS]
        names = ", ".join([*map(shortened, table.names[:_LISTED_COLUMNS]), *more])
        super().__init__(
            f"{table.file} has no column {shortened(missing)}. "
            f"Name its columns and units, as {like}. It has: {names}."
        )
        self.table = table


@dataclass(frozen=True)
class Table:
    """Rows of numbers under column names; ``comments`` are the lines before them, without "#"."""

    file: str
    names: tuple[str, ...]
    comments: tuple[str, ...]
    delimiter: str
    decimal: str
    first: int
    """Line number of the first row."""
    lines: list[str] = field(repr=False)
    """All lines of the file from the first row on."""

    @property
    def preview(self) -> list[list[str]]:
        """Return the cells of the first rows."""
        return [_cells(line, self.delimiter) for _, line in islice(self._rows(), _PREVIEW_ROWS)]

    def line_of(self, row: int) -> int:
        """Return the line number of a row of ``values``."""
        return next(islice((number for number, _ in self._rows()), row, None))

    def values(self, names: Sequence[str]) -> np.ndarray:
        """Return the numbers (n, len(names)) of some columns; raise FileError for an invalid cell."""
        for name in names:
            if self.names.count(name) > 1:
                raise FileError(f"{self.file} has {self.names.count(name)} columns {shortened(name)}.")
        places = [self.names.index(name) for name in names]
        rows, delimiter = [line for _, line in self._rows()], self.delimiter
        if self.decimal == ",":
            if any("." in line for line in rows) and (error := self._cell_error(places)):
                raise error
            if delimiter == ",":  # the numbers must be in quotes
                rows, delimiter = [";".join(_cells(line, ",")) for line in rows], ";"
            rows = [line.replace(",", ".") for line in rows]
        try:
            split = None if delimiter == " " else delimiter
            return np.loadtxt(rows, delimiter=split, usecols=places, quotechar='"', comments=None, ndmin=2)
        except ValueError as error:
            raise self._cell_error(places) or FileError(
                f"{self.file} is not a table of numbers: {error}."
            ) from None

    def _rows(self) -> Iterator[tuple[int, str]]:
        """Yield the number and the text of every line that is not empty."""
        for number, line in enumerate(self.lines, self.first):
            if line.strip(_BLANK_CHARACTERS):
                yield number, line

    def _cell_error(self, places: Sequence[int]) -> FileError | None:
        """Return the error for the first cell that is not a number."""
        for number, line in self._rows():
            cells = _cells(line, self.delimiter)
            for place in places:
                cell = cells[place] if place < len(cells) else ""
                if not _is_number(cell, self.decimal):
                    what = f"is {quoted(cell)}" if cell else "is missing"
                    where = f"line {number}, {shortened(self.names[place])}"
                    other = "; its decimal sign is a comma" if self.decimal == "," and "." in cell else ""
                    return FileError(f"{self.file} is not a table of numbers: {where} {what}{other}.")
        return None


def read(path: str | Path) -> Table:
    """Read the table in a text file; raise FileError if the file has no valid table."""
    file = printable(Path(path).name)
    lines = _decoded(read_bytes(path, MOST_BYTES)).replace("\r\n", "\n").replace("\r", "\n").split("\n")
    longest = max(map(len, lines))
    if longest > _LONGEST_LINE:
        at = next(at for at, line in enumerate(lines, 1) if len(line) == longest)
        raise FileError(f"{file}, line {at} has {longest:,} characters; the limit is {_LONGEST_LINE:,}.")
    body = [
        (at, line) for at, line in enumerate(lines) if line.strip(_BLANK_CHARACTERS) and not _is_comment(line)
    ]
    places, first_lines = zip(*body[:_DIALECT_LINES], strict=True) if body else ((), ())
    delimiter = max(DELIMITERS, key=lambda d: _delimiter_score(first_lines, d))
    cells = [_cells(line, delimiter) for line in first_lines]
    kinds = [tuple(bool(_NUMBER.fullmatch(cell)) for cell in row) for row in cells]
    usual = Counter(kind for kind in kinds if any(kind)).most_common(1)
    if not usual:
        raise FileError(f"{file} has 0 rows of numbers. A recording is a table as text (CSV) or a session.")
    numbers, width = sum(usual[0][0]), len(usual[0][0])
    start = next(at for at, kind in enumerate(kinds) if 2 * sum(kind) > numbers)
    first = places[start]
    comments = tuple(_comment(line, delimiter) for line in lines[:first] if _is_comment(line))
    names = _names(cells[:start], comments, delimiter, width)
    if not width <= len(names) <= len(_split(lines[first], delimiter)):
        shape = f"rows of {width} numbers for {len(names)} names"
        raise FileError(f"{file} has {shape}: it is not a recording.")
    return Table(file, names, comments, delimiter, _decimal(file, cells[start:]), first + 1, lines[first:])


def guess(names: Sequence[str]) -> dict[str, TableColumn]:
    """Guess columns and units from names, for example time in ms from "t_ms"; without a unit, assume SI."""
    found: dict[str, TableColumn] = {}
    for name in names:
        words = [word for word in re.split(r"[^\w/µ-]+|_", name) if word]
        lower = words[0].lower() if words else ""
        quantity = next((key for key, called in _NAME_PREFIXES.items() if lower in called), None)
        if quantity is None or quantity in found:
            continue
        known = UNITS[quantity]
        rest = [*words[1:], "/".join(words[-2:]), name.partition("_")[2].replace("_per_", "/")]
        units = (_MORE_UNITS.get(word, word) for word in rest)
        found[quantity] = TableColumn(
            name, next((unit for unit in units if unit in known), next(iter(known)))
        )
    return found


# --- lines


def _decoded(data: bytes) -> str:
    """Decode a file by its byte-order mark, otherwise as UTF-8, otherwise by the Windows code page."""
    for mark, coding in _MARKS.items():
        if data.startswith(mark):
            return data.decode(coding, "replace")
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError:
        return data.decode("cp1252", "replace")


def _is_comment(line: str) -> bool:
    return line.lstrip(' "').startswith("#")


def _comment(line: str, delimiter: str) -> str:
    """Return a comment without "#"; a spreadsheet may have quoted the comment or split it at commas."""
    line = line.strip()
    if line.startswith('"'):
        line = ",".join(_split(line, delimiter))
    return line.rstrip(_PADDING).removeprefix("#").strip()


def _split(line: str, delimiter: str) -> list[str]:
    """Return a line's cells."""
    if delimiter == " ":
        return line.replace('"', " ").split()
    if '"' in line:
        with suppress(csv.Error):  # the line contains a null character
            return next(csv.reader([line], delimiter=delimiter), [])
    return line.split(delimiter)


def _cells(line: str, delimiter: str) -> list[str]:
    """Return a line's cells without empty cells at the end."""
    cells = [cell.strip() for cell in _split(line, delimiter)]
    while cells and not cells[-1]:
        cells.pop()
    return cells


def _delimiter_score(lines: Sequence[str], delimiter: str) -> tuple[int, int]:
    """Return a delimiter's score: the number of lines without text cells, and the number of numeric cells."""
    rows = [[bool(_NUMBER.fullmatch(cell)) for cell in _cells(line, delimiter) if cell] for line in lines]
    return sum(all(row) for row in rows if row), sum(map(sum, rows))


def _names(
    above: Sequence[Sequence[str]], comments: Sequence[str], delimiter: str, width: int
) -> tuple[str, ...]:
    """Return the columns' names from the row above the numbers or from a comment; otherwise "1", "2", …"""
    found = [row for row in above[-2:] if len(row) > 1 or width == 1]
    if len(found) == 2 and all(_is_unit(cell) for cell in found[1]):
        return tuple(found[0])
    if found:
        return tuple(found[-1])
    last = _cells(comments[-1], delimiter) if comments else []
    last = last if len(last) == width else comments[-1].split() if comments else []
    return tuple(last) if len(last) == width else tuple(map(str, range(1, width + 1)))


def _is_unit(cell: str) -> bool:
    return any(cell.strip("()[]") in units for units in UNITS.values())


def _is_number(cell: str, decimal: str) -> bool:
    return bool(_NUMBER.fullmatch(cell)) and ("." if decimal == "," else ",") not in cell


def _decimal(file: str, rows: Sequence[Sequence[str]]) -> str:
    """Return the decimal sign of the numbers in rows; raise FileError if both signs are used."""
    numbers = [cell for row in rows for cell in row if _NUMBER.fullmatch(cell)]
    with_comma, with_point = (next((c for c in numbers if sign in c), "") for sign in ",.")
    if with_comma and with_point:
        raise FileError(
            f"{file} has a decimal comma in {shortened(with_comma)} and a point in {shortened(with_point)}."
        )
    return "," if with_comma else "."
