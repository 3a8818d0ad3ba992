"""The text of a table of results has titles, units, alignment, and one line per row."""

from operator import itemgetter

from hapkit_studio.columns import Column, text_lines

NAME = Column("Name", itemgetter(0), right=False)
LIMIT = Column("Limit", lambda row: f"{row[1]:g}", unit="N/m")


def test_texts_are_aligned_under_titles_and_units():
    assert text_lines((NAME, LIMIT), [("spring", 5.0), ("w", 12000.0)], indent="  ") == [
        "  Name    Limit",
        "            N/m",
        "  spring      5",
        "  w       12000",
    ]


def test_without_units_there_is_no_line_for_them_and_no_trailing_spaces():
    assert text_lines((NAME,), [("spring",), ("w",)]) == ["Name", "spring", "w"]


def test_a_row_is_one_printable_line_for_any_texts():
    lines = text_lines((Column("Method\nused", itemgetter(0), right=False), NAME), [("a\nb\x1b[31m",)])
    assert lines == ["Method used    Name", "a b\\u001b[31m  a b\\u001b[31m"]
    assert all(line.isprintable() for line in lines)
