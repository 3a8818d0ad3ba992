"""Exports tables of samples as CSV for spreadsheets, as Parquet, and as MATLAB's .mat.

Each file has the settings at the start and every later change with its time. A column "group.name" belongs to
a group, such as "state" for the law's state variables. The prefix distinguishes the column from the studio's
own columns.
"""

import csv
import re
import unicodedata
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

import numpy as np

from hapkit_studio import settings_log
from hapkit_studio.errors import ParameterError
from hapkit_studio.files import is_special, replacing
from hapkit_studio.settings_log import Log

Columns = Mapping[str, np.ndarray]
DECIMALS = (".", ",")
_LONGEST_NAME = 63  # maximum number of characters in a MATLAB identifier
_KEYWORDS = (  # keywords of MATLAB
    "break", "case", "catch", "classdef", "continue", "else", "elseif", "end", "for", "function", "global",
    "if", "otherwise", "parfor", "persistent", "return", "spmd", "switch", "try", "while",
)  # fmt: skip


def write(path: str | Path, columns: Columns, log: Log, decimal: str = ".") -> None:
    """Write columns (n,) and the settings log to a file, whose suffix selects the format.

    The columns' names contain units. ``decimal`` is the decimal mark of a CSV; with a comma, semicolons
    separate the fields. Raise ParameterError for an unknown suffix or mark, or a missing library, and OSError
    if the file cannot be written.
    """
    ending = Path(path).suffix.lower() or ("" if not is_special(path) else ".csv")
    if ending not in WRITERS:
        raise ParameterError(f"A table's name must end in {', '.join(WRITERS)}, not {ending or 'nothing'!r}.")
    if decimal not in DECIMALS:
        raise ParameterError(f"The decimal mark must be a point or a comma, not {decimal!r}.")
    with replacing(path) as part:
        WRITERS[ending](part, columns, log, decimal)


def _csv(path: Path, columns: Columns, log: Log, decimal: str) -> None:
    """Write a comment line for each setting, then the column names, then the samples."""
    between = ";" if decimal == "," else ","
    table = np.column_stack(list(columns.values()))
    with path.open("w", encoding="utf-8", newline="\n") as file:
        file.writelines(f"{line}\n" for line in settings_log.lines(log))
        csv.writer(file, delimiter=between, lineterminator="\n").writerow(columns)
        line = between.join(["%.9g"] * table.shape[1]) + "\n"
        for row in table.tolist():
            text = line % tuple(row)
            file.write(text.replace(".", ",") if decimal == "," else text)


def _parquet(path: Path, columns: Columns, log: Log, _decimal: str) -> None:
    try:
        from pyarrow import parquet, table
    except ImportError:
        raise ParameterError(
            "Parquet files need the package pyarrow. Install it: pip install 'hapkit-studio[parquet]'."
        ) from None
    named = table(dict(columns)).replace_schema_metadata({"settings": settings_log.as_json(log)})
    parquet.write_table(named, path)


def _mat(path: Path, columns: Columns, log: Log, _decimal: str) -> None:
    """Write each column as a variable, and each group as a struct."""
    from scipy.io import savemat

    groups: dict[str, dict[str, np.ndarray]] = {}
    for name, values in columns.items():
        group, _, inner = name.rpartition(".")
        groups.setdefault(group, {})[inner] = values
    own, settings = groups.pop("", {}), {"settings": settings_log.as_json(log)}
    structs = {name: _with_identifiers(inner) for name, inner in groups.items()}
    savemat(
        path, {**_with_identifiers(own), **structs, **settings}, do_compression=True, long_field_names=True
    )


def _with_identifiers(columns: Columns) -> dict[str, np.ndarray]:
    return dict(zip(matlab_names(columns), columns.values(), strict=True))


def matlab_names(names: Iterable[str]) -> list[str]:
    """Return a unique MATLAB identifier for each name: "old[0]" becomes old_0, "größe" becomes grosse."""
    found: list[str] = []
    for name in names:
        plain = re.sub(r"\W+", "_", "".join(map(_ascii, unicodedata.normalize("NFKD", name)))).strip("_")
        if not plain[:1].isalpha() or plain in _KEYWORDS:
            plain = f"x_{plain}".rstrip("_")
        made, number = plain[:_LONGEST_NAME], 2
        while made in found:
            end = f"_{number}"
            made, number = plain[: _LONGEST_NAME - len(end)] + end, number + 1
        found.append(made)
    return found


def _ascii(letter: str) -> str:
    """Return a letter in ASCII: the letter without its accent, or its name, such as omega for ω."""
    if letter.isascii():
        return letter
    if unicodedata.combining(letter):
        return ""
    if (folded := letter.casefold()).isascii():  # for example, ß becomes ss
        return folded
    kind, _, name = unicodedata.name(letter, "").partition(" LETTER ")
    name = re.sub(r"\W+", "_", name.partition(" WITH ")[0])
    return (name.lower() if "CAPITAL" not in kind else name.capitalize()) or f"u{ord(letter):x}"


WRITERS: dict[str, Callable[[Path, Columns, Log, str], None]] = {
    ".csv": _csv, ".parquet": _parquet, ".mat": _mat,
}  # fmt: skip
"""The function that writes a file, by the file's suffix."""
