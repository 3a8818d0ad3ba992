"""What a latched fault says: the reason, value and limit in words, and what to do."""

import math

import pytest

from hapkit_studio.haptics import arrays, block, health
from tests.haptics.support import BROKEN, CONSTANT, Bench


def words(code, value=0.0, position=0.0, line=0, **wanted):
    bench = Bench(CONSTANT, **wanted)
    bench.tick()
    bench.r.real[arrays.FAULT_VALUE], bench.r.real[arrays.FAULT_POSITION] = value, position
    bench.r.fault[1] = line
    fault = health.describe_fault(code, bench.r)
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
    bench = Bench(CONSTANT)
    assert health.describe_fault(arrays.NO_FAULT, bench.r) is None
    for code in range(arrays.NOT_A_NUMBER, arrays.SLOW_LINK + 1):
        assert health.describe_fault(code, bench.r).text


def test_the_limit_said_is_the_limit_in_force():
    assert "limit 1.5 m/s" in words(arrays.OVER_SPEED, 2.0, max_speed=1.5)


@pytest.mark.parametrize("how", ["index", "fuel"])
def test_the_line_said_is_the_law_s(how):
    bench = Bench(BROKEN, {"how": how})
    bench.tick(0.0)
    bench.tick(0.0055)
    text = health.describe_fault(int(bench.r.control[arrays.FAULT]), bench.r).text
    source = BROKEN.force.function.__code__
    line = int(text.split("line ")[1].split(" ")[0])
    with open(source.co_filename, encoding="utf-8") as file:
        said = file.readlines()[line - 1]
    assert ("s.cells[" if how == "index" else "for ") in said


def test_the_value_said_is_the_one_that_latched():
    bench = Bench(CONSTANT, max_speed=3.0)
    bench.run([0.0, 0.0034])
    assert bench.r.values[block.MAX_SPEED] == 3.0
    assert "3.4 m/s" in health.describe_fault(arrays.OVER_SPEED, bench.r).text


@pytest.mark.parametrize(("speed", "said"), [(3.4, "3.4"), (3.04, "3.04"), (3.0004, "3.0004")])
def test_a_speed_is_written_so_that_it_is_above_its_limit(speed, said):
    bench = Bench(CONSTANT, max_speed=3.0)
    rig_of = bench.r
    bench.tick()
    bench.tick(speed * 1e-3)
    assert (
        health.describe_fault(arrays.OVER_SPEED, rig_of).text
        == f"Fault: over-speed, {said} m/s (limit 3.0 m/s)."
    )


def test_no_two_reasons_share_a_code():
    codes = [
        *(arrays.NO_FAULT, arrays.NOT_A_NUMBER, arrays.LAW_INDEX, arrays.LAW_FUEL, arrays.LAW_DIVISION),
        *(
            arrays.OVER_SPEED,
            arrays.STALE_SENSOR,
            arrays.DEVICE_GONE,
            arrays.RUNAWAY,
            arrays.SLOW_LAW,
            arrays.SLOW_LINK,
        ),
    ]
    assert len(set(codes)) == len(codes)
