"""The lateness histogram, and what a latched fault says."""

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
def test_what_lies_beyond_is_counted_as_beyond(lateness):
    assert filled([lateness])[-1] == 1
    assert health.lateness_percentiles(filled([1e-5, lateness]))["max"] == 100_000.0


def words(code, value=0.0, position=0.0, line=0, **wanted):
    harness = LoopHarness(CONSTANT, **wanted)
    harness.tick()
    harness.r.real[arrays.FAULT_VALUE], harness.r.real[arrays.FAULT_POSITION] = value, position
    harness.r.fault[1] = line
    fault = health.describe_fault(code, harness.r)
    assert fault.code == code
    assert "\n" not in fault.text
    return f"{fault.text} {fault.detail}"


@pytest.mark.parametrize(
    ("code", "given", "said"),
    [
        (arrays.OVER_SPEED, {"value": -3.4}, "Fault: over-speed, 3.4 m/s (limit 3.0 m/s). Force is zero."),
        (
            arrays.NOT_A_NUMBER,
            {"value": math.nan, "position": 0.00502},
            "Fault: the law returned NaN at x = 5.02 mm. Force is zero.",
        ),
        (
            arrays.NOT_A_NUMBER,
            {"value": -math.inf, "position": -0.001},
            "Fault: the law returned infinity at x = −1.00 mm. Force is zero.",
        ),
        (
            arrays.LAW_INDEX,
            {"line": 14},
            "Fault: line 14 of the law reaches beyond its state. Force is zero.",
        ),
        (arrays.LAW_FUEL, {"line": 3}, "Fault: line 3 of the law does not come to an end. Force is zero."),
        (
            arrays.STALE_SENSOR,
            {"value": arrays.NO_SAMPLE},
            "Fault: no sensor frame for 20 ms, three times in 10 s. Force is zero. Cable or hub loose?",
        ),
        (
            arrays.STALE_SENSOR,
            {"value": arrays.AWAY},
            "Fault: this computer was busy elsewhere for 20 ms, three times in 10 s. Force is zero. Close",
        ),
        (
            arrays.STALE_SENSOR,
            {"value": arrays.HELD_UP},
            "Fault: the law held the loop up for 20 ms, three times in 10 s. Force is zero. Simplify the law",
        ),
        (
            arrays.STALE_SENSOR,
            {"value": arrays.CUT},
            "Fault: the board switched its motor off: forces came too late or not at all, three times",
        ),
        (
            arrays.SLOW_LAW,
            {"value": 1.352e-3, "position": 1e-3},
            "Fault: the law takes 1.35 ms, a period 1.00 ms. Force is zero. Simplify the law",
        ),
        (
            arrays.SLOW_LINK,
            {"value": 0.0334, "position": 0.025},
            "Fault: 33 ms from a sample to its force; the board obeys none after 25 ms. Force is zero. Let",
        ),
        (arrays.SLOW_LINK, {"value": 0.0656, "position": 0.025}, "Fault: more than 66 ms from a sample"),
        (arrays.RUNAWAY, {"value": 10_000.0}, "Fault: this machine cannot keep 10000 Hz. Force is zero."),
        (arrays.DEVICE_GONE, {}, "The device is gone. Force is zero."),
    ],
)
def test_every_fault_has_its_words(code, given, said):
    assert words(code, **given).startswith(said)


def test_every_code_is_described():
    harness = LoopHarness(CONSTANT)
    assert health.describe_fault(arrays.NO_FAULT, harness.r) is None
    for code in range(arrays.NOT_A_NUMBER, arrays.SLOW_LINK + 1):
        assert health.describe_fault(code, harness.r).text


@pytest.mark.parametrize("how", ["index", "fuel"])
def test_the_line_said_is_the_law_s(how):
    harness = LoopHarness(BROKEN, {"how": how})
    harness.tick(0.0)
    harness.tick(0.0055)
    text = health.describe_fault(int(harness.r.control[arrays.FAULT]), harness.r).text
    source = BROKEN.force.function.__code__
    line = int(text.split("line ")[1].split(" ")[0])
    with open(source.co_filename, encoding="utf-8") as file:
        said = file.readlines()[line - 1]
    assert ("s.cells[" if how == "index" else "for ") in said


@pytest.mark.parametrize(("speed", "said"), [(3.4, "3.4"), (3.04, "3.04"), (3.0004, "3.0004")])
def test_a_speed_is_written_so_that_it_is_above_its_limit(speed, said):
    harness = LoopHarness(CONSTANT, max_speed=3.0)
    rig_of = harness.r
    harness.tick()
    harness.tick(speed * 1e-3)
    assert (
        health.describe_fault(arrays.OVER_SPEED, rig_of).text
        == f"Fault: over-speed, {said} m/s (limit 3.0 m/s)."
    )
