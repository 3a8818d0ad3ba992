"""The margin is stated as text, and the map's axes leave room around the dot and the limit."""

import math

import numpy as np
import pytest

from hapkit_studio.analysis.stability.margin import Margin, height, nice_width, round_axes, sentence


@pytest.mark.parametrize(
    ("stiffness", "limit", "hand", "text"),
    [
        (620.0, 867.0, "released", "Stiffness 1.4 × below the limit (no hand)."),
        (620.0, 3360.0, "medium", "Stiffness 5.4 × below the limit (medium grip)."),
        (
            1127.0,
            867.0,
            "released",
            "Stiffness 1.3 × above the limit (no hand). Lower the stiffness below 867 N/m.",
        ),
        (1.0, 867.0, "firm", "Stiffness far below the limit (firm grip)."),
        (0.0, 867.0, "light", "Stable (light grip)."),
        (10.0, 0.0, "released", "Damping above the limit (no hand). Lower the damping."),
        (867.0, 867.0, "released", "Stiffness 1.00 × below the limit (no hand)."),
        (
            910.0,
            867.0,
            "firm",
            "Stiffness 1.05 × above the limit (firm grip). Lower the stiffness below 867 N/m.",
        ),
    ],
)
def test_the_sentence_states_margin_hand_and_remedy(stiffness, limit, hand, text):
    assert sentence(Margin(stiffness, 2.0, limit, hand)) == text


@pytest.mark.parametrize(
    ("stiffness", "limit", "text"),
    [
        (200.0, 256.0, "Stiffness 1.3 × below the limit (no hand). Stable again from 341 to 1,562 N/m."),
        (
            340.0,
            256.0,
            "Stiffness 1.3 × above the limit (no hand). Lower the stiffness below 256 N/m. "
            "Stable again from 341 to 1,562 N/m.",
        ),
        (342.0, 256.0, "Stable from 341 to 1,562 N/m (no hand)."),
        (342.0, 0.0, "Stable from 341 to 1,562 N/m (no hand)."),
        (
            340.0,
            0.0,
            "Damping above the limit (no hand). Lower the damping. Stable only from 341 to 1,562 N/m.",
        ),
    ],
)
def test_the_sentence_states_further_stable_intervals(stiffness, limit, text):
    margin = Margin(stiffness, 3.2, limit, again=((341.0, 1562.0),))
    assert sentence(margin) == text
    assert margin.stable == (stiffness < limit or stiffness == 342.0)


def test_the_height_leaves_room_above_dot_and_limit():
    for stiffness, limit, highest in ((620.0, 867.0, 1492.0), (4000.0, 867.0, 1492.0), (0.0, 0.0, 0.0)):
        assert height(stiffness, limit, highest) >= 1.1 * max(stiffness, limit)
    assert height(620.0, 867.0, 1492.0) == 2000.0
    assert height(620.0, 867.0, 9000.0) == 1500.0
    assert math.isfinite(height(10.0, math.inf, math.inf))


@pytest.mark.parametrize("damping", [0.0, 0.3, 2.0, 8.3, 13.9, 40.0, 470.0])
def test_the_dot_keeps_a_distance_from_the_right_edge(damping):
    assert damping <= 0.71 * nice_width(damping)
    assert nice_width(damping, least=12.0) >= 12.0


def test_the_axes_show_where_the_boundary_leaves_or_turns():
    """A straight boundary leaves through the top; a boundary with its maximum at 9 is shown up to 9."""
    wide, top = round_axes(lambda b: 1000.0 + 2000.0 * b, 900.0, 0.0, 1000.0)
    assert (wide, top) == (1.0, 1500.0)
    wide, top = round_axes(lambda b: 1500.0 - 15.0 * (b - 9.0) ** 2, 620.0, 2.0, 765.0)
    assert (wide, top) == (12.0, 2000.0)
    assert round_axes(np.zeros_like, 0.0, 0.0, 0.0) == (1.0, 1.0)
