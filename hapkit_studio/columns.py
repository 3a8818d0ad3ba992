"""Columns of a table of results. The window's tables and the command line share one declaration."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from hapkit_studio.formatting import printable

_GAP = "  "


@dataclass(frozen=True)
class Column:
    """A column: title, unit, and functions for the text, sort key, colours and alignment of a row's cell.

    ``order`` is the sort key; the default is the text. ``token`` and ``ground`` are the names of text and
    background colours in the palette. ``mark`` is the matplotlib marker before the text, and the name of its
    colour. ``right``: the text is right-aligned.
    """

    title: str
    text: Callable[[Any], str]
    order: Callable[[Any], Any] | None = None
    token: Callable[[Any], str] = lambda _row: "ink"
    mark: Callable[[Any], tuple[str, str]] | None = None
    ground: Callable[[Any], str] | None = None
    right: bool = True
    unit: str = ""

    @property
    def head(self) -> str:
        """Return the title, with the unit on a separate line."""
        return f"{self.title}\n{self.unit}" if self.unit else self.title


def text_lines(columns: Iterable[Column], rows: Iterable[Any], indent: str = "") -> list[str]:
    """Return a table as lines of text: the titles, the units if a column has one, then one line per row.

    Line breaks in cells become spaces.
    """
    columns = tuple(columns)
    heads = [[c.title for c in columns], [c.unit for c in columns]]
    cells = [*(head for head in heads if any(head)), *([c.text(row) for c in columns] for row in rows)]
    cells = [[printable(text.replace("\n", " ")) for text in line] for line in cells]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    return [
        indent
        + _GAP.join(
            text.rjust(width) if column.right else text.ljust(width)
            for text, width, column in zip(line, widths, columns, strict=True)
        ).rstrip()
        for line in cells
    ]
