"""The chip's assembler functions are called one by one: every operation, products, filters, frames."""

import numpy as np
import pytest

from hapkit_studio.laws.machine import OPERATIONS, Refusal
from hapkit_studio.protocol.framing import frame
from tests.firmware.chip_calls import Chip, ChipMachine, build, needs_compiler
from tests.laws import machine_pc
from tests.laws.random_code import BY_NAME, code, random_code

pytestmark = needs_compiler

ENTRY = 52
"""Number of cycles of run() besides its operations: it fills slots 0 and 1, finds MAIN, saves registers."""
SLOTS = 6
EDGES = np.array(
    [0.0, -0.0, 1e-40, -1e-40, 1.1754944e-38, -1.1754944e-38, 1.0, -1.0, 0.99999994, 1.0000001, 0.5,
     0.49999997, 3.4028235e38, -3.4028235e38, np.inf, -np.inf, np.nan, np.pi, 8388607.5, -8388608.0,
     16777216.0, 0.70710677, 0.70710683, 88.72283, -87.33654, 89.41, 134217728.0, 0.25, 1e-3,
     2.4414062e-04, -2.0, 3.0, -0.5],
    np.float32,
)  # fmt: skip


@pytest.fixture(scope="module")
def calls(tmp_path_factory):
    """Return the chip for calling functions."""
    folder = tmp_path_factory.mktemp("chip")
    build(folder)
    with Chip(folder) as found:
        yield found


@pytest.fixture(scope="module")
def chip(calls):
    """Return the machine on the chip."""
    return ChipMachine(calls)


@pytest.fixture(scope="module")
def computer():
    with machine_pc.Machine(machine_pc.build()) as found:
        yield found


def law_of(operation) -> bytes:
    """Return a law that applies one operation to x, or to x and v if it is binary."""
    if operation.operands == "":
        return code("MAIN", operation.name, "RETURN")
    if operation.operands == "ssn":
        return code("MAIN", operation.name, 1, 2, 3, "RETURN")
    if operation.operands in ("d", "sd"):
        return code("MAIN", operation.code | 15, *([1] if operation.operands == "sd" else []), 0, "RETURN")
    return code("MAIN", operation.name, 1, "RETURN")


CALCULATING = [o for o in OPERATIONS if o.code >= 0x10 and o.operands in ("", "s")]
MEASURED = [*CALCULATING, *(BY_NAME[name] for name in ("LOAD_AT", "STORE_AT", "COMPARE", "TEST"))]


def operands(rng, count: int) -> np.ndarray:
    """Return pairs (n, 2): random bits, typical sizes, nearly equal numbers, few bits, and edge cases."""
    part = count // 4
    bits = rng.integers(0, 2**32, (part, 2), dtype=np.uint32)
    usual = np.float32(rng.normal(size=(part, 2)) * 10.0 ** rng.uniform(-4, 3, (part, 2)))
    near = rng.integers(0, 2**32, part, dtype=np.uint32)
    beside = (near + rng.integers(-50, 51, part).astype(np.uint32)) ^ (
        rng.integers(0, 2, part).astype(np.uint32) << 31
    )
    few = np.float32(rng.integers(-40, 41, (part, 2)) * 2.0 ** rng.integers(-12, 13, (part, 2)))
    edges = np.stack(np.meshgrid(EDGES, EDGES), axis=-1).reshape(-1, 2)
    return np.concatenate(
        [bits.view(np.float32), usual, np.stack([near, beside], 1).view(np.float32), few, edges]
    )


def assert_same(found, wanted, rows):
    """Assert that results are equal bit by bit; all NaN count as equal."""
    same = (found.view(np.uint32) == wanted.view(np.uint32)) | (np.isnan(found) & np.isnan(wanted))
    assert same.all(), (rows[~same][:3], found[~same][:3], wanted[~same][:3])


@pytest.mark.slow
@pytest.mark.parametrize("operation", CALCULATING, ids=lambda o: o.name)
def test_results_have_the_same_bits_as_on_this_computer(chip, computer, rng, operation):
    rows, law = operands(rng, 2000), law_of(operation)
    assert chip.load(0, [], SLOTS, law) == computer.load(0, [], SLOTS, law)
    found, wanted = chip.run(rows)[0], computer.run(rows)[0]
    assert_same(found, wanted, rows)


