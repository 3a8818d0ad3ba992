"""Planes of dimensionless numbers: boundaries agree with tables; simulated points are on the correct side."""

import math

import numpy as np
import pytest

from hapkit_studio.analysis.failures import failures
from hapkit_studio.analysis.failures.limit_cycle import LARGE
from hapkit_studio.analysis.failures.plane import BOUNDED, PUSHED, STABLE, UNSTABLE
from hapkit_studio.cli import main

SPRING, BUZZ, STEPS = (failures()[key] for key in ("sampled_spring", "limit_cycle", "integrators"))


def points(panel, outcome):
    """Return the measured points (n, 2) that have a given outcome."""
    return np.vstack([np.empty((0, 2))] + [np.c_[p.x, p.y] for p in panel.points if p.outcome == outcome])


def test_the_sampled_walls_boundary_agrees_with_the_table_for_a_heavier_handle():
    """The table has K_max in N/m for each B in N·s/m.

    The handle has 0.05 kg and 0.5 N·s/m; the period is 1 ms, without delay.
    """
    table = {0.5: 1983.5, 1.0: 2945.8, 5.0: 9974.0, 20.0: 27440.0, 40.0: 34959.0}
    (panel,) = SPRING.plane(SPRING.case({"mass": 0.05})).panels
    own = panel.boundaries[0]
    got = np.interp([1.0 + b / 0.5 for b in table], own.x, own.y) * 0.5 / 1e-3
    assert got == pytest.approx(list(table.values()), rel=2e-3)


@pytest.mark.parametrize("delay", [0.0, 1.5e-3])
def test_rendered_springs_decay_below_the_boundary_and_grow_above(delay):
    (panel,) = SPRING.plane(SPRING.case({"delay": delay})).panels
    own, rule = panel.boundaries[0], panel.boundaries[-1]
    for outcome, side in ((STABLE, -1.0), (UNSTABLE, 1.0)):
        found = points(panel, outcome)
        assert len(found) == 9
        assert np.all(side * (found[:, 1] - np.interp(found[:, 0], own.x, own.y)) > 0.0)
    assert rule.y / rule.x == pytest.approx(1.0 / (0.5 + delay / 1e-3))
    # with little damping, the rule of thumb is accurate
    assert own.y[0] == pytest.approx(rule.y[0], rel=0.01)


def test_at_the_limit_the_knob_is_on_the_boundary():
    case = SPRING.case({"damping": 2.0})
    plane = SPRING.plane(case)
    x, y = plane.place(SPRING.limit(case))
    own = plane.panels[0].boundaries[0]
    assert y == pytest.approx(np.interp(x, own.x, own.y), rel=2e-3)


def test_settling_needs_friction_above_half_a_step_and_damping_above_half_a_period():
    """With too little damping, friction stops only pushes below 4 F_c/(π ω (k T/2 − b₀))."""
    case = BUZZ.case()
    (panel,) = BUZZ.plane(case).panels
    for outcome, steady in ((STABLE, True), (BOUNDED, False)):
        found = points(panel, outcome)
        damped = found[found[:, 0] > 0.5]
        assert len(damped) > 10
        assert np.all((damped[:, 1] > 0.5) == steady)
    angle = math.sqrt(900.0 / case["mass"]) / case["rate"]
    for outcome, grows in ((STABLE, False), (PUSHED, True), (UNSTABLE, True)):
        for beta, sigma in points(panel, outcome):
            if beta < 0.5:
                held = 4.0 * sigma / (math.pi * angle * (0.5 - beta))
                assert (held < LARGE) == grows, (beta, sigma, held)


def test_delay_moves_the_boundary_of_damping():
    case = BUZZ.case({"delay": 1e-3})
    (panel,) = BUZZ.plane(case).panels
    assert panel.boundaries[0].x[0] == 1.5
    damped = np.array([at for outcome in (STABLE, BOUNDED) for at in points(panel, outcome) if at[1] > 0.5])
    assert damped[:, 0].min() > 1.0
    assert len(points(panel, BOUNDED)) > 5


def test_every_integrator_has_its_region_and_every_scene_its_point():
    plane = STEPS.plane(STEPS.case({"method": "verlet"}))
    assert [panel.title for panel in plane.panels][plane.own] == "Verlet"
    for panel in plane.panels:
        field = panel.field
        assert field.z.shape == (len(field.y), len(field.x))
        for line in panel.boundaries:
            for x, y in zip(line.x[::20], line.y[::20], strict=False):
                row = np.abs(field.y - y).argmin()
                inside, outside = (np.abs(field.x - share * x).argmin() for share in (0.9, 1.1))
                if field.x[1] < 0.9 * x and 1.1 * x < field.x[-2]:
                    assert field.z[row, inside] <= 1.0 < field.z[row, outside]
        assert {text for _, _, text in panel.marks} == {"Mass–spring–damper", "Puck"}
    (x, y, _), *_ = (mark for mark in plane.panels[0].marks if mark[2] == "Mass–spring–damper")
    # this is the scene's point: 2 kg on 800 N/m with 1 N·s/m at 1 kHz
    assert (x, y) == pytest.approx((0.02, 1.0 / 80.0))


@pytest.mark.slow
def test_the_command_draws_a_plane_or_reports_that_there_is_none(capsys, tmp_path):
    path = tmp_path / "plane.png"
    assert main(("break-it", "integrators", "--plane", "--plot", str(path))) == 0
    assert path.read_bytes()[:4] == b"\x89PNG"
    assert main(("break-it", "course", "--plane")) == 2
    assert "--plane belongs to one of sampled_spring, integrators, limit_cycle" in capsys.readouterr().err
