"""The plane combines every limit of a loop; its numbers agree with published tables."""

import math
from dataclasses import replace

import numpy as np
import pytest

from hapkit_studio import environments
from hapkit_studio.analysis.stability import on_board
from hapkit_studio.analysis.stability.kb_plane import exact_boundary, friction_boundary, passivity_line, plane
from hapkit_studio.analysis.stability.limits import coulomb_line, simple_rule, stiffness_limit
from hapkit_studio.devices import profiles
from hapkit_studio.dynamics.hand import GRIPS
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.errors import ParameterError
from tests.analysis.stability.independent import Handle

# A Hapkit whose handle has a damping of 0.18 N·s/m. Columns: the changed setting (delay in s or rate in Hz),
# and the stiffness limit in N/m without virtual damping and with 2 N·s/m of it
HAPKITS = [({}, 360.0, 4170.0), ({"delay": 1e-3}, 120.0, 1382.0), ({"rate": 230.0}, 83.0, 826.0)]
LATE = LoopSettings(viscous=0.18, delay=1e-3, estimator=("iir", {"cutoff": 35.5}))


def test_the_boundary_of_a_hapkit_agrees_with_the_table():
    for loop, alone, damped in HAPKITS:
        found = exact_boundary(LoopSettings(viscous=0.18, **loop), np.array([0.0, 2.0]))
        assert found == pytest.approx([alone, damped], abs=0.6)


def test_without_damping_passive_and_stable_limits_nearly_agree():
    """Colgate & Schenkel's limit 2 b/T equals the rule of thumb.

    The limit of the released handle is b²/(3 m) higher.
    """
    setting, none = LoopSettings(), np.zeros(1)
    passive = passivity_line(setting, none)[0]
    assert passive == pytest.approx(2.0 * 0.5 / 1e-3)
    assert exact_boundary(setting, none)[0] - passive == pytest.approx(0.25 / (3.0 * 0.044), rel=0.01)
    assert simple_rule(setting, none)[0] == pytest.approx(passive)


def test_a_plane_contains_every_line_and_hand():
    found = plane(LATE, 620.0, 2.0)
    assert (found.width, found.top, len(found.damping)) == (12.0, 2000.0, len(found.exact))
    want = stiffness_limit(0.044, 0.18, damping=2.0, delay=1e-3, estimator="iir")
    assert found.margin.limit == found.hands["released"] == want
    assert found.exact[20] == pytest.approx(want)
    assert list(found.hands) == list(GRIPS)
    assert sorted(found.hands.values()) == list(found.hands.values())
    assert found.edge[-1] == pytest.approx(0.0, abs=1e-6)
    assert found.edge[0] == pytest.approx(2.0 * 0.18 / 3e-3, rel=1e-6)
    assert found.coulomb == pytest.approx(2.0 * 0.10 / 20.7e-6)


def test_an_adaptive_window_has_a_plane_without_exact_lines():
    found = plane(LoopSettings(estimator="foaw"), 300.0, 1.0)
    assert np.isnan(found.exact).all()
    assert math.isnan(found.margin.limit)
    assert found.edge.size == 0
    assert found.simple[0] == pytest.approx(1000.0)
    with pytest.raises(ParameterError, match="not linear"):
        exact_boundary(LoopSettings(estimator="foaw"), np.zeros(1))


WORKED = LoopSettings(mass=0.05, viscous=0.5, coulomb=0.1, quantum=15e-6)


def test_friction_hides_the_sensor_steps_up_to_a_stiffness():
    for quantum, coulomb, stiffness in (
        (5e-6, 0.02, 8000), (5e-6, 0.1, 40000), (15e-6, 0.05, 6667), (20.7e-6, 0.25, 24155),
        (61.4e-6, 0.1, 3257), (0.78e-3, 0.1, 256),
    ):  # fmt: skip
        found = coulomb_line(replace(WORKED, quantum=quantum, coulomb=coulomb))
        assert found == pytest.approx(stiffness, abs=0.5)


def test_the_simple_rule_is_conservative_without_damping():
    for late, factor in ((0.0, 0.333), (0.5, 0.208), (1.0, 0.184), (2.0, 0.172)):
        setting, none = replace(WORKED, delay=late * 1e-3), np.zeros(1)
        missing = exact_boundary(setting, none) - simple_rule(setting, none)
        assert missing[0] == pytest.approx(factor * setting.viscous**2 / setting.mass, rel=0.01)


def test_the_simple_rule_is_optimistic_with_damping():
    """The dampings are 0.05, 0.1, 0.2 and 0.3 times m/T; the handle itself has little damping."""
    for late, shares in ((0.0, (-0.047, -0.09, -0.18, -0.26)), (1.0, (-0.053, -0.11, -0.22, -0.34))):
        setting = replace(WORKED, viscous=1e-6 * WORKED.mass / 1e-3, delay=late * 1e-3)
        damping = np.array([0.05, 0.1, 0.2, 0.3]) * setting.mass / 1e-3
        found = exact_boundary(setting, damping) / simple_rule(setting, damping) - 1.0
        assert found == pytest.approx(shares, abs=0.006)


BOARD = profiles.default().board
WALL = environments.named("wall")


@pytest.mark.parametrize(("rate", "viscous"), [(500, 0.3), (1000, 0.5), (2000, 0.5)])
def test_the_limit_of_a_sketch_is_that_of_a_force_with_a_period_of_delay(rate, viscous):
    # the limit is 2 b / (3 T), because the hold delays the force by T / 2, and the sketch by T
    limit = 2.0 * viscous * rate / 3.0
    found = on_board.sketch_verdict(WALL, WALL.values(), replace(BOARD, viscous=viscous), rate, "difference")
    assert found.limit == pytest.approx(limit, rel=0.01)


def test_a_sketch_states_limit_and_verdict():
    found = on_board.sketch_verdict(WALL, WALL.values({"stiffness": 5000.0}), BOARD, 1000, "difference")
    text = on_board.sketch_text(found, 1000)
    assert text.startswith("At 1,000 Hz, with one period of delay: In your hand, a push of more than ")
    assert text.endswith(f" is above the limit of {found.margins['medium'].limit:,.0f} N/m in your hand.")
    assert not found.calm
    free = environments.named("free")
    found = on_board.sketch_verdict(free, free.values(), BOARD, 1000, "difference")
    assert on_board.sketch_text(found, 1000).endswith(
        "In your hand, the handle is stable. After you let go, the handle is stable."
    )


@pytest.mark.parametrize("push", [0.5e-3, 1e-3])
@pytest.mark.parametrize("delay", [0.0, 1e-3])
def test_a_push_settles_below_the_boundary_of_dry_friction_and_oscillates_above(push, delay):
    """The boundary is compared with an independent simulation without quantisation and force limit."""
    setting = LoopSettings(delay=delay)
    bound = float(friction_boundary(setting, np.zeros(1), push)[0])
    for share, settles in ((0.95, True), (1.05, False)):
        mass, viscous, coulomb = setting.mass, setting.viscous, setting.coulomb
        handle = Handle(mass, viscous, coulomb, 0.0, math.inf, 1000.0, delay, share * bound, 0.0)
        places = handle.let_go(push, 0.0, 1.0)
        assert (np.ptp(places[-200:]) < push) == settles


def test_without_dry_friction_both_boundaries_coincide():
    setting, across = LoopSettings(coulomb=0.0), np.linspace(0.0, 4.0, 5)
    assert friction_boundary(setting, across) == pytest.approx(exact_boundary(setting, across))