@pytest.mark.slow
def test_random_code_gives_the_same_bits_in_assembler_in_cpp_and_here(chip, computer, rng):
    for _ in range(60):
        law = random_code(rng)
        loaded = computer.load(law.states, law.given, law.slots, law.code)
        assert chip.load(law.states, law.given, law.slots, law.code) == loaded
        if loaded.refusal:
            assert loaded.refusal == Refusal.TOO_SLOW
            continue
        rows = np.float32(rng.normal(size=(4, 2)) * 10.0 ** rng.uniform(-2, 1, (4, 1)))
        force, state = computer.run(rows)
        by_chip, by_state = chip.run(rows)
        assert np.all(chip.cycles <= loaded.cycles + ENTRY)
        slots = chip.slots()
        chip.load(law.states, law.given, law.slots, law.code)
        plainly, plain_state = chip.run(rows, plainly=True)
        assert_same(by_chip, force, rows)
        assert_same(plainly, force, rows)
        assert_same(by_state.ravel(), state.ravel(), rows)
        assert_same(plain_state.ravel(), state.ravel(), rows)
        assert_same(chip.slots(), slots, rows)


def changed(rng, rows: np.ndarray, count: int) -> np.ndarray:
    """Return rows with some of their bits changed."""
    bits = rows[rng.integers(len(rows), size=count)].view(np.uint32).copy()
    flips = np.uint32(1) << rng.integers(0, 32, bits.shape).astype(np.uint32)
    bits ^= np.where(rng.random(bits.shape) < 0.5, flips, 0).astype(np.uint32)
    bits += np.where(rng.random(bits.shape) < 0.3, rng.integers(-3, 4, bits.shape), 0).astype(np.uint32)
    return bits.view(np.float32)


@pytest.mark.slow
@pytest.mark.parametrize("operation", MEASURED, ids=lambda o: o.name)
def test_no_operands_take_longer_than_the_tables_worst_case(chip, rng, operation):
    law, rows = law_of(operation), operands(rng, 2000)
    chip.load(0, [], SLOTS, code("MAIN", "RETURN"))
    chip.run([[0.0, 0.0]])
    rest = int(chip.cycles[0])
    assert rest == ENTRY + BY_NAME["RETURN"].most
    chip.load(0, [], SLOTS, law)
    chip.run(rows)
    cycles = chip.cycles - rest
    for _ in range(12):  # search from the slowest rows to their neighbours
        best = rows[np.argsort(cycles)[-30:]]
        rows = np.concatenate([best, changed(rng, best, 300)])
        chip.run(rows)
        cycles = chip.cycles - rest
    assert cycles.max() <= operation.most
    assert operation.most <= 1.15 * cycles.max() + 4, "the table says much more than there is"


@pytest.mark.parametrize(
    "law",
    [
        ("MAIN", "LOAD", 1, "STORE", 5, "JUMP", 0, "FAR_JUMP", 0, 0, "RETURN"),
        ("SUBROUTINE", "RETURN", "MAIN", "LOOP", 0, 5, 0, "CALL", 0, 0, "NEXT", 0, 7, 0, "RETURN"),
    ],
)
def test_operations_with_constant_time_take_exactly_the_tables_cycles(chip, law):
    loaded = chip.load(0, [], SLOTS, code(*law))
    chip.run([[1.0, 2.0]])
    assert chip.cycles[0] == ENTRY + loaded.cycles


def exactly(operation, rows):
    """Return the result of the operation in double precision."""
    a, s = rows[:, 0].astype(float), rows[:, 1].astype(float)
    functions = {
        "ADD": a + s, "SUBTRACT": a - s, "SUBTRACT_FROM": s - a, "MULTIPLY": a * s, "DIVIDE": a / s,
        "DIVIDE_INTO": s / a, "MINIMUM": np.where(s < a, s, a), "MAXIMUM": np.where(s > a, s, a),
        "FLOOR_DIVIDE": np.floor_divide(a, s), "MODULO": np.mod(a, s), "REMAINDER": np.fmod(a, s),
        "POWER": np.power(a, s), "ATAN2": np.arctan2(a, s), "HYPOT": np.hypot(a, s),
        "COPYSIGN": np.copysign(a, s), "NEGATE": -a, "ABSOLUTE": np.abs(a), "SQRT": np.sqrt(a),
        "FLOOR": np.floor(a), "CEIL": np.ceil(a), "TRUNCATE": np.trunc(a), "SIN": np.sin(a), "COS": np.cos(a),
        "TAN": np.tan(a), "ASIN": np.arcsin(a), "ACOS": np.arccos(a), "ATAN": np.arctan(a), "EXP": np.exp(a),
        "EXPM1": np.expm1(a), "LOG": np.log(a), "LOG1P": np.log1p(a), "SINH": np.sinh(a), "COSH": np.cosh(a),
        "TANH": np.tanh(a),
    }  # fmt: skip
    return functions[operation.name]


