"""Tables of a file have the same numbers, limits and faults in the loop, on the board and in the sketch."""

import math
import sys
from types import SimpleNamespace

import numpy as np
import pytest

from hapkit_studio.errors import LawError
from hapkit_studio.haptics.board_plan import BoardPlanner, PlanRequest
from hapkit_studio.laws import board
from hapkit_studio.laws.machine import ARENA, Refusal
from hapkit_studio.workshop import reading, sketch
from hapkit_studio.workshop.source import typed
from tests.laws import table_law
from tests.laws.law_files import environment, held, law_text, line_of, module
from tests.laws.machine_pc import needs_compiler
from tests.laws.test_c_source import Job, run
from tests.laws.twins import Compiled

TABLE = "TABLE = (1.5, -2.0, 0.25)\nTURNS = 4\nHALF = 0.5\n"
OUTSIDE = ("3", "-1", "2 + 1.5", "x * 1e9", "-0.5", "math.log(0.0)", "math.sqrt(-x)")


def own(folder, text=table_law.TEXT):
    """Return the environment of a user's file."""
    return reading.load_source(typed(folder / "measured_object.py", text))


def motion(count=400):
    """Return rows (n, 2) of position and velocity over the whole table and beyond both ends."""
    x = np.linspace(-0.02, 0.03, count) + 1e-5
    return np.stack([x, 0.5 * np.sin(np.arange(count))], axis=1)


def test_the_compiled_law_interpolates_in_its_tables(tmp_path):
    law = Compiled(own(tmp_path).force, {"gain": 1.5}, 1e-3)
    rows = motion()
    found = [law.call(x, v) for x, v in rows.tolist()]
    assert found == pytest.approx(table_law.force(*rows.T, gain=1.5), abs=1e-12)


@needs_compiler
def test_the_board_interpolates_in_its_tables(machine, tmp_path):
    program = board.compile(own(tmp_path).force, {"gain": 1.5}, 1e-3, ARENA)
    assert program.tables == 4 * (len(table_law.FORCES) + len(table_law.STRIPES))
    loaded = machine.load(program.states, program.given, program.slots, program.code)
    assert (loaded.refusal, loaded.cycles) == (Refusal.NONE, program.most)
    rows = motion()
    forces, _ = machine.run(rows)
    assert np.abs(forces - table_law.force(*rows.T, gain=1.5)).max() < 2e-3


def test_the_sketch_interpolates_in_its_tables(tmp_path, monkeypatch):
    made, rows = own(tmp_path), motion()
    (found,) = run([Job(made, {"gain": 1.5}, rows)], tmp_path, monkeypatch)
    assert found == pytest.approx(table_law.force(*rows.T, gain=1.5), abs=1e-9)


def test_a_table_stands_in_the_sketch_as_a_constant_array(tmp_path):
    law = sketch.translated(own(tmp_path), {"gain": 1.0})
    assert f"const float FORCES_[{len(table_law.FORCES)}] PROGMEM = {{" in law.text
    assert (
        f"const float STRIPES_[3] PROGMEM = {{\n    {', '.join(f'{f}f' for f in table_law.STRIPES)}\n}};"
        in law.text
    )


VALUES = [
    ("TABLE[0] + TABLE[2]", 1.75),
    ("TABLE[1.9]", -2.0),
    ("TABLE[x > 0.0]", -2.0),
    ("len(TABLE)", 3.0),
    ("TABLE[len(TABLE) - 1]", 0.25),
    ("len(s.ring)", 2.0),
    ("helped(1.0)", -4.0),
    ("helped(1.0, 2.0)", 2.0),
    ("math.radians(90.0) + math.degrees(math.pi)", math.pi / 2 + 180.0),
    ("math.log10(1000.0) + math.log10(10.0 + x)", 3.0 + math.log10(10.01)),
    ("math.trunc(-2.5) + math.trunc(1.75)", -1.0),
]
LOOPS = [
    ("TURNS", range(4)),
    ("TURNS - 1", range(3)),
    ("len(TABLE)", range(3)),
    ("2 * TURNS, 0, -len(TABLE)", range(8, 0, -3)),
    ("-TURNS, len(s.ring)", range(-4, 2)),
]
HELPER = f"{TABLE}\ndef helped(a, b=-TURNS):\n    return TABLE[1] * b * HALF * a * -1.0\n"


