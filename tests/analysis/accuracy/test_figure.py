"""Pictures of made-up sheets: everything is drawn, no name lies on another, odd errors too."""

import itertools
import math

import pytest

from hapkit_studio.charts.accuracy import accuracy_figure
from hapkit_studio.charts.accuracy_axes import Frame
from hapkit_studio.charts.spreading import Name, spread
from hapkit_studio.errors import ParameterError
from tests.analysis.accuracy.points import accuracy, point, sheet


def name(text, middle, left=0.0, width=50.0):
    return Name(text, "#000000", left, middle, width, 10.0, (left, middle))


def test_names_that_overlap_are_moved_apart_in_their_order():
    names = [name(str(i), 50.0 + 0.1 * i) for i in range(8)] + [name("beside", 50.0, left=60.0)]
    spread(names, 0.0, 200.0)
    assert not any(one.meets(other) for one, other in itertools.combinations(names, 2))
    assert [n.text for n in sorted(names[:8], key=lambda n: n.middle)] == [str(i) for i in range(8)]
    assert names[-1].middle == 50.0


def test_names_stay_inside_the_frame():
    names = [name(str(i), 199.0) for i in range(10)]
    spread(names, 0.0, 200.0)
    assert all(5.0 <= n.middle <= 195.0 for n in names)
    assert not any(one.meets(other) for one, other in itertools.combinations(names, 2))


STRANGE = [
    point("verlet", 0.0, 1000.0),
    point("verlet", 1e-3, 2000.0, step_s=5e-4),
    point("rk4", math.inf, 3000.0),
    point("rk4", 2180.0, 500.0, step_s=2e-3),
    point("exact", 3e-16, 8000.0),
]


def test_no_error_stands_on_a_row_of_its_own_inside_the_frame():
    frame = Frame(sheet(STRANGE))
    assert frame.has_zero
    cost, bottom = frame.place(STRANGE[0])
    assert cost == 1.0  # µs
    assert frame.bottom < bottom < frame.place(STRANGE[4])[1] == 3e-16
    assert not Frame(sheet(STRANGE[1:])).has_zero


@pytest.mark.parametrize("count", [1, 2, 5])
def test_a_picture_of_one_sheet_or_several(tmp_path, count):
    sheets = [sheet(STRANGE), sheet([point()], step_s=None), sheet([point("rk4", 0.5)], unit="m/s")]
    path = tmp_path / "chart.png"
    accuracy_figure(accuracy(*(sheets * 2)[:count]), path)
    assert path.stat().st_size > 10_000


def test_refuses_an_ending_that_is_no_pictures(tmp_path):
    with pytest.raises(ParameterError, match="A picture is one of"):
        accuracy_figure(accuracy(sheet(STRANGE)), tmp_path / "chart.txt")
