"""An integer times a float in one go, in the simulated chip, against the same in double precision."""

import numpy as np
import pytest

from tests.firmware.chip_calls import Chip, build, needs_compiler

pytestmark = needs_compiler

SMALLEST, LARGEST = np.finfo(np.float32).tiny, np.finfo(np.float32).max
WHOLE = 2**24
"""Up to here a float holds every integer; of a larger one, what it cannot hold is cut off."""
EDGES = np.array(
    [0, 1, -1, 2, 255, 256, -256, 65535, 65536, -65537, WHOLE - 1, WHOLE, WHOLE + 1, -WHOLE - 1, 2**25 - 1,
     2**30, 2**31 - 1, -(2**31) + 1, -(2**31)], dtype=np.int32
)  # fmt: skip
FACTORS = np.float32([1.0, 0.5, 1 / 3, 1.9999999, 1.0000001, 20.7e-6, 1e-7, 2e-3, 3e-30, 8e27])


@pytest.fixture(scope="module")
def product(tmp_path_factory):
    """Return a function that asks the chip: (n,) int32 times (n,) float32."""
    folder = tmp_path_factory.mktemp("chip")
    build(folder)
    with Chip(folder) as chip:
        yield lambda value, factor: chip.call("times", value.view(np.float32), factor)[0]


def off(got, value, factor):
    """Return how far products are from the exact ones, in units of their last bit (n,)."""
    exact = value.astype(float) * factor.astype(float)
    return np.abs(got.astype(float) - exact) / np.spacing(np.abs(exact).astype(np.float32)).astype(float)


def test_integers_that_a_float_holds_are_rounded_to_it_or_its_neighbour(product):
    rng = np.random.default_rng(11)
    size = rng.uniform(0, 24, 700)
    value = (rng.choice([-1, 1], 700) * np.floor(2.0**size)).astype(np.int32)
    factor = np.float32(10.0 ** rng.uniform(-25, 25, 700))
    far = off(product(value, factor), value, factor)
    assert far.max() <= 1.0
    assert np.mean(far <= 0.5001) > 0.97


def test_larger_integers_lose_less_than_a_last_bit_more(product):
    rng = np.random.default_rng(12)
    value = rng.integers(-(2**31), 2**31, 400).astype(np.int32)
    factor = np.float32(10.0 ** rng.uniform(-25, 25, 400))
    assert (np.abs(value.astype(np.int64)) > WHOLE).mean() > 0.9
    assert off(product(value, factor), value, factor).max() <= 2.5


def test_edges(product):
    value, factor = (m.ravel() for m in np.meshgrid(EDGES, FACTORS))
    got = product(value, factor)
    zero = value == 0
    np.testing.assert_array_equal(got[zero].view(np.uint32), 0)
    far = off(got[~zero], value[~zero], factor[~zero])
    whole = np.abs(value[~zero].astype(np.int64)) <= WHOLE
    assert far[whole].max() <= 1.0
    assert far.max() <= 2.5
    np.testing.assert_array_equal(np.sign(got), np.sign(value))


def test_one_gives_the_integer_itself(product):
    rng = np.random.default_rng(13)
    value = np.append(rng.integers(-WHOLE, WHOLE + 1, 200), [1, -1, WHOLE, -WHOLE]).astype(np.int32)
    np.testing.assert_array_equal(product(value, np.ones(value.size, np.float32)), value)


def test_from_the_smallest_float_to_beyond_the_largest(product):
    most, least = np.int32(2**31 - 1), np.int32(-(2**31))
    value = np.array([1, -1, 1, 2, 3, -3, most, least, most, least, 2], np.int32)
    half = np.float32(2.0**-31) * LARGEST
    factor = np.float32([SMALLEST] * 2 + [SMALLEST * 1.5] * 2 + [2.0**-126] * 2 + [half, half])
    factor = np.append(factor, np.float32([2.0**98, 2.0**98, LARGEST]))
    got = product(value, factor)
    exact = value.astype(float) * factor.astype(float)
    fits = np.abs(exact) <= LARGEST
    np.testing.assert_allclose(got[fits], exact[fits], rtol=2.5e-7)
    np.testing.assert_array_equal(got[~fits], np.copysign(np.inf, exact[~fits]))
    assert 1 <= np.sum(~fits) < value.size
