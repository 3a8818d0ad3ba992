"""On the real firmware, oscillations decay at 3 % below the exact stability limit, and grow above it."""

from functools import cache

import pytest

from hapkit_studio.devices.virtual_board import built
from tests.bench import board_limit

pytestmark = [pytest.mark.slow, pytest.mark.skipif(not built(), reason="the virtual board is not built")]
SECONDS, SHARE = 3.0, 0.03


@cache
def computer(stiffness):
    return board_limit.on_computer(stiffness, 0.0, "difference", SECONDS)


@cache
def board(stiffness):
    return board_limit.on_board(stiffness, 0.0, "difference", SECONDS, 1000)


@pytest.mark.parametrize("swing", [computer, board])
def test_the_boundary_agrees_with_theory(swing):
    inside = swing(300.0)
    limit = board_limit.theory(0.0, "difference", 1000, inside.delay)
    assert inside.rate < -0.3
    assert swing((1.0 - SHARE) * limit).rate < 0.0
    assert swing((1.0 + SHARE) * limit).rate > 0.0


@pytest.mark.parametrize("rate", [1600, 2900, 3500])
def test_the_boundary_at_an_intermediate_rate_agrees_with_theory(rate):
    """The rates are those of puck, bump and hard surface; their periods are rounded to half a microsecond."""
    real = 2e6 / round(2e6 / rate)

    def swing(stiffness):
        return board_limit.on_board(stiffness, 0.0, "difference", SECONDS, real)

    inside = swing(300.0)
    limit = board_limit.theory(0.0, "difference", real, inside.delay)
    assert inside.skipped == 0
    assert swing((1.0 - SHARE) * limit).rate < 0.0 < swing((1.0 + SHARE) * limit).rate


def test_the_board_has_less_delay_and_a_higher_limit():
    here, there = computer(300.0).delay, board(300.0).delay
    assert there < 0.5 * here
    limits = [board_limit.theory(0.0, "difference", 1000, delay) for delay in (here, there)]
    assert limits[1] > 1.3 * limits[0]


def test_theory_includes_the_virtual_damping():
    """The limit is about (b₀ + b) / (T/2 + delay): 1 N·s/m in addition to 0.5 N·s/m triples it."""
    limits = [board_limit.theory(damping, "kalman", 1000, 0.66e-3) for damping in (0.0, 1.0)]
    assert limits[1] / limits[0] == pytest.approx(3.0, rel=0.1)
