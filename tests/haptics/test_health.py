"""The histogram of the loop's lateness, and the messages about latched faults."""

import math

import numpy as np
import pytest

from hapkit_studio.haptics import arrays, health
from tests.haptics.support import BROKEN, CONSTANT, LoopHarness


def filled(lateness):
    bins = health.new_histogram()
    for value in lateness:
        health.add_lateness(bins, float(value))
    return bins


def width(us):
    return 1.0 if us < 1e3 else 10.0 if us < 1e4 else 100.0


@pytest.mark.parametrize("median", [5e-6, 40e-6, 2e-3, 20e-3])
def test_percentiles_are_those_of_numpy(median, rng):
    lateness = median * np.exp(rng.normal(0.0, 0.4, 5000))
    found = health.lateness_percentiles(filled(lateness))
    for name, q in (("p50", 50.0), ("p99", 99.0), ("p99.9", 99.9), ("max", 100.0)):
        exact = 1e6 * np.percentile(lateness, q, method="inverted_cdf")
        assert exact <= found[name] <= exact + width(exact) * (1.0 + 1e-9)


def test_every_lateness_is_counted_in_its_bin():
    us = np.concatenate(
        (np.arange(1000) + 0.5, 1000 + 10 * np.arange(900) + 5, 1e4 + 100 * np.arange(900) + 50)
    )
    bins = filled(1e-6 * us)
    assert bins[-1] == 0
    np.testing.assert_array_equal(bins[:-1], 1)
    np.testing.assert_allclose(health.LATENESS_EDGES_US[:-1] - us, [width(u) / 2.0 for u in us])


@pytest.mark.parametrize("lateness", [0.1, 5.0, np.inf, np.nan])
def test_values_beyond_the_bins_are_counted_as_overflow(lateness):
    assert filled([lateness])[-1] == 1
    assert health.lateness_percentiles(filled([1e-5, lateness]))["max"] == 100_000.0


HOLD, STALE = "Hold the handle, then clear the fault.", arrays.STALE_SENSOR
# columns: code, value, position in m, line of the law, message, remedy
# fmt: off
WORDS = [
    (arrays.OVER_SPEED, -3.4, 0.0, 0, "the handle moved too fast, 3.4 m/s (limit 3.0 m/s).", HOLD),
    (arrays.OVER_SPEED, 3.04, 0.0, 0, "the handle moved too fast, 3.04 m/s (limit 3.0 m/s).", HOLD),
    (arrays.OVER_SPEED, 3.0004, 0.0, 0, "the handle moved too fast, 3.0004 m/s (limit 3.0 m/s).", HOLD),
    (arrays.NOT_A_NUMBER, math.nan, 0.00502, 0, "the law returned NaN (not a number) at x = 5.02 mm.", HOLD),
    (arrays.NOT_A_NUMBER, -math.inf, -0.001, 7, "the law returned infinity at x = −1.00 mm (line 7).", HOLD),
    (arrays.LAW_INDEX, 0.0, 0.0, 14, "line 14 of the law uses an index outside the state or table.", HOLD),
    (arrays.LAW_FUEL, 0.0, 0.0, 3, "the loop or function in line 3 of the law does not end.", HOLD),
    (arrays.LAW_DIVISION, 0.0, 0.001, 3, "line 3 of the law divides by zero at x = 1.00 mm.", HOLD),
    (STALE, arrays.NO_SAMPLE, 0.0, 0, "no sensor reading arrived for 20 ms, three times in 10 s.", "Check"),
    (STALE, arrays.AWAY, 0.0, 0,
     "this computer was busy with other programs for 20 ms, three times in 10 s.", "Close"),
    (STALE, arrays.LAW_BLOCKED, 0.0, 0,
     "the law kept the loop waiting for 20 ms, three times in 10 s.", "Simplify"),
    (STALE, arrays.CLOCK_JUMP, 0.0, 0, "the board's clock jumped, three times in 10 s.", "Update"),
    (STALE, arrays.CUT, 0.0, 0,
     "the board switched its motor off: forces came too late or not at all, three times in 10 s.", "Check"),
    (arrays.SLOW_LAW, 1.352e-3, 1e-3, 0, "the law takes 1.35 ms, but the period is 1 ms.", "Simplify"),
    (arrays.SLOW_LAW, 0.0711e-3, 0.0625e-3, 0,
     "the law takes 0.0711 ms, but the period is 0.0625 ms.", "Simplify"),
    (arrays.SLOW_LINK, 0.0334, 0.025, 0,
     "a force came 33 ms after its sample; the board rejects forces older than 25 ms.", "Let the board"),
    (arrays.SLOW_LINK, 0.0656, 0.025, 0,
     "a force came more than 66 ms after its sample; the board rejects forces older than 25 ms.", "Let the"),
    (arrays.RUNAWAY, 10_000.0, 0.0, 0,
     "this computer cannot keep the servo rate of 10,000 Hz.", "Lower the servo rate"),
    (arrays.DEVICE_GONE, 0.0, 0.0, 0, "The device is disconnected.", "Nothing is lost."),
    (arrays.DEVICE_GONE, 1.0, 0.0, 0,
     "The board has sent nothing for 1 s: it restarted or froze.", "Nothing is lost."),
]
# fmt: on


@pytest.mark.parametrize(("code", "value", "position", "line", "text", "remedy"), WORDS)
def test_every_fault_has_its_message(code, value, position, line, text, remedy):
    harness = LoopHarness(CONSTANT, max_speed=3.0)
    harness.tick()
    harness.r.tick.fault_value, harness.r.tick.fault_position = value, position
    harness.r.fault[1] = line
    fault = health.describe_fault(code, harness.r)
    assert fault.code == code
    assert fault.text == (text if code == arrays.DEVICE_GONE else f"Fault: {text}")
    assert fault.detail.startswith(f"Force is zero. {remedy}")


def test_every_code_is_described():
    harness = LoopHarness(CONSTANT)
    assert health.describe_fault(arrays.NO_FAULT, harness.r) is None
    assert {code for code, *_ in WORDS} == set(range(arrays.NOT_A_NUMBER, arrays.SLOW_LINK + 1))


@pytest.mark.parametrize("how", ["index", "fuel"])
def test_the_reported_line_is_the_laws(how):
    harness = LoopHarness(BROKEN, {"how": how})
    harness.tick(0.0)
    harness.tick(0.0055)
    text = health.describe_fault(int(harness.r.control.fault[0]), harness.r).text
    source = BROKEN.force.function.__code__
    line = int(text.split("line ")[1].split(" ")[0])
    with open(source.co_filename, encoding="utf-8") as file:
        source_line = file.readlines()[line - 1]
    assert ("s.cells[" if how == "index" else "for ") in source_line
