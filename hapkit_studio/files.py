"""Reads foreign files with limits and checks, and writes files atomically."""

import json
import math
import os
import re
import stat
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

from hapkit_studio.errors import FileError
from hapkit_studio.formatting import quoted

# maximum number of bytes of a file with settings, unless its reader passes a different limit
MOST_BYTES = 65_536
MOST_NESTED = 32  # maximum depth of brackets; Python's parsers recurse once per level
# maximum number of characters of a key or number; tomllib takes 13 s for a dotted key of 40 KB
LONGEST_WORD = 256
_SKIPPED = re.compile(
    r"""#[^\n]*|\"{3}(?:\\.|[^\\])*?(?:\"{3}|\Z)|'{3}.*?(?:'{3}|\Z)|"(?:\\.|[^"\\\n])*"?|'[^'\n]*'?""", re.S
)  # matches comments and strings of TOML, which include those of JSON
_LONG_RUN = re.compile(rf'[^"]{{{LONGEST_WORD + 1}}}')  # matches within every JSON number that is too long
_STRUCTURE = re.compile(r"[\[{]|[\]}]|[\w+-]+(?:[ \t]*\.[ \t]*[\w+-]+)*")


def open_regular(path: str | Path) -> BinaryIO:
    """Open a file for reading bytes; raise FileError if it is a device or a pipe, not a file.

    The file is opened in non-blocking mode and then tested, because opening a FIFO would wait for its writer.
    """
    try:
        file = open(path, "rb", opener=_open_without_blocking)  # noqa: SIM115, the caller closes it
    except OSError as error:
        raise FileError(f"Cannot read {_name(path)}: {error.strerror}.") from None
    except ValueError as error:  # the path contains a null character
        raise FileError(f"Cannot read {_name(path)}: {error}.") from None
    if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
        file.close()
        raise FileError(f"Cannot read {_name(path)}: it is a device or a pipe, not a file.")
    return file


def _name(path: str | Path) -> str:
    return Path(path).name or str(path)


def _open_without_blocking(path: str, flags: int) -> int:
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


def read_bytes(path: str | Path, most: int = MOST_BYTES) -> bytes:
    """Return a regular file's bytes; raise FileError if it is unreadable or has more than ``most`` bytes."""
    with open_regular(path) as file:
        size = os.fstat(file.fileno()).st_size
        try:
            data = b"" if size > most else file.read(most + 1)
        except OSError as error:
            raise FileError(f"Cannot read {_name(path)}: {error.strerror}.") from None
    if max(size, len(data)) > most:
        raise FileError(f"{Path(path).name} has {max(size, len(data)):,} bytes; the limit is {most:,} bytes.")
    return data


def read_text(path: str | Path, most: int = MOST_BYTES) -> str:
    """Return a regular file's UTF-8 text without byte-order mark; raise FileError if it is not valid."""
    data = read_bytes(path, most)
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise FileError(f"{Path(path).name}, line {line}: not text in UTF-8. Save it as UTF-8.") from None


def read_toml(path: str | Path, most: int = MOST_BYTES) -> dict[str, Any]:
    """Return the table in a TOML file; raise FileError, which names the line, if the file is invalid."""
    return parse_toml(read_text(path, most), Path(path).name)


def parse_toml(text: str, name: str) -> dict[str, Any]:
    """Return the table of a TOML text; raise FileError with ``name`` and the line if it is invalid."""
    _check_structure(text, name)
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise FileError(f"{name}: {error}.") from None


def parse_json(text: str, name: str) -> Any:
    """Return the value of a JSON text; raise FileError, which begins with ``name``, if it is invalid."""
    if text.count("[") + text.count("{") > MOST_NESTED or _LONG_RUN.search(
        text
    ):  # no other text can exceed the two limits
        _check_structure(text, name)
    try:
        return json.loads(text)
    except (ValueError, RecursionError) as error:
        raise FileError(f"{name}: {error}.") from None


