"""What a latched fault says: the reason, value and limit in words, and what to do."""

import math

import pytest

from hapkit_studio.haptics import block, faults, rig
from tests.haptics.support import BROKEN, CONSTANT, Bench


def words(code, value=0.0, position=0.0, line=0, **wanted):
    bench = Bench(CONSTANT, **wanted)
    bench.tick()
    bench.r.real[rig.FAULT_VALUE], bench.r.real[rig.FAULT_POSITION] = value, position
    bench.r.fault[1] = line
    fault = faults.describe(code, bench.r)
    assert fault.code == code
    assert "\n" not in fault.text
    return f"{fault.text} {fault.detail}"


@pytest.mark.parametrize(
    ("code", "given", "said"),
    [
        (rig.OVER_SPEED, {"value": -3.4}, "Fault: over-speed, 3.4 m/s (limit 3.0 m/s). Force is zero."),
        (
            rig.NOT_A_NUMBER,
            {"value": math.nan, "position": 0.00502},
            "Fault: the law returned NaN at x = 5.02 mm. Force is zero.",
        ),
        (
            rig.NOT_A_NUMBER,
            {"value": -math.inf, "position": -0.001},
            "Fault: the law returned infinity at x = −1.00 mm. Force is zero.",
        ),
        (rig.LAW_INDEX, {"line": 14}, "Fault: line 14 of the law reaches beyond its state. Force is zero."),
        (rig.LAW_FUEL, {"line": 3}, "Fault: line 3 of the law does not come to an end. Force is zero."),
        (
            rig.STALE_SENSOR,
            {"value": rig.NO_SAMPLE},
            "Fault: no sensor frame for 20 ms, three times in 10 s. Force is zero. Cable or hub loose?",
        ),
        (
            rig.STALE_SENSOR,
            {"value": rig.AWAY},
            "Fault: this computer was busy elsewhere for 20 ms, three times in 10 s. Force is zero. Close",
        ),
        (
            rig.STALE_SENSOR,
            {"value": rig.HELD_UP},
            "Fault: the law held the loop up for 20 ms, three times in 10 s. Force is zero. Simplify the law",
        ),
        (
            rig.STALE_SENSOR,
            {"value": rig.CUT},
            "Fault: the board switched its motor off: forces came too late or not at all, three times",
        ),
        (
            rig.SLOW_LAW,
            {"value": 1.352e-3, "position": 1e-3},
            "Fault: the law takes 1.35 ms, a period 1.00 ms. Force is zero. Simplify the law",
        ),
        (
            rig.SLOW_LINK,
            {"value": 0.0334, "position": 0.025},
            "Fault: 33 ms from a sample to its force; the board obeys none after 25 ms. Force is zero. Let",
        ),
        (rig.SLOW_LINK, {"value": 0.0656, "position": 0.025}, "Fault: more than 66 ms from a sample"),
        (rig.RUNAWAY, {"value": 10_000.0}, "Fault: this machine cannot keep 10000 Hz. Force is zero."),
        (rig.DEVICE_GONE, {}, "The device is gone. Force is zero."),
    ],
)
def test_every_fault_has_its_words(code, given, said):
    assert words(code, **given).startswith(said)


def test_every_code_is_described():
    bench = Bench(CONSTANT)
    assert faults.describe(rig.NO_FAULT, bench.r) is None
    for code in range(rig.NOT_A_NUMBER, rig.SLOW_LINK + 1):
        assert faults.describe(code, bench.r).text


def test_the_limit_said_is_the_limit_in_force():
    assert "limit 1.5 m/s" in words(rig.OVER_SPEED, 2.0, max_speed=1.5)


@pytest.mark.parametrize("how", ["index", "fuel"])
def test_the_line_said_is_the_law_s(how):
    bench = Bench(BROKEN, {"how": how})
    bench.tick(0.0)
    bench.tick(0.0055)
    text = faults.describe(int(bench.r.control[rig.FAULT]), bench.r).text
    source = BROKEN.force.function.__code__
    line = int(text.split("line ")[1].split(" ")[0])
    with open(source.co_filename, encoding="utf-8") as file:
        said = file.readlines()[line - 1]
    assert ("s.cells[" if how == "index" else "for ") in said


def test_the_value_said_is_the_one_that_latched():
    bench = Bench(CONSTANT, max_speed=3.0)
    bench.run([0.0, 0.0034])
    assert bench.r.values[block.MAX_SPEED] == 3.0
    assert "3.4 m/s" in faults.describe(rig.OVER_SPEED, bench.r).text


@pytest.mark.parametrize(("speed", "said"), [(3.4, "3.4"), (3.04, "3.04"), (3.0004, "3.0004")])
def test_a_speed_is_written_so_that_it_is_above_its_limit(speed, said):
    bench = Bench(CONSTANT, max_speed=3.0)
    rig_of = bench.r
    bench.tick()
    bench.tick(speed * 1e-3)
    assert faults.describe(rig.OVER_SPEED, rig_of).text == f"Fault: over-speed, {said} m/s (limit 3.0 m/s)."


def test_no_two_reasons_share_a_code():
    codes = [
        *(rig.NO_FAULT, rig.NOT_A_NUMBER, rig.LAW_INDEX, rig.LAW_FUEL, rig.LAW_DIVISION),
        *(rig.OVER_SPEED, rig.STALE_SENSOR, rig.DEVICE_GONE, rig.RUNAWAY, rig.SLOW_LAW, rig.SLOW_LINK),
    ]
    assert len(set(codes)) == len(codes)
