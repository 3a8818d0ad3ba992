"""The log of a recording's settings has readable lines without loss, for any content."""

import json

import pytest

import hapkit_studio as hs
from hapkit_studio import settings_log
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.errors import FileError
from hapkit_studio.haptics.engine import Engine
from hapkit_studio.sessions import settings_events

WALL = {
    "environment": "wall",
    "parameters": {"stiffness": 250.0, "side": "left"},
    "units": {"stiffness": "N/m"},
    "rate_Hz": 1000.0,
    "delay_s": 1e-3,
    "estimator": ("iir", {"cutoff": 20.0}),
    "controller": False,
    "device": {"mass": 0.044, "end_stops": "inf"},
    "seed": 3,
    "state_names": ["count"],
}


def stiffer(value, **more):
    return {**WALL, "parameters": {**WALL["parameters"], "stiffness": value}, **more}


def test_each_setting_is_a_line_with_its_unit_and_each_change_one_with_its_time():
    log = [(0.0, WALL), (1.25, stiffer(600.0, estimator="kalman")), (2.5, stiffer(600.0, estimator="kalman"))]
    assert settings_log.lines(log) == [
        "# environment: wall",
        "# stiffness: 250 N/m",
        "# side: left",
        "# rate: 1000 Hz",
        "# delay: 0.001 s",
        "# estimator: iir",
        "# estimator.cutoff: 20 Hz",
        "# controller: false",
        "# device.mass: 0.044 kg",
        "# device.end_stops: inf m",
        "# seed: 3",
        "# stiffness at 1.25 s: 600 N/m",
        "# estimator at 1.25 s: kalman",
    ]


def test_json_has_the_first_settings_and_each_change_with_its_time():
    found = json.loads(settings_log.as_json([(0.0, WALL), (1.25, stiffer(600.0))]))
    assert found["parameters"] == WALL["parameters"]
    assert found["changes"] == [{"time_s": 1.25, "parameters": {"stiffness": 600.0}}]


def read(log):
    return settings_log.read([line.removeprefix("#") for line in settings_log.lines(log)])


ODD = {
    "rate": 7.0, "device": 8.0, "parameter": 1.5, "rate_Hz": 2.0, "größe": 1e-300, "at": -3.25,
    "number": "2", "truth": "true", "text": "5 mm", "list": "[1]", "empty": "", "spaces": " a ",
    "lines": "a\nb\x1b[8m", "colon": "a: b", "quotes": '"', "third": 1.0 / 3.0,
}  # fmt: skip


def test_any_parameter_name_and_value_round_trips():
    """Names may equal names of settings, and texts may look like another type."""
    units = {"rate": "V", "third": "N·s/m", "größe": "m at 3 s: x", "device": "N\nm"}
    odd = {**WALL, "environment": "odd", "parameters": ODD, "units": units}
    log = [(0.0, WALL), (0.5, odd), (0.75, {**odd, "parameters": {**ODD, "rate": 9.0}})]
    lines = settings_log.lines(log)
    assert all(line.isprintable() for line in lines)
    assert lines[-1] == "# parameter.rate at 0.75 s: 9 V"
    found = read(log)
    assert [time for time, _ in found] == [0.0, 0.5, 0.75]
    assert found[1][1]["parameters"] == ODD
    assert found[2][1]["parameters"] == {**ODD, "rate": 9.0}
    assert found[2][1]["units"]["third"] == "N·s/m"
    for key in ("environment", "rate_Hz", "delay_s", "estimator", "controller", "seed"):
        assert found[2][1][key] == odd[key], key


def test_a_new_environment_removes_all_parameters_of_the_previous_one():
    other = {"environment": "spring", "parameters": {"stiffness": 250.0}, "units": {"stiffness": "N/m"}}
    log = [(0.0, WALL), (1.0, {**WALL, **other})]
    assert "# stiffness at 1 s: 250 N/m" in settings_log.lines(log)
    assert read(log)[1][1]["parameters"] == {"stiffness": 250.0}


def test_a_change_to_a_device_without_numbers_and_back_is_read_unchanged():
    log = [(0.0, WALL), (1.0, {**WALL, "device": "Hapkit 7"}), (2.0, WALL)]
    devices = [what["device"] for _, what in read(log)]
    assert devices == [{"mass": 0.044, "end_stops": float("inf")}, "Hapkit 7", devices[0]]


def test_the_settings_of_one_long_json_line_are_read_and_other_comments_ignored():
    old = {**WALL, "estimator": ["iir", {"cutoff": 20.0}], "changes": ["0.500 s: Stiffness 250 → 600 N/m"]}
    assert settings_log.read([f" {json.dumps(old)}"]) == [
        (0.0, {k: v for k, v in old.items() if k != "changes"})
    ]
    assert settings_log.read(["a comment of another program", "7", "=====", ""]) == []
    assert settings_log.read([]) == []
    digits = "9" * 60_000  # reading this must not take quadratic time
    assert settings_log.read([f"stiffness: {digits}x"])[0][1]["parameters"] == {"stiffness": f"{digits}x"}
    with pytest.raises(FileError, match=r"a\.csv, settings in the first line"):
        settings_log.read(["{broken"], "a.csv")


def test_every_setting_of_the_studio_has_its_own_name():
    """A setting without a name would be written as "setting.…"."""
    run = hs.simulate(
        "wall", hand=hs.Hand(0.1, 1.0, 100.0), estimator=("iir", {"cutoff": 20.0}), seconds=0.01
    )
    engine = Engine(SimulatedHapkit(), "wall", realtime=False)
    live = {**settings_events.about_device(engine), **settings_events.in_force(engine)}
    for found in (run.settings, live, {"firmware": 3, "protocol": 7}):
        lines = settings_log.lines([(0.0, found)])
        assert not [line for line in lines if "setting." in line]
        assert len(set(lines)) == len(lines)
    assert "# max_force: 3 N" in settings_log.lines([(0.0, live)])
    assert "# setting.new: 5 Hz" in settings_log.lines([(0.0, {"new_Hz": 5})])
