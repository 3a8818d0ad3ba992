"""The plane puts every limit of a loop together; numbers are the tables', not its own."""

import math
from dataclasses import replace

import numpy as np
import pytest

from hapkit_studio.analysis.setting import Setting
from hapkit_studio.analysis.stability.kb_plane import exact_boundary, hands, limit, passivity_line, plane
from hapkit_studio.analysis.stability.limits import simple_rule, stiffness_limit
from hapkit_studio.dynamics.hand import GRIPS
from hapkit_studio.errors import ParameterError

# A Hapkit with 0.18 N·s/m: delay in ms or rate, limit without and with 2 N·s/m of virtual damping
HAPKITS = [
    ({}, 360.0, 4170.0),
    ({"delay": 1e-3}, 120.0, 1382.0),
    ({"rate": 230.0}, 83.0, 826.0),
]
LATE = Setting(viscous=0.18, delay=1e-3, estimator=("iir", {"cutoff": 35.5}))


@pytest.mark.parametrize(("loop", "alone", "damped"), HAPKITS)
def test_the_boundary_of_a_hapkit(loop, alone, damped):
    found = exact_boundary(Setting(viscous=0.18, **loop), np.array([0.0, 2.0]))
    assert found == pytest.approx([alone, damped], abs=0.6)


def test_with_little_damping_of_its_own_a_handle_gives_666_at_230_hz():
    assert limit(Setting(viscous=1.3, rate=230.0), 0.0) == pytest.approx(611.0, abs=0.6)


def test_without_virtual_damping_the_passive_spring_is_the_stable_one_nearly():
    """Colgate & Schenkel's 2 b/T; the released handle stands b²/(3 m) more, and the rule is the same."""
    setting, none = Setting(), np.zeros(1)
    passive = passivity_line(setting, none)[0]
    assert passive == pytest.approx(2.0 * 0.5 / 1e-3)
    assert exact_boundary(setting, none)[0] - passive == pytest.approx(0.25 / (3.0 * 0.044), rel=0.01)
    assert simple_rule(setting, none)[0] == pytest.approx(passive)


def test_a_plane_holds_every_line_and_the_limits_of_every_hand():
    found = plane(LATE, 620.0, 2.0)
    assert (found.width, found.top, len(found.damping)) == (12.0, 2000.0, len(found.exact))
    want = stiffness_limit(
        0.044, 0.18, damping=2.0, delay=1e-3, estimator=("iir", {"cutoff": 35.5}), hand=None
    )
    assert found.margin.limit == found.hands["released"] == want
    assert found.exact[20] == pytest.approx(want)
    assert list(found.hands) == list(GRIPS)
    assert sorted(found.hands.values()) == list(found.hands.values())
    assert found.edge[-1] == pytest.approx(0.0, abs=1e-6)
    assert found.edge[0] == pytest.approx(2.0 * 0.18 / 3e-3, rel=1e-6)
    assert found.coulomb == pytest.approx(2.0 * 0.10 / 20.7e-6)


def test_the_margin_is_that_of_the_hand_asked_for():
    firm = plane(replace(LATE, hand="firm"), 620.0, 2.0)
    assert firm.margin.limit == firm.hands["firm"] == hands(LATE, 2.0)["firm"]
    assert firm.margin.hand == "firm"


def test_axes_that_are_given_are_kept():
    found = plane(LATE, 620.0, 2.0, width=5.0, top=800.0, columns=7)
    assert (found.width, found.top, len(found.exact)) == (5.0, 800.0, 7)


def test_an_adaptive_window_has_a_plane_without_exact_lines():
    found = plane(Setting(estimator="foaw"), 300.0, 1.0)
    assert np.isnan(found.exact).all()
    assert math.isnan(found.margin.limit)
    assert found.edge.size == 0
    assert found.simple[0] == pytest.approx(1000.0)
    with pytest.raises(ParameterError, match="not linear"):
        exact_boundary(Setting(estimator="foaw"), np.zeros(1))