@pytest.fixture(scope="module")
def values(tmp_path_factory):
    """Return one law for all of VALUES and LOOPS; the damping's value selects one of them."""
    body = [f"if p.damping == {n}.0: return {value}" for n, (value, _) in enumerate(VALUES)]
    for n, (turns, _) in enumerate(LOOPS, len(VALUES)):
        body += [
            f"if p.damping == {n}.0:",
            "    a = 0.0",
            f"    for i in range({turns}): a += 1.0 + 0.01 * i",
        ]
        body += ["    return a"]
    folder = tmp_path_factory.mktemp("values")
    return environment(folder, law_text("\n".join([*body, "return 0.0"]), "{'ring': (0.0, 0.0)}", HELPER))


WANTED = [wanted for _, wanted in VALUES] + [sum(1.0 + 0.01 * i for i in turns) for _, turns in LOOPS]


@needs_compiler
@pytest.mark.parametrize("n", range(len(WANTED)), ids=[text for text, _ in [*VALUES, *LOOPS]])
def test_table_values_and_loop_counts(values, machine, n):
    given = values.values({"damping": float(n)})
    assert Compiled(values.force, given, 1e-3).call(0.01, 0.0) == pytest.approx(WANTED[n], rel=1e-14)
    program = board.compile(values.force, given, 1e-3)
    machine.load(program.states, program.given, program.slots, program.code)
    assert machine.run([[0.01, 0.0]])[0] == pytest.approx(WANTED[n], rel=1e-6)


def test_table_values_and_loop_counts_in_the_sketch(values, tmp_path, monkeypatch):
    row = np.array([[0.01, 0.0]])
    jobs = [Job(values, values.values({"damping": float(n)}), row) for n in range(len(WANTED))]
    assert np.concatenate(run(jobs, tmp_path, monkeypatch)) == pytest.approx(WANTED, rel=1e-12)


@pytest.fixture(scope="module")
def outside(tmp_path_factory):
    """Return a law, and its line with an index out of range; the damping's value selects the index."""
    body = [f"if p.damping == {n}.0: return 5.0 + entry({index})" for n, index in enumerate(OUTSIDE)]
    beside = TABLE + "\ndef entry(i):\n    return TABLE[i]\n"
    text = law_text("\n".join([*body, "return TABLE[0]"]), beside=beside)
    return environment(tmp_path_factory.mktemp("outside"), text), line_of(text, "return TABLE[i]")


@needs_compiler
@pytest.mark.parametrize("n", range(len(OUTSIDE)), ids=OUTSIDE)
def test_an_index_outside_is_a_fault_everywhere(outside, machine, n, tmp_path, monkeypatch):
    made, line = outside
    (fault,) = (run_ := held(made, damping=float(n))).faults
    assert f"line {line} of the law uses an index outside the state or table" in fault
    assert not run_.applied_force.any()
    given, rows = made.values({"damping": float(n)}), np.array([[0.01, 0.0]])
    program = board.compile(made.force, given, 1e-3)
    machine.load(program.states, program.given, program.slots, program.code)
    assert np.isnan(machine.run(rows)[0]).all()
    (found,) = run([Job(made, given, rows)], tmp_path, monkeypatch)
    assert np.isnan(found).all()


REFUSED = [
    ("TABLE = ()", "TABLE[0]", "has 0 numbers: a table must have 1 to 256"),
    ("TABLE = (0.0,) * 257", "TABLE[0]", "has 257 numbers: a table must have 1 to 256"),
    (
        "TABLE = (0.0, 'soft')",
        "TABLE[0]",
        "`TABLE[1]` is 'soft': the numbers of a table must be at most 3e+38",
    ),
    ("TABLE = (0.0, (1.0, 2.0))", "TABLE[0]", "`TABLE[1]` is (1.0, 2.0): the numbers of a table"),
    ("TABLE = (0.0, math.nan)", "TABLE[0]", "`TABLE[1]` is nan: the numbers of a table"),
    ("TABLE = (0.0, 1e39)", "TABLE[0]", "`TABLE[1]` is 1e+39: the numbers of a table"),
    (TABLE, "TABLE[3]", "`TABLE` has 3 numbers: the index must be between 0 and 2"),
    (TABLE, "TABLE[-len(TABLE)]", "the index must be between 0 and 2"),
    (TABLE, "TABLE[0:2]", "is not allowed"),
    (TABLE, "TABLE", "`TABLE` is a table: use one of its numbers, `TABLE[i]`"),
    (TABLE, "max(TABLE)", "`TABLE` is a table"),
    (TABLE, "TABLE[0][0]", "only `p.name`"),
    (
        "from array import array\nTABLE = array('d', [1.0])",
        "TABLE[0]",
        "`TABLE` is a `array`: a table must be a tuple",
    ),
    ("TABLE = {0: 1.0}", "TABLE[0]", "`TABLE` is a `dict`: a table must be a tuple of numbers"),
    ("TABLE = 'soft'", "TABLE", "`TABLE` is a `str`: a table must be a tuple of numbers"),
    ("TABLE = 2.0", "TABLE[0]", "`TABLE` is a `float`: a table must be a tuple of numbers"),
    ("", "TABLE[0]", "'TABLE' is not defined"),
    (TABLE, "len(x)", "the argument of `len` must be a table, or a state with several values"),
    (TABLE, "len(TABLE, TABLE)", "`len` must have 1 argument, not 2"),
    (TABLE + "def half(a):\n    return a\n", "half(TABLE)", "use the table `TABLE[i]` in the helper"),
]


