import json

import pytest

import hapkit_studio as hs
from hapkit_studio.analysis.identify import Handle, Setup, from_csv, from_run, identify, of_rows
from hapkit_studio.dynamics.hand import GRIPS, hand_named
from hapkit_studio.environments import named
from hapkit_studio.errors import ParameterError
from hapkit_studio.haptics import headless
from hapkit_studio.haptics.settings import LoopSettings


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


def test_a_saved_run_tells_what_the_run_told(run, saved):
    direct, read = identify(from_run(run)), identify(from_csv(saved))
    assert read.setup == direct.setup
    assert values(read) == pytest.approx(values(direct), rel=1e-4, abs=1e-6)


def test_telemetry_rows_tell_what_the_run_told(run):
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
def test_a_piece_that_is_not_there_is_refused(run, begin, end):
    with pytest.raises(ParameterError, match=r"is not in the recording, 0 s to 1\.999 s"):
        identify(from_run(run), begin=begin, end=end)


def damaged(saved, change):
    lines = saved.read_text(encoding="utf-8").splitlines()
    saved.write_text("\n".join(change(lines)), encoding="utf-8")
    return saved


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda lines: lines[1:], "does not begin with the settings"),
        (lambda lines: ["# {broken", *lines[1:]], "does not begin with the settings"),
        (lambda lines: ["# 7", *lines[1:]], "does not begin with the settings"),
        (lambda lines: [], "does not begin with the settings"),
        (
            lambda lines: [lines[0], lines[1].replace("position_m", "place"), *lines[2:]],
            "no column position_m",
        ),
        (lambda lines: [*lines[:50], "1,2,three"], "not a table of numbers"),
        (lambda lines: [lines[0], lines[1] + ",more", *lines[2:]], "numbers for 11 names"),
        (lambda lines: lines[:2], "0 rows"),
        (lambda lines: [*lines[:40], lines[39], *lines[40:]], "times that go back"),
        (lambda lines: [*lines[:40], "nan" + lines[40][lines[40].index(",") :]], "no numbers"),
    ],
)
@pytest.mark.filterwarnings("ignore:loadtxt")
def test_a_file_that_is_no_recording_is_refused_in_one_line(saved, change, words):
    with pytest.raises(ParameterError, match=words) as raised:
        from_csv(damaged(saved, change))
    assert "\n" not in str(raised.value)
    assert "run.csv" in str(raised.value)


@pytest.mark.parametrize("path", ["nosuch.csv", 5])
def test_what_is_no_file_is_refused_in_one_line(path):
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
def test_settings_that_say_nothing_leave_what_the_columns_say(saved, settings):
    found = identify(from_csv(damaged(saved, lambda lines: ["# " + json.dumps(settings), *lines[1:]])))
    assert found.rendered["stiffness"].value == pytest.approx(300.0, abs=1.0)
    assert found.rendered["stiffness"].asked is None
    assert found.setup.rate == pytest.approx(1000.0, rel=1e-6)
