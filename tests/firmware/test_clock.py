"""The board's clock, in the simulated chip: every microsecond over every wrap of what it counts."""

import numpy as np

from tests.firmware.asked_chip import chip
from tests.firmware.test_firmware import SKETCH
from tests.firmware.vb import CHIPS, needs_compiler

pytestmark = needs_compiler

QUARTER, TICKS = 250, 2
"""us in a quarter of a millisecond; ticks of the timer in a us."""


def test_the_clock_goes_on_over_every_wrap(tmp_path):
    rng = np.random.default_rng(3)
    # after each sample, after a pause of up to 8 s, for an older sample than was asked for last
    more = np.concatenate([np.full(50, 4), rng.integers(0, 32768, 600), rng.integers(-32768, 0, 20)])
    quarters = np.cumsum(more)
    ticks = rng.integers(0, 8000, more.size)
    stamps = ((quarters % 65536) << 16 | ticks).astype(np.uint32)
    words = ("avr-g++", "-std=gnu++11", CHIPS / "clock.cpp", SKETCH / "clock_avr.S", f"-I{SKETCH}")
    for asked in chip(tmp_path, *words):
        found = asked(stamps.view(np.float32), np.zeros(more.size, np.float32)).view(np.uint32)
    assert quarters.max() * QUARTER > 2**31
    np.testing.assert_array_equal(found, (quarters * QUARTER + ticks // TICKS) % 2**32)


def test_the_clock_carries_within_a_period_into_its_highest_byte(tmp_path):
    # 216 us before 2^24 us
    quarters, ticks = np.array([30000, 60000, 67108, 67108]), np.array([0, 0, 431, 7999])
    assert (quarters[2] * QUARTER + ticks[2] // TICKS, quarters[3] * QUARTER < 2**24) == (2**24 - 1, True)
    stamps = ((quarters % 65536) << 16 | ticks).astype(np.uint32)
    words = ("avr-g++", "-std=gnu++11", CHIPS / "clock.cpp", SKETCH / "clock_avr.S", f"-I{SKETCH}")
    for asked in chip(tmp_path, *words):
        found = asked(stamps.view(np.float32), np.zeros(4, np.float32)).view(np.uint32)
    np.testing.assert_array_equal(found, quarters * QUARTER + ticks // TICKS)
