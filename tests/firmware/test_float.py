"""The firmware's own products, sums and tables in the simulated chip, against the computer's."""

import numpy as np
import pytest

from tests.firmware.asked_chip import chip
from tests.firmware.test_firmware import SKETCH
from tests.firmware.vb import CHIPS, needs_compiler

pytestmark = needs_compiler

SINE, COSINE, POWER, BELL = range(4)
OPERATION = ("avr-gcc", "-std=gnu11", CHIPS / "multiply.c")
EDGES = np.array(
    [0.0, -0.0, 1.0, -1.0, 2.0, 0.5, 1.0000001, 1.9999999, 3.4e38, -3.4e38, 1.2e-38, 1e-20, 1e20, 8388607.0,
     16777215.0, 0.1, -0.3], dtype=np.float32
)  # fmt: skip


@pytest.fixture(scope="module")
def multiply(tmp_path_factory):
    yield from chip(tmp_path_factory.mktemp("chip"), *OPERATION, "-DOP=*")


@pytest.fixture(scope="module", params="+-")
def combine(request, tmp_path_factory):
    for operation in chip(tmp_path_factory.mktemp("chip"), *OPERATION, f"-DOP={request.param}"):
        yield operation, np.add if request.param == "+" else np.subtract


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    words = ("avr-g++", "-std=gnu++11", CHIPS / "tables.cpp", SKETCH / "fast_avr.S", f"-I{SKETCH}")
    for calculated in chip(tmp_path_factory.mktemp("chip"), *words):
        yield lambda which, x, of=calculated: of(x, np.full_like(x, which)).astype(float)


def test_products_are_the_nearest_float_or_its_neighbour(multiply):
    rng = np.random.default_rng(7)
    a, b = (np.float32(rng.normal(size=800) * 10.0 ** rng.uniform(-8, 8, 800)) for _ in range(2))
    got, wanted = multiply(a, b), a * b
    apart = np.abs(got.view(np.int32).astype(np.int64) - wanted.view(np.int32))
    assert apart.max() <= 1
    assert np.mean(apart == 0) > 0.97


def test_edges(multiply):
    a, b = (m.ravel() for m in np.meshgrid(EDGES, EDGES))
    with np.errstate(all="ignore"):
        got, wanted = multiply(a, b), a * b
    small, large = np.abs(wanted) < 1.2e-38, ~np.isfinite(wanted)
    assert np.all(got[small] == 0.0)
    assert np.all(np.isnan(got[large]))
    rest = ~(small | large)
    np.testing.assert_allclose(got[rest], wanted[rest], rtol=1.3e-7)
    assert np.all(np.signbit(got[rest]) == np.signbit(wanted[rest]))


def test_what_is_not_finite_is_not_a_number(multiply):
    odd = np.array([np.nan, np.inf, -np.inf, 2.0], dtype=np.float32)
    assert np.all(np.isnan(multiply(odd[[0, 1, 2, 3, 3, 3]], odd[[3, 3, 3, 0, 1, 2]])))


def test_sums_are_the_nearest_float_or_its_neighbour(combine):
    operation, wanted_of = combine
    rng = np.random.default_rng(8)
    a = np.float32(rng.normal(size=600))
    b = np.float32(rng.normal(size=600) * 10.0 ** rng.uniform(-8, 8, 600))
    b[:150] = a[:150] * (1.0 + rng.integers(-9, 9, 150) * 2.0**-23)  # nearly all is lost
    got, wanted = operation(a, b), wanted_of(a, b)
    apart = np.abs(got.view(np.int32).astype(np.int64) - wanted.view(np.int32))
    assert apart.max() <= 1
    assert np.mean(apart == 0) > 0.97


def test_edges_of_sums(combine):
    operation, wanted_of = combine
    edges = np.float32(
        [0.0, -0.0, 1.0, -1.0, 1.0000001, 16777215.0, 1.2e-38, 3.4e38, -3.4e38, np.inf, -np.inf, np.nan]
    )
    a, b = (m.ravel() for m in np.meshgrid(edges, edges))
    with np.errstate(all="ignore"):
        np.testing.assert_array_equal(operation(a, b), wanted_of(a, b))


@pytest.mark.parametrize("operation", ["<", "<=", ">", ">=", "==", "!="])
def test_comparisons(tmp_path, operation):
    wanted_of = {"<": np.less, "<=": np.less_equal, ">": np.greater, ">=": np.greater_equal}
    wanted_of |= {"==": np.equal, "!=": np.not_equal}
    edges = np.float32([0.0, -0.0, 1.0, -1.0, 1.0000001, -1.0000001, 1e-40, -3e38, np.inf, -np.inf, np.nan])
    a, b = (m.ravel() for m in np.meshgrid(edges, edges))
    for compared in chip(tmp_path, *OPERATION, f"-DOP={operation}"):
        np.testing.assert_array_equal(compared(a, b), wanted_of[operation](a, b))


@pytest.fixture(scope="module")
def places():
    """Return numbers of every size up to 40, and whole, half and quarter ones."""
    rng = np.random.default_rng(9)
    some = rng.uniform(-40, 40, 150) * 10.0 ** rng.uniform(-9, 0, 150)
    return np.float32([*some, *np.arange(-4, 4, 0.25), 0.0, -0.0, 1e-30, -1e-30, 8388607.0, -1e9, 3e38])


def test_sines_of_turns(table, places):
    exact = places.astype(float) % 1.0 * (2 * np.pi)
    assert np.abs(table(SINE, places) - np.sin(exact)).max() < 4e-6
    assert np.abs(table(COSINE, places) - np.cos(exact)).max() < 4e-6


def test_powers_of_e(table, places):
    places = places[np.abs(places) < 80]
    exact = np.exp(places.astype(float))
    assert np.all(np.abs(table(POWER, places) - exact) < exact * (1.5e-6 + 2e-7 * np.abs(places)))
    assert np.abs(table(BELL, places) - np.exp(-18.0 * places.astype(float) ** 2)).max() < 3e-5


def test_tables_end_where_floats_do(table):
    odd = np.float32([np.nan, np.inf, -np.inf, 200.0, -200.0])
    assert np.all(np.isnan(table(SINE, odd[:3])))
    np.testing.assert_array_equal(table(POWER, odd[[0, 3, 4]]), [np.nan, np.inf, 0.0])
    np.testing.assert_array_equal(table(BELL, odd), [np.nan, 0.0, 0.0, 0.0, 0.0])