ROUNDED = 2.0**-24
CLOSE = {
    "SIN": 2e-5, "COS": np.inf, "TAN": 2e-5, "ASIN": 3e-7, "ACOS": 2e-7, "ATAN": 2e-7, "ATAN2": 2e-7,
    "EXP": 2e-7, "EXPM1": 2e-7, "LOG": 2e-7, "LOG1P": 3e-7, "SINH": 3e-7, "COSH": 2e-7, "TANH": 4e-7,
    "POWER": 5e-6, "HYPOT": 2e-7,
}  # fmt: skip
"""Largest relative error of each result; other operations are correctly rounded."""


@pytest.mark.parametrize("operation", CALCULATING, ids=lambda o: o.name)
def test_results_are_as_exact_as_floats_permit(chip, rng, operation):
    rows = np.float32(rng.uniform(-1.5, 1.5, (1500, 2)) * 10.0 ** rng.choice([-6, -3, -1, 0], (1500, 2)))
    chip.load(0, [], SLOTS, law_of(operation))
    found = chip.run(rows)[0].astype(float)
    with np.errstate(all="ignore"):
        wanted = exactly(operation, rows)
    held = np.isfinite(wanted) & (np.abs(wanted) < 3e38) & ((np.abs(wanted) > 1e-37) | (wanted == 0.0))
    if operation.name in ("FLOOR_DIVIDE", "MODULO", "REMAINDER"):
        held &= np.abs(rows[:, 0].astype(float) / rows[:, 1]) < 2.0**23
    assert held.sum() > 300
    error = np.abs(found - wanted)[held]
    assert np.all(error <= CLOSE.get(operation.name, ROUNDED) * np.abs(wanted[held]) + 1e-45)
    if operation.name in ("SIN", "COS"):
        assert error.max() < 1e-7
    with np.errstate(all="ignore"):
        assert np.all(np.isnan(found[np.isnan(wanted)]))


def test_sines_of_many_turns_are_accurate(chip, rng):
    x = np.float32(rng.uniform(-300.0, 300.0, 2000))
    rows = np.stack([x, np.zeros_like(x)], 1)
    for name, function in (("SIN", np.sin), ("COS", np.cos)):
        chip.load(0, [], SLOTS, code("MAIN", name, "RETURN"))
        found = chip.run(rows)[0].astype(float)
        # the error is less than the rounding error of the angle itself
        assert np.all(np.abs(found - function(x.astype(float))) <= 1e-7 + ROUNDED * np.abs(x))


