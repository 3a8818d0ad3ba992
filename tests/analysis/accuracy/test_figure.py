"""Pictures of made-up sheets: everything is drawn, no name lies on another, odd errors too."""

import math

import numpy as np
import pytest

from hapkit_studio.charts import accuracy as charts
from hapkit_studio.charts.accuracy import AccuracyAxes, accuracy_figure
from hapkit_studio.charts.style import move_apart
from hapkit_studio.errors import ParameterError
from tests.analysis.accuracy.sheets import accuracy, point, sheet


def middles(*wanted, height=10.0, sides=None):
    """Return where boxes in a frame of 200 end up."""
    places = np.array(wanted)
    sides = sides or [(0.0, 50.0)] * len(wanted)
    return move_apart(places, np.full(len(wanted), height), sides, (0.0, 200.0))


def test_names_that_overlap_are_moved_apart_in_their_order():
    found = middles(*(50.0 + 0.1 * i for i in range(8)))
    assert (np.diff(found) >= 9.99).all()
    beside = middles(50.0, 50.0, sides=[(0.0, 50.0), (60.0, 90.0)])
    assert beside.tolist() == [50.0, 50.0]


def test_names_stay_inside_the_frame():
    found = middles(*[199.0] * 10)
    assert found.min() >= 5.0
    assert found.max() <= 195.0
    assert (np.diff(np.sort(found)) >= 9.99).all()


STRANGE = [
    point("verlet", 0.0, 1000.0),
    point("verlet", 1e-3, 2000.0, step_s=5e-4),
    point("rk4", math.inf, 3000.0),
    point("rk4", 2180.0, 500.0, step_s=2e-3),
    point("exact", 3e-16, 8000.0),
]


def test_no_error_stands_on_a_row_of_its_own_inside_the_frame():
    frame = AccuracyAxes(sheet(STRANGE))
    assert frame.has_zero
    cost, bottom = frame.place(STRANGE[0])
    assert cost == 1.0  # µs
    assert frame.bottom < bottom < frame.place(STRANGE[4])[1] == 3e-16
    assert not AccuracyAxes(sheet(STRANGE[1:])).has_zero


@pytest.mark.slow
@pytest.mark.parametrize("count", [1, 2, 5])
def test_a_picture_of_one_sheet_or_several(tmp_path, count):
    sheets = [sheet(STRANGE), sheet([point()], step_s=None), sheet([point("rk4", 0.5)], unit="m/s")]
    path = tmp_path / "chart.png"
    accuracy_figure(accuracy(*(sheets * 2)[:count]), path)
    assert path.stat().st_size > 10_000


def test_refuses_an_ending_that_is_no_pictures(tmp_path):
    with pytest.raises(ParameterError, match="A picture is one of"):
        accuracy_figure(accuracy(sheet(STRANGE)), tmp_path / "chart.txt")


def test_below_the_picture_stand_the_conditions_of_each_scene_and_the_computer(monkeypatch):
    said = {}
    monkeypatch.setattr(charts, "save", lambda *_args, caption, **_more: said.update(caption=caption))
    made = sheet([point()], conditions=(("Mass", "2 kg"), ("Start", "10 mm, at rest")))
    accuracy_figure(accuracy(made), "made.png")
    lines = said["caption"].replace("\u00a0", " ").split("\n")
    assert "A scene: Mass 2 kg · Start 10 mm, at rest" in lines
    assert lines[-1] == f"Timed on: {charts.computer()}"
