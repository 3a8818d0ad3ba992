"""Where a spring pulls to under a fast motion, and files that say, or do not say, how a hand held."""

import json

import numpy as np
import pytest

import hapkit_studio as hs
from hapkit_studio.analysis.identify import from_csv, from_run, identify
from hapkit_studio.dynamics.hand import Hand
from hapkit_studio.errors import ParameterError
from tests.analysis.identify.motions import HAND, several_sines


@pytest.mark.parametrize("centre", [0.010, -0.004])
def test_a_filter_does_not_move_the_centre(centre):
    values = {"stiffness": 120.0, "damping": 3.0, "center": centre}
    run = hs.simulate("spring", values, hand="shake", estimator="iir", seconds=6.0)
    found = identify(from_run(run)).rendered
    assert found["stiffness"].value > 125.0  # the late velocity stiffens the motion
    assert found["centre"].holds(centre)
    assert found["centre"].half < 0.5e-3
    assert found["centre"].half >= 0.5e-6


def test_a_centre_other_than_what_was_set_is_found():
    values = {"stiffness": 120.0, "damping": 3.0, "center": 0.010}
    run = hs.simulate("spring", values, hand="shake", estimator="iir", seconds=6.0)
    run.settings["parameters"]["center"] = 0.004
    assert identify(from_run(run)).rendered["centre"].holds(0.010)


@pytest.fixture
def saved(tmp_path):
    hand = Hand(*HAND, several_sines(3), vectorised=True)
    run = hs.simulate("spring", {"stiffness": 150.0}, hand=hand, seconds=3.0)
    run.save(tmp_path / "own.csv")
    return run, hand, tmp_path / "own.csv"


def test_a_file_keeps_how_an_own_hand_held(saved):
    run, hand, path = saved
    assert run.settings["hand_grip"] == {"mass": 0.05, "damping": 4.0, "stiffness": 200.0}
    assert np.allclose(run.hand_target, hand.target(run.time), atol=1e-12)
    for part in (identify(from_csv(path)).handle, identify(from_run(run)).handle):
        assert abs(part["mass"].value - 0.094) < 2.0 * part["mass"].half
        assert part["mass"].half < 0.005


def test_a_file_that_does_not_say_how_the_hand_held_tells_nothing_of_the_handle(saved):
    *_, path = saved
    lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
    settings = json.loads(lines[0][1:])
    del settings["hand_grip"]
    path.write_text(f"# {json.dumps(settings)}\n" + "".join(lines[1:]), encoding="utf-8")
    part = identify(from_csv(path)).handle
    assert not part.estimates
    assert "does not say how the hand held" in part.advice


@pytest.mark.parametrize("path", ["nosuch.csv", 5, None, "."])
def test_what_is_no_file_is_refused_in_one_line(path):
    with pytest.raises(ParameterError) as raised:
        from_csv(path)
    assert "\n" not in str(raised.value)


@pytest.mark.filterwarnings("error")
def test_a_file_without_rows_is_refused_without_a_warning(saved):
    *_, path = saved
    lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
    path.write_text("".join(lines[:2]), encoding="utf-8")
    with pytest.raises(ParameterError, match="0 rows"):
        from_csv(path)