def _check_structure(text: str, name: str) -> None:
    """Raise FileError if a JSON or TOML text is nested too deeply, or has too long words, for its parser."""
    bare = _SKIPPED.sub(lambda found: "s" * (found[0][0] != "#") + "\n" * found[0].count("\n"), text)
    depth = 0
    for found in _STRUCTURE.finditer(bare):
        depth += (found[0] in "[{") - (found[0] in "]}")
        if depth > MOST_NESTED:
            wrong = f"brackets are nested deeper than {MOST_NESTED}"
        elif len(found[0]) > LONGEST_WORD:
            wrong = f"a key or number has {len(found[0]):,} characters; the limit is {LONGEST_WORD}"
        else:
            continue
        raise FileError(f"{name}, line {bare.count(chr(10), 0, found.start()) + 1}: {wrong}.")


def checked_number(
    value: object, place: str, low: float = -math.inf, high: float = math.inf, unit: str = ""
) -> float:
    """Return a file's value as a float from ``low`` to ``high``; otherwise raise FileError.

    The error's text begins with ``place``. True, False, NaN and infinities are rejected.
    """
    try:
        number = float(value) if isinstance(value, int | float) and not isinstance(value, bool) else math.nan
    except OverflowError:
        number = math.inf
    if not (math.isfinite(number) and low <= number <= high):
        raise _wrong(value, place, f"a number{_range(low, high)} {unit}".rstrip())
    return number


def checked_integer(value: object, place: str, low: float = -math.inf, high: float = math.inf) -> int:
    """Return a file's value as an integer from ``low`` to ``high``.

    Raise FileError for any other value; its message begins with ``place``.
    """
    if not isinstance(value, int) or isinstance(value, bool) or not low <= value <= high:
        raise _wrong(value, place, f"a whole number{_range(low, high)}")
    return value


def checked_text(value: object, place: str, longest: int) -> str:
    """Return a file's value as one line of printable text; otherwise raise FileError."""
    if not isinstance(value, str) or len(value) > longest or not value.isprintable():
        raise _wrong(value, place, f"a line of at most {longest} printable characters")
    return value


def checked_table(value: object, place: str) -> dict[str, Any]:
    """Return a file's value as a table whose keys are texts; otherwise raise FileError."""
    if not isinstance(value, dict):
        raise _wrong(value, place, "a table")
    return value


def checked_list(value: object, place: str, count: int | None = None) -> list[Any]:
    """Return a file's value as a list of ``count`` values, or of any number if None.

    Raise FileError for any other value.
    """
    if not isinstance(value, list) or len(value) != (count or len(value) or 1):
        raise _wrong(value, place, f"a list of {count} values" if count else "a list of values")
    return value


def _range(low: float, high: float) -> str:
    least, most = (f"{limit:,}" if isinstance(limit, int) else f"{limit:,g}" for limit in (low, high))
    if math.isinf(low) and math.isinf(high):
        return ""
    if math.isinf(high):
        return f" of at least {least}"
    return f" of at most {most}" if math.isinf(low) else f" from {least} to {most}"


def _wrong(value: object, place: str, wanted: str) -> FileError:
    return FileError(f"{place} is {quoted(value)}; it must be {wanted}.")


def is_special(path: str | Path) -> bool:
    """Return True if a path is neither a file nor a folder but a device, a pipe or a terminal."""
    try:
        mode = os.stat(path).st_mode
    except (OSError, ValueError):
        return False
    return not (stat.S_ISREG(mode) or stat.S_ISDIR(mode))


@contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """Yield a temporary path with the same suffix next to a file; it replaces the file at the end.

    On failure the temporary file is removed, and an existing file is unchanged. A device or pipe is written
    directly. Raise OSError if writing fails.
    """
    path = Path(path)
    if is_special(path):
        yield path
        return
    path = Path(os.path.realpath(path))  # replace the file to which a link points, not the link
    part = path.with_name(f".{path.stem}.{os.getpid()}.part{path.suffix}")
    try:
        yield part
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)
