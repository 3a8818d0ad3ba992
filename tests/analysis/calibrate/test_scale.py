"""Zero and scale are found from marks on a known line; a comparison with the kit's radii reveals mistakes."""

from dataclasses import replace

import numpy as np
import pytest

from hapkit_studio.analysis.calibrate import scale
from hapkit_studio.analysis.calibrate.result import FAIL
from hapkit_studio.devices.profiles import default, quantum_of
from hapkit_studio.errors import ParameterError
from tests.analysis.calibrate.student import hold_at_marks, session
from tests.devices.paddle_kit import PaddleKit

BOARD = default().board
Q = BOARD.quantum


def marks_of(places, quantum=Q, zero=300.0, sense=1, errors=None):
    errors = np.zeros(len(places)) if errors is None else errors
    return [scale.Mark(p, zero + sense * (p + e) / quantum) for p, e in zip(places, errors, strict=True)]


@pytest.mark.parametrize("sense", [1, -1])
def test_a_straight_line_is_found_exactly(sense):
    found = scale.fit(marks_of((0.0, -0.02, 0.02), sense=sense), BOARD)
    assert found.quantum == pytest.approx(Q, rel=1e-12)
    assert found.zero == pytest.approx(300.0)
    assert found.sense == sense
    assert found.result.good


def test_intervals_contain_the_truth(rng):
    held = 0
    places = (0.0, -0.02, 0.02, 0.0, 0.03)
    for _ in range(400):
        errors = rng.normal(0.0, 0.3e-3, len(places))
        found = scale.fit(marks_of(places, errors=errors), BOARD)
        held += abs(found.quantum - Q) <= found.quantum_half
    assert held >= 0.92 * 400


def test_marks_that_contradict_each_other_or_the_sensor_check_are_a_fault():
    """The wrong marks are at +20 mm instead of −20 mm, or their sides are swapped."""
    same_side = [
        scale.Mark(place, mark.count)
        for place, mark in zip((0.0, -0.02, 0.02, 0.0), marks_of((0.0, 0.02, 0.02, 0.0)), strict=True)
    ]
    with pytest.raises(ParameterError, match="wrong side"):
        scale.fit(same_side, BOARD)
    off = scale.fit(marks_of((0.0, -0.02, 0.02, 0.0), errors=np.array([0.0, 0.01, 0.0, 0.0])), BOARD)
    assert (off.result.level, off.result.key) == (FAIL, "uneven")
    swapped = marks_of((0.0, -0.02, 0.02, 0.0), sense=-BOARD.sense)
    assert scale.fit(swapped, BOARD, inverted=False).result.level == FAIL
    assert scale.fit(swapped, BOARD, inverted=True).result.good, "the sensor really counts the other way"
    assert scale.fit(marks_of((0.0, -0.02, 0.02, 0.0), sense=BOARD.sense), BOARD, inverted=False).result.good


def test_marks_that_are_too_few_or_too_close_are_refused():
    with pytest.raises(ParameterError, match="At least two marks"):
        scale.fit(marks_of((0.0,)), BOARD)
    apart = scale.APART
    with pytest.raises(ParameterError, match="20 mm or more apart"):
        scale.fit(marks_of((0.0, 0.99 * apart)), BOARD)
    assert scale.fit(marks_of((0.0, 1.01 * apart)), BOARD).result.good


@pytest.mark.parametrize(
    ("changed", "key"),
    [
        ({"pulley_radius": 0.010}, "diameter"),
        # the marks also fit a handle radius of 36 mm, but no kit has this radius
        ({"pulley_radius": 0.0125}, "diameter"),
        ({"handle_radius": 0.070}, "radius"),
        ({"handle_radius": 0.093}, ""),
    ],
)
def test_wrong_radii_are_named_and_corrected_by_the_marks(changed, key):
    board = replace(BOARD, **changed)
    found = scale.fit(marks_of((0.0, -0.02, 0.02, 0.0)), board)
    assert found.result.key == key
    made = replace(board, **scale.changes(found, board))
    assert made.quantum == pytest.approx(Q)
    assert quantum_of(made) == pytest.approx(Q)
    if key:
        name, right = next((name, getattr(BOARD, name)) for name in changed)
        assert getattr(made, name) == pytest.approx(right)
        result = scale.in_force(found, board)
        assert result.good
        assert f"{1e3 * right:.2f}\N{NO-BREAK SPACE}mm instead of {1e3 * changed[name]:.2f} mm" in result.text
        halved = 0.5 * changed[name] if name == "pulley_radius" and changed[name] > 0.008 else right
        assert f"{1e3 * halved:.1f} mm" in found.result.remedy


def test_a_slipping_cable_is_found_at_the_second_middle_mark():
    kit = PaddleKit()
    work = session(kit)
    found = hold_at_marks(kit, work, slip_at=3)
    assert found.result.key == "slipped"
    assert scale.in_force(found, work.board) == found.result
    assert hold_at_marks(kit, work).result.good


def test_a_moving_handle_gives_no_mark():
    kit = PaddleKit()
    work = session(kit)
    kit.student = lambda k: setattr(k, "hand", 0.002 * np.sin(10.0 * k.time))
    with pytest.raises(ParameterError, match="Hold the handle still"):
        work.take_mark(0.0)
    assert work.marks == []
