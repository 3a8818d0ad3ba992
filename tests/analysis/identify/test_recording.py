import json

import numpy as np
import pytest

import hapkit_studio as hs
from hapkit_studio.analysis.identify import Handle, Setup, from_csv, from_run, identify, of_rows
from hapkit_studio.dynamics.hand import GRIPS, hand_named
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.environments import named
from hapkit_studio.errors import ParameterError
from hapkit_studio.haptics import headless


@pytest.fixture(scope="module")
def run():
    return hs.simulate("spring", {"stiffness": 300.0}, hand="shake", seconds=2.0, delay=1e-3)


@pytest.fixture
def saved(run, tmp_path):
    path = tmp_path / "run.csv"
    run.save(path)
    return path


def values(found):
    return [e.value for part in (found.rendered, found.handle) for e in part.estimates]


def test_a_saved_run_gives_the_same_result(run, saved):
    direct, read = identify(from_run(run)), identify(from_csv(saved))
    assert read.setup == direct.setup
    assert values(read) == pytest.approx(values(direct), rel=1e-4, abs=1e-6)


def test_telemetry_rows_give_the_same_result(run):
    device = hs.SimulatedHapkit()
    scene = headless.Scene(
        named("spring"), named("spring").values({"stiffness": 300.0}), device, LoopSettings(delay=1e-3)
    )
    table, _ = headless.render(scene, hand_named("shake"), 2000)
    values_set = named("spring").values({"stiffness": 300.0})
    setup = Setup(named("spring"), values_set, 1000.0, 1e-3, 20.7e-6, Handle(0.044, 0.5, 0.1), GRIPS["firm"])
    assert values(identify(of_rows(table, setup))) == pytest.approx(
        values(identify(from_run(run))), rel=1e-6, abs=1e-9
    )


@pytest.mark.parametrize(("begin", "end"), [(1.0, 1.0), (1.5, 1.0), (5.0, None), (None, -1.0)])
def test_a_missing_part_is_refused(run, begin, end):
    with pytest.raises(ParameterError, match=r"must lie in the recording, 0 s to 1\.999 s"):
        identify(from_run(run), begin=begin, end=end)


def lines_of(path):
    """Return a file's header lines, its names, and its rows."""
    lines = path.read_text(encoding="utf-8").splitlines()
    header = [line for line in lines if line.startswith("#")]
    return header, lines[len(header)], lines[len(header) + 1 :]


def damaged(saved, change):
    saved.write_text("\n".join(change(*lines_of(saved))), encoding="utf-8")
    return saved


def first_as(text):
    """Return a function that replaces the first cell of a row with ``text``."""
    return lambda row: text + row[row.index(",") :]


@pytest.mark.parametrize(
    ("change", "text"),
    [
        (lambda _, names, rows: ["# {broken", names, *rows], "settings in the first line"),
        (lambda _, names, rows: ["# {" + '"a":[' * 4000, names, *rows], "settings in the first line"),
        (lambda *_: [], "has 0 rows of numbers"),
        (lambda header, names, _: [*header, names], "has 0 rows of numbers"),
        (
            lambda header, names, rows: [*header, names.replace("position_m", "place"), *rows],
            r"no column position_m\. Name its columns and units, as --time time_s:s --position NAME:UNIT",
        ),
        (
            lambda header, names, rows: [*header, names, *rows[:50], "1,2,three"],
            "not a table of numbers: line 71, velocity_m_per_s is 'three'",
        ),
        (lambda header, names, rows: [*header, names + ",more", *rows], "numbers for 11 names"),
        (
            lambda header, names, rows: [*header, names, *(row + ",1" for row in rows)],
            "11 numbers for 10 names",
        ),
        (
            lambda header, names, rows: [*header, names, *rows[:20], rows[19], *rows[20:]],
            r"times that decrease or repeat: 0\.019 s comes after 0\.019 s in line 41",
        ),
        (
            lambda header, names, rows: [*header, names, *rows[:20], rows[3], *rows[20:]],
            r"times that decrease or repeat: 0\.003 s comes after 0\.019 s in line 41",
        ),
        (
            lambda header, names, rows: [*header, names, *rows[:20], first_as("nan")(rows[20]), *rows[21:]],
            "values that are not numbers, first in line 41",
        ),
        (
            lambda header, names, rows: [*header, names, *rows, "9" * 70_000],
            "line 2021 has 70,000 characters",
        ),
    ],
)
def test_a_file_that_is_not_a_recording_is_refused_in_one_line(saved, change, text):
    assert len(lines_of(saved)[0]) == 19
    with pytest.raises(ParameterError, match=text) as raised:
        from_csv(damaged(saved, change))
    assert "\n" not in str(raised.value)
    assert "run.csv" in str(raised.value)


def test_a_recording_that_is_too_short_to_identify_is_read(saved):
    header, names, rows = lines_of(saved)
    saved.write_text("\n".join([*header, names, *rows[:20]]), encoding="utf-8")
    found = from_csv(saved)
    assert len(found) == 20
    with pytest.raises(ParameterError, match="at least 32 samples, not 20"):
        identify(found)


def test_irregular_times_are_one_line(saved):
    header, names, rows = lines_of(saved)
    times = np.cumsum(np.random.default_rng(3).uniform(0.5e-3, 1.5e-3, len(rows)))
    moved = [first_as(f"{time:.6f}")(row) for time, row in zip(times, rows, strict=True)]
    saved.write_text("\n".join([*header, names, *moved]), encoding="utf-8")
    with pytest.raises(ParameterError, match=r"The samples are 0\.59 to 1\.4 ms apart") as raised:
        identify(from_csv(saved))
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize("path", ["nosuch.csv", 5])
def test_a_path_that_is_not_a_file_is_refused_in_one_line(path):
    with pytest.raises(ParameterError, match=r"Cannot read nosuch|the path of a file, not 5"):
        from_csv(path)


@pytest.mark.parametrize(
    "settings",
    [
        {},
        {"environment": "spring", "parameters": {"stifness": 3}, "device": [], "hand": 5, "rate_Hz": "x"},
        {"environment": "my_own", "parameters": {"k": 300.0}, "rate_Hz": -1, "delay_s": 1e-3},
    ],
)
def test_missing_settings_leave_the_columns_usable(saved, settings):
    old = lambda _, names, rows: ["# " + json.dumps(settings), names, *rows]  # noqa: E731
    found = identify(from_csv(damaged(saved, old)))
    assert found.rendered["stiffness"].value == pytest.approx(300.0, abs=1.0)
    assert found.rendered["stiffness"].asked is None
    assert found.setup.rate == pytest.approx(1000.0, rel=1e-6)