ENDS = [
    ("EXP", 1000.0, 0.0, np.inf), ("EXP", -1000.0, 0.0, 0.0), ("EXP", np.nan, 0.0, np.nan),
    ("EXP", 0.0, 0.0, 1.0), ("LOG", 0.0, 0.0, -np.inf), ("LOG", -1.0, 0.0, np.nan),
    ("LOG", np.inf, 0.0, np.inf), ("LOG", 1.0, 0.0, 0.0), ("SQRT", -1.0, 0.0, np.nan),
    ("SQRT", np.inf, 0.0, np.inf), ("SIN", np.inf, 0.0, np.nan), ("COS", np.nan, 0.0, np.nan),
    ("COS", 0.0, 0.0, 1.0), ("TAN", -np.inf, 0.0, np.nan), ("ASIN", 1.1, 0.0, np.nan),
    ("ACOS", -1.1, 0.0, np.nan), ("ACOS", 1.0, 0.0, 0.0), ("ATAN", np.inf, 0.0, np.pi / 2),
    ("ATAN2", 0.0, -1.0, np.pi), ("ATAN2", -0.0, -1.0, -np.pi), ("ATAN2", np.inf, np.inf, np.pi / 4),
    ("TANH", np.inf, 0.0, 1.0), ("TANH", -np.inf, 0.0, -1.0), ("SINH", -np.inf, 0.0, -np.inf),
    ("COSH", -np.inf, 0.0, np.inf), ("EXPM1", -np.inf, 0.0, -1.0), ("LOG1P", -1.0, 0.0, -np.inf),
    ("POWER", -2.0, 3.0, -8.0), ("POWER", -2.0, 0.5, np.nan), ("POWER", 0.0, -1.0, np.inf),
    ("POWER", np.nan, 0.0, 1.0), ("POWER", 1.0, np.nan, 1.0), ("POWER", -1.0, np.inf, 1.0),
    ("POWER", 0.5, np.inf, 0.0), ("HYPOT", np.inf, np.nan, np.inf), ("HYPOT", 3e38, 3e38, np.inf),
    ("HYPOT", 3e-30, 4e-30, 5e-30), ("DIVIDE", 1.0, 0.0, np.nan), ("DIVIDE", 1e38, 1e-10, np.inf),
    ("MULTIPLY", 1e30, 1e30, np.inf), ("MULTIPLY", 1e-30, 1e-30, 0.0),
    ("MULTIPLY", np.inf, 0.0, np.nan), ("ADD", np.inf, -np.inf, np.nan), ("ADD", 3e38, 3e38, np.inf),
    ("FLOOR_DIVIDE", -7.0, 2.0, -4.0), ("MODULO", -7.0, 2.0, 1.0), ("MODULO", 7.0, -2.0, -1.0),
    ("REMAINDER", -7.0, 2.0, -1.0), ("MODULO", 1e30, 3.0, 0.0), ("REMAINDER", np.inf, 3.0, np.nan),
    ("MODULO", 5.0, np.inf, 5.0), ("FLOOR", -0.5, 0.0, -1.0), ("CEIL", -0.5, 0.0, -0.0),
    ("TRUNCATE", -1.5, 0.0, -1.0), ("MINIMUM", 1.0, np.nan, 1.0), ("MAXIMUM", 1.0, np.nan, 1.0),
    ("MINIMUM", np.nan, 1.0, np.nan),
]  # fmt: skip


@pytest.mark.parametrize(("name", "a", "s", "wanted"), ENDS)
def test_operations_at_the_limits_of_the_range(chip, name, a, s, wanted):
    chip.load(0, [], SLOTS, law_of(BY_NAME[name]))
    found = chip.run([[a, s]])[0]
    np.testing.assert_allclose(found, [np.float32(wanted)], rtol=5e-6)


# --- multiplication of an integer by a float
SMALLEST, LARGEST = np.finfo(np.float32).tiny, np.finfo(np.float32).max
WHOLE = 2**24
"""Floats represent every integer up to here; larger ones are truncated."""
INTEGERS = np.array(
    [0, 1, -1, 2, 255, 256, -256, 65535, 65536, -65537, WHOLE - 1, WHOLE, WHOLE + 1, -WHOLE - 1, 2**25 - 1,
     2**30, 2**31 - 1, -(2**31) + 1, -(2**31)], dtype=np.int32
)  # fmt: skip
FACTORS = np.float32([1.0, 0.5, 1 / 3, 1.9999999, 1.0000001, 20.7e-6, 1e-7, 2e-3, 3e-30, 8e27])


def products(calls, value, factor):
    """Return the chip's products, and their errors in units of the last bit (n,)."""
    found = calls.call("times", value.view(np.float32), factor)[0]
    exact = value.astype(float) * factor.astype(float)
    off = np.abs(found.astype(float) - exact) / np.spacing(np.abs(exact).astype(np.float32)).astype(float)
    return found, off


def test_an_integer_times_a_float_has_an_error_of_at_most_a_last_bit(calls, rng):
    value = (rng.choice([-1, 1], 700) * np.floor(2.0 ** rng.uniform(0, 24, 700))).astype(np.int32)
    _, off = products(calls, value, np.float32(10.0 ** rng.uniform(-25, 25, 700)))
    assert off.max() <= 1.0
    assert np.mean(off <= 0.5001) > 0.97
    # most of these integers exceed a float's precision
    large = rng.integers(-(2**31), 2**31, 400).astype(np.int32)
    assert products(calls, large, np.float32(10.0 ** rng.uniform(-25, 25, 400)))[1].max() <= 2.5
    whole = rng.integers(-WHOLE, WHOLE + 1, 200).astype(np.int32)
    np.testing.assert_array_equal(products(calls, whole, np.ones(200, np.float32))[0], whole)


