"""Tables of samples as files of other programs: CSV for spreadsheets, Parquet, and MATLAB's .mat."""

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from hapkit_studio.errors import ParameterError
from hapkit_studio.files import replacing

Columns = Mapping[str, np.ndarray]
DECIMALS = (".", ",")


def write(path: str | Path, columns: Columns, settings: Mapping[str, Any], decimal: str = ".") -> None:
    """Write columns (n,), named with their units, and what was set; the name's ending says as what.

    decimal: the mark in a CSV's numbers; with a comma, semicolons stand between them. Raise ParameterError
    for an ending or a mark that is unknown, or where a library is missing; OSError.
    """
    ending = Path(path).suffix.lower()
    if ending not in WRITERS:
        raise ParameterError(f"A table ends in {', '.join(WRITERS)}, not {ending or 'nothing'!r}.")
    if decimal not in DECIMALS:
        raise ParameterError(f"The decimal mark is a point or a comma, not {decimal!r}.")
    said = json.dumps(settings, ensure_ascii=False, default=float)
    with replacing(path) as part:
        WRITERS[ending](part, columns, said, decimal)


def _csv(path: Path, columns: Columns, settings: str, decimal: str) -> None:
    """Write a comment line of settings (JSON), then names with units, then the samples."""
    between = ";" if decimal == "," else ","
    table = np.column_stack(list(columns.values()))
    with path.open("w", encoding="utf-8") as file:
        file.write(f"# {settings}\n{between.join(columns)}\n")
        line = between.join(["%.9g"] * table.shape[1]) + "\n"
        for row in table.tolist():
            text = line % tuple(row)
            file.write(text.replace(".", ",") if decimal == "," else text)


def _parquet(path: Path, columns: Columns, settings: str, _decimal: str) -> None:
    try:
        from pyarrow import parquet, table
    except ImportError:
        raise ParameterError("Parquet needs pyarrow: pip install 'hapkit-studio[parquet]'.") from None
    parquet.write_table(table(dict(columns)).replace_schema_metadata({"settings": settings}), path)


def _mat(path: Path, columns: Columns, settings: str, _decimal: str) -> None:
    from scipy.io import savemat

    savemat(path, {**columns, "settings": settings}, do_compression=True, long_field_names=True)


WRITERS: dict[str, Callable[[Path, Columns, str, str], None]] = {
    ".csv": _csv, ".parquet": _parquet, ".mat": _mat,
}  # fmt: skip
"""What is written by the ending of a name."""
