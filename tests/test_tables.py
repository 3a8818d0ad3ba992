"""Tables of any dialect give the same numbers, and invalid tables give a one-line error."""

import csv
import io
import itertools
import os

import numpy as np
import pytest

from hapkit_studio import tables
from hapkit_studio.errors import FileError, ParameterError

NAMES = ("t_ms", "x_mm", "note", "F")
ROWS = [(0.0, 1.5, "", -0.25), (1.0, -2e-3, "", 1234.5), (2.0, 0.0, "", 3.0)]
DIALECTS = [
    (delimiter, decimal, quoting, end)
    for delimiter, decimal, quoting, end in itertools.product(
        (",", ";", "\t", "|"), ".,", (csv.QUOTE_MINIMAL, csv.QUOTE_ALL, csv.QUOTE_NONNUMERIC), ("\n", "\r\n")
    )
    if (delimiter, decimal, quoting) != (",", ",", csv.QUOTE_NONE)
]


def text_of(rows, delimiter, decimal, quoting=csv.QUOTE_MINIMAL, end="\n", names=NAMES, pad=0):
    """Return a table as Python's csv module writes it; cells that contain the delimiter have quotes."""
    file = io.StringIO()
    writer = csv.writer(file, delimiter=delimiter, quoting=quoting, lineterminator=end)
    writer.writerow([*names, *[""] * pad])
    for row in rows:
        cells = [repr(v).replace(".", decimal) if isinstance(v, float) else v for v in row]
        writer.writerow([*cells, *[""] * pad])
    return file.getvalue()


@pytest.fixture
def table(tmp_path):
    def make(content, name="a.csv"):
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return tables.read(path)

    return make


@pytest.mark.parametrize(("delimiter", "decimal", "quoting", "end"), DIALECTS)
def test_the_dialect_changes_no_number(table, delimiter, decimal, quoting, end):
    expected = np.array([[row[0], row[1], row[3]] for row in ROWS])
    for pad, last in ((0, ""), (2, delimiter * 5 + end)):
        found = table(text_of(ROWS, delimiter, decimal, quoting, end, pad=pad) + last)
        assert found.names == NAMES
        np.testing.assert_array_equal(found.values(["t_ms", "x_mm", "F"]), expected)


@pytest.mark.parametrize("coding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
def test_every_text_encoding_gives_the_same_comments_and_names(table, coding):
    found = table(("# damping: 2 N·s/m\nZeit;Größe\n0,5;1\n1,5;2\n").encode(coding))
    assert found.comments == ("damping: 2 N·s/m",)
    assert found.names == ("Zeit", "Größe")
    assert found.values(["Größe", "Zeit"]).tolist() == [[1.0, 0.5], [2.0, 1.5]]


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("# t x F\n0.0 1.0 2.0\n1.0 2.0 3.0\n", ("t", "x", "F")),  # numpy.savetxt writes this with a header
        ("0,00 0,10\n1,00 0,20\n", ("1", "2")),
        ("Model,DPO\nRecord,1000\nTIME,CH1\n0,1\n1,2\n2,3\n3,4\n", ("TIME", "CH1")),
        ("t;x\nms;mm\n0;1\n1;2\n2;3\n", ("t", "x")),
        ("t;x\n[ms];[mm]\n0;1\n1;2\n2;3\n", ("t", "x")),
        ("Recorded by Zoe\n0;1\n1;2\n", ("1", "2")),
        ("lateness (s)\n0.0005\n0.0006\n", ("lateness (s)",)),
        ("when;t;x\n2024-01-01 10:00;0,5;1,5\n2024-01-01 10:00;0,6;1,5\n", ("when", "t", "x")),
        ("t,x,unused\n0,1,\n1,2,\n", ("t", "x", "unused")),
    ],
)
def test_names_are_found_above_the_numbers(table, text, names):
    assert table(text).names == names