@pytest.mark.parametrize(("beside", "value", "message"), REFUSED, ids=[value for _, value, _ in REFUSED])
def test_invalid_tables_and_uses_are_rejected_with_their_line(tmp_path, beside, value, message):
    text = law_text(f"a = {value}\nreturn a", beside=beside)
    with pytest.raises(LawError) as error:
        environment(tmp_path, text)
    assert message in str(error.value)
    assert error.value.line == line_of(text, "a = ")


@pytest.mark.parametrize(
    "turns", ["HALF", "x", "TABLE", "len(x)", "TURNS / 2", "True", "1.0", "range(3)", "missing", "len(s)"]
)
def test_a_loop_counts_to_whole_constants(tmp_path, turns):
    text = law_text(f"for i in range({turns}): pass\nreturn 0.0", beside=TABLE)
    with pytest.raises(LawError) as error:
        environment(tmp_path, text)
    assert error.value.line == line_of(text, "for i")


def test_two_files_may_each_have_a_table_of_the_same_name(tmp_path, monkeypatch):
    other = module(tmp_path, "TABLE = (7.0, 8.0)\n\ndef lent(a):\n    return TABLE[a]\n")
    other.lent.__module__ = "hapkit_studio.dynamics.lent"  # a law may call the studio's own functions
    monkeypatch.setitem(sys.modules, "lent_to_laws", other)
    beside = "from lent_to_laws import lent\n\nTABLE = (1.0, 2.0)\n"
    made = environment(tmp_path, law_text("return TABLE[0] + lent(1.0)", beside=beside))
    assert Compiled(made.force, made.values(), 1e-3).call(0.0, 0.0) == 9.0


def long_table(count):
    return f"TABLE = tuple(0.01 * n for n in range({count}))\n"


def test_a_table_too_large_for_the_board_is_refused_with_its_bytes(tmp_path):
    found = {}
    for count in (100, 171, 256):
        text = law_text("return TABLE[min(len(TABLE) - 1, abs(1000.0 * x))]", beside=long_table(count))
        made = environment(tmp_path, text)
        found[count] = BoardPlanner(ARENA).plan(PlanRequest(made, made.values()))
    assert found[100].program.size <= ARENA
    size = found[100].program.size + 4 * 71
    message = f"Student needs {size} bytes of memory, but the board has 768."
    assert found[171] == f"{message} The tables of the law take 684 bytes."
    assert found[256].endswith(
        "The tables of this law take 1,024 bytes, but the board has only 768 bytes for the whole law. "
        "Use fewer numbers."
    )


def test_a_table_of_256_numbers_is_read_to_its_end_by_loop_and_sketch(tmp_path, monkeypatch):
    made = environment(tmp_path, law_text("return TABLE[1000.0 * x]", beside=long_table(256)))
    rows = np.array([[0.0, 0.0], [0.128, 0.0], [0.2555, 0.0], [0.256, 0.0]])
    law = Compiled(made.force, made.values(), 1e-3)
    assert [law.call(x, v) for x, v in rows.tolist()] == pytest.approx(
        [0.0, 1.28, 2.55, math.nan], nan_ok=True
    )
    (found,) = run([Job(SimpleNamespace(force=made.force), made.values(), rows)], tmp_path, monkeypatch)
    assert found == pytest.approx([0.0, 1.28, 2.55, math.nan], nan_ok=True)
