"""Display of a parameter: unit, step, square-root scale."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from PySide6.QtCore import Qt

from hapkit_studio.gui.widgets.numbers import NumberBox
from hapkit_studio.parameters import Parameter
from hapkit_studio.quantity import Quantity

STIFFNESS = Quantity(Parameter("stiffness", "Stiffness", "N/m", 250.0, 0.0, 5000.0))
PLACE = Quantity(Parameter("position", "Wall position", "m", 0.005, -0.04, 0.04))
DELAY = Quantity(Parameter("delay", "Added delay", "s", 0.0, 0.0, 0.1))


def test_metres_and_seconds_are_shown_in_thousandths():
    assert (PLACE.unit, PLACE.low, PLACE.high, PLACE.default) == ("mm", -40.0, 40.0, 5.0)
    assert (DELAY.unit, DELAY.high) == ("ms", 100.0)
    assert STIFFNESS.unit == "N/m"


def test_wide_ranges_have_a_square_root_scale_and_symmetric_ones_are_linear():
    assert STIFFNESS.fraction(400.0) == pytest.approx(math.sqrt(400.0 / 5000.0))
    assert PLACE.fraction(0.0) == pytest.approx(0.5)


@given(st.floats(0.0, 1.0))
def test_a_slider_position_gives_a_multiple_of_the_step_within_the_limits(fraction):
    for quantity in (STIFFNESS, PLACE, DELAY):
        value = quantity.value(fraction)
        assert quantity.low <= value <= quantity.high
        steps = (value - quantity.low) / quantity.step
        assert steps == pytest.approx(round(steps), abs=1e-6)
        there = quantity.fraction(value)
        near = [quantity.fraction(value - quantity.step), quantity.fraction(value + quantity.step)]
        assert near[0] - 1e-9 <= fraction <= near[1] + 1e-9 or there == pytest.approx(fraction)


@pytest.mark.parametrize(
    ("quantity", "value", "text"),
    [
        (STIFFNESS, 400.0, "400"),
        (STIFFNESS, 400.25, "400.25"),
        (PLACE, 5.0, "5.0"),
        (PLACE, -12.34, "−12.34"),
        (PLACE, -0.0, "0.0"),
        (PLACE, 5.000000000000001, "5.0"),
    ],
)
def test_a_value_is_shown_to_its_step_with_only_the_further_digits_that_it_has(quantity, value, text):
    assert quantity.text(value) == text


def test_a_whole_parameter_is_shown_and_moved_in_whole_numbers():
    seed = Quantity(Parameter("seed", "Seed", "", 1.0, 0.0, 99.0, whole=True))
    assert (seed.text(1.0), seed.step, seed.moved(1.0, 1)) == ("1", 1.0, 2.0)
    assert all(seed.value(0.01 * part).is_integer() for part in range(101))


def test_limits_are_one_sentence_with_the_displayed_unit():
    assert STIFFNESS.limits() == "Stiffness must be between 0 and 5,000 N/m."
    assert PLACE.limits() == "Wall position must be between −40 and 40 mm."


@pytest.mark.parametrize(
    ("typed", "value"),
    [("1,500", 1500.0), ("12,345.5", 12345.5), ("0,350", 0.35), ("1,5", 1.5), ("-1,002", -1002.0)],
)
def test_commas_are_thousands_separators_or_decimal_signs(qtbot, typed, value):
    box = NumberBox(Quantity(Parameter("stiffness", "Stiffness", "N/m", 0.0, -1e5, 1e5)))
    qtbot.addWidget(box)
    box.selectAll()
    qtbot.keyClicks(box, typed)
    with qtbot.waitSignal(box.entered) as blocker:
        qtbot.keyClick(box, Qt.Key.Key_Return)
    assert blocker.args == [value]


def test_thousands_separators_are_hidden_while_typing(qtbot):
    box = NumberBox(STIFFNESS)
    qtbot.addWidget(box)
    box.show_value(1200.0)
    assert box.text() == "1,200"
    box.show()
    box.setFocus()
    qtbot.waitUntil(box.hasFocus)
    assert box.text() == "1200"
    box.lineEdit().end(False)
    with qtbot.waitSignal(box.entered) as blocker:
        qtbot.keyClicks(box, "5")
        box.clearFocus()
    assert blocker.args == [12005.0]
    assert box.text() == "12,005"
