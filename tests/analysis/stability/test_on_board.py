"""How stiff a sketch may be, against the closed form of a handle with little mass in its delays."""

from dataclasses import replace

import pytest

from hapkit_studio import environments
from hapkit_studio.analysis.stability import on_board
from hapkit_studio.devices import profiles

BOARD = profiles.default().board
WALL = environments.named("wall")


@pytest.mark.parametrize("rate", [500, 1000, 2000])
@pytest.mark.parametrize("viscous", [0.3, 0.5])
def test_the_limit_is_that_of_a_force_a_period_late(rate, viscous):
    # stored energy grows where the delays of hold (T / 2) and sketch (T) eat the handle's damping: 2 b / 3 T
    limit = 2.0 * viscous * rate / 3.0
    for share, stable in ((0.98, True), (1.02, False)):
        values = WALL.values({"stiffness": share * limit, "damping": 0.0})
        found = on_board.sketch_margin(WALL, values, replace(BOARD, viscous=viscous), rate, "difference")
        assert found.limit == pytest.approx(limit, rel=0.01)
        assert found.stable == stable


def test_limit_and_margin_are_in_the_words():
    found = on_board.sketch_margin(WALL, WALL.values({"stiffness": 5000.0}), BOARD, 1000, "difference")
    words = on_board.sketch_words(found, 1000)
    assert words.startswith(f"Limit {found.limit:,.0f} N/m at 1,000 Hz")
    assert "above the limit" in words
    assert "Lower stiffness" in words


def test_what_has_no_stiffness_has_no_limit():
    free = environments.named("free")
    found = on_board.sketch_margin(free, free.values(), BOARD, 1000, "difference")
    assert found is None
    assert on_board.sketch_words(found, 1000) == ""