@pytest.mark.parametrize(
    ("text", "names", "message"),
    [
        ("", (), "a.csv has 0 rows of numbers"),
        ("a;b\n", (), "a.csv has 0 rows of numbers"),
        (b"\x89PNG\r\n\x1a\n\0\0\0", (), "a.csv has 0 rows of numbers"),
        (bytes(range(256)) * 20, (), "a.csv has 0 rows of numbers"),
        ("a;b\n1.5;2,5\n", (), "a decimal comma in 2,5 and a point in 1.5"),
        ("a;b\n1;2,5\n\n3;x\n", "b", "line 4, b is 'x'"),
        ("a;b\n1;2,5\n;3\n", "a", "line 3, a is missing"),
        ("a;b\n1;2,5\n3\n", "b", "line 3, b is missing"),
        ("a;b;c\n1;2,5\n3;4,5\n", (), "rows of 2 numbers for 3 names"),
        ("a;a\n1;2\n", "a", "has 2 columns a"),
        (
            "a;b\n" + "1,5;2,5\n" * 300 + "1.000;2,5\n",
            "a",
            "line 302, a is '1.000'; its decimal sign is a comma",
        ),
        ("a;b\n" + "0;2.5\n" * 300 + "1,5;2,5\n", "a", "line 302, a is '1,5'"),
        ("a\x1b[8m;b\n1;2\nx;2\n", ["a\x1b[8m"], r"line 3, a\\u001b\[8m is 'x'"),
        (
            "a;b\n1;2\n" + "9" * 65_000 + "x;2\n",
            "a",
            "line 3, a is '9{40}…'",
        ),  # reading this must not take quadratic time
        ("1," * 40_000, (), "line 1 has 80,000 characters; the limit is 65,536"),
    ],
)
def test_invalid_tables_give_a_one_line_error(table, text, names, message):
    with pytest.raises(FileError, match=message) as raised:
        table(text).values(list(names))
    assert str(raised.value).isprintable()


@pytest.mark.parametrize("content", ["fifo", "large", "folder", "none"])
def test_only_regular_files_of_limited_size_are_read(tmp_path, content):
    path = tmp_path / "a.csv"
    if content == "fifo":
        os.mkfifo(path)
    elif content == "large":
        with path.open("wb") as file:
            file.truncate(tables.MOST_BYTES + 1)
    elif content == "folder":
        path.mkdir()
    with pytest.raises(FileError, match=r"a\.csv"):
        tables.read(path)


@pytest.mark.parametrize(
    ("names", "found"),
    [
        (("t_ms", "x_mm", "dx_mms", "F"), "t_ms:ms x_mm:mm dx_mms:mm/s F:N"),
        (("Time (s)", "Position [mm]", "Velocity [m/s]", "Force (mN)"), "Time (s):s Position [mm]:mm "
         "Velocity [m/s]:m/s Force (mN):mN"),
        (("Zeit / ms", "Weg / µm", "Kraft / N"), "Zeit / ms:ms Weg / µm:µm Kraft / N:N"),
        (("time_s", "position_m", "velocity_m_per_s", "force_asked_N"),
         "time_s:s position_m:m velocity_m_per_s:m/s force_asked_N:N"),
        (("channel 1", "texture", "fox"), ""),
    ],
)  # fmt: skip
def test_quantities_and_units_are_guessed_from_names(names, found):
    guessed = tables.guess(names).values()
    assert " ".join(map(str, sorted(guessed, key=lambda column: names.index(column.name)))) == found


@pytest.mark.parametrize("text", ["t_ms", "t_ms:", ":ms", "t_ms:mm", "t_ms:MS"])
def test_a_column_is_a_name_and_a_unit(text):
    with pytest.raises(ParameterError, match="time is NAME:UNIT, the unit one of s, ms, µs, us, min, not"):
        tables.parse_column("time", text)
    assert tables.parse_column("time", "a: b :ms") == tables.TableColumn("a: b", "ms")