def test_products_at_the_limits_of_both_operands(calls):
    value, factor = (m.ravel() for m in np.meshgrid(INTEGERS, FACTORS))
    zero = value == 0
    np.testing.assert_array_equal(products(calls, value[zero], factor[zero])[0].view(np.uint32), 0)
    found, off = products(calls, value[~zero], factor[~zero])
    assert off[np.abs(value[~zero].astype(np.int64)) <= WHOLE].max() <= 1.0
    assert off.max() <= 2.5
    np.testing.assert_array_equal(np.sign(found), np.sign(value[~zero]))


def test_products_from_the_smallest_float_to_beyond_the_largest(calls):
    most, least = np.int32(2**31 - 1), np.int32(-(2**31))
    value = np.array([1, -1, 1, 2, 3, -3, most, least, most, least, 2], np.int32)
    half = np.float32(2.0**-31) * LARGEST
    factor = np.float32([SMALLEST] * 2 + [SMALLEST * 1.5] * 2 + [2.0**-126] * 2 + [half, half])
    factor = np.append(factor, np.float32([2.0**98, 2.0**98, LARGEST]))
    found = calls.call("times", value.view(np.float32), factor)[0]
    exact = value.astype(float) * factor.astype(float)
    fits = np.abs(exact) <= LARGEST
    np.testing.assert_allclose(found[fits], exact[fits], rtol=2.5e-7)
    np.testing.assert_array_equal(found[~fits], np.copysign(np.inf, exact[~fits]))
    assert 1 <= np.sum(~fits) < value.size


# --- a filter's multiplication and the bytes of a frame agree with C++
WRITER, BODY, CODED = 0x700, 0x710, 0x780
"""Unused addresses in the chip's memory."""
LONGEST_BODY = 72


def share(value, half):
    """Return the results of estimator::share in C++ (n,) for uint32 values (n,)."""
    value, half = value.astype(np.uint64), half.astype(np.uint64)
    high, low, large, small = value >> 16, value & 0xFFFF, half >> 16, half & 0xFFFF
    total = high * large + (low * large >> 16) + (high * small >> 16)
    total -= np.where(high & 0x8000, half, 0)
    return (total << 1).astype(np.uint32)


def test_a_filters_multiplication_agrees_to_the_last_bit(calls, rng):
    size = rng.integers(0, 33, (2, 3000)).astype(np.uint64)
    value, half = (rng.integers(0, 1 << 32, (2, 3000), dtype=np.uint64) >> (32 - size)).astype(np.uint32)
    edges = np.uint32([0, 1, 0xFFFF, 0x10000, 0x7FFFFFFF, 0x80000000, 0xFFFF0000, 0xFFFFFFFF])
    value = np.append(np.where(rng.random(3000) < 0.5, value, -value.view(np.int32)), np.repeat(edges, 8))
    value, half = value.astype(np.int64).astype(np.uint32), np.append(half, np.tile(edges, 8))
    found, cycles = calls.call("estimator_share", value, half)
    np.testing.assert_array_equal(found, share(value, half))
    assert cycles.max() < 110
    near = value.view(np.int32) * (half / 2.0**31)
    fits = np.abs(near) < 2.0**30
    assert fits.sum() > 1000
    low = near[fits] - found[fits].view(np.int32)
    assert low.min() >= 0.0
    assert low.max() < 6.0


def written(calls, body: bytes, *parts: int) -> bytes:
    """Return the chip's frame of a body that is written in parts of these sizes."""
    start = b"\xff\xff" + CODED.to_bytes(2, "little") + (CODED + 1).to_bytes(2, "little")
    calls.write(WRITER, start)
    at = 0
    for size in parts:
        put(calls, body[at : at + size])
        at += size
    put(calls, body[at:])
    put(calls, calls.read(WRITER, 2))
    state = calls.read(WRITER, 6)
    code, end = int.from_bytes(state[2:4], "little"), int.from_bytes(state[4:6], "little")
    coded = bytearray(calls.read(CODED, end - CODED))
    coded[code - CODED] = end - code
    return bytes(coded) + b"\0"


def put(calls, data: bytes) -> None:
    calls.write(BODY, data or b"\0")
    place = np.array([WRITER << 16 | BODY], np.uint32)
    calls.call("frame_put", place, np.array([len(data) << 16], np.uint32))


def test_a_frame_equals_the_computers_encoding_of_its_body(calls, rng):
    for size in range(1, LONGEST_BODY + 1):
        body = (rng.integers(0, 256, size) * (rng.random(size) < 0.7)).astype(np.uint8).tobytes()
        assert written(calls, body, *rng.integers(0, size + 1, 1)) == frame(body)
