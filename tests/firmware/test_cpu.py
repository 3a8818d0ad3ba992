"""The board's own laws in the simulated chip: the processor's share, skipped ticks, interrupts, velocity."""

import numpy as np
import pytest

from hapkit_studio import environments
from hapkit_studio.dynamics.estimators import design, estimate_velocity
from hapkit_studio.protocol.messages import Estimator, Loop
from tests.firmware.board_runs import render
from tests.firmware.vb import QUANTUM, needs_board

pytestmark = needs_board

SWEEP = ("0.02 hand 0.02 300 4 0.05 0.2", "0.25 hand -0.03 300 4 0.05 0.1", "0.36 hand 0.03 300 4 0.05 0.05")

MODELS = ("smoothed", "karnopp", "stribeck", "projection", "tether", "lugre")
METHODS = ("lecture", "verlet", "rk4", "trapezoid", "exact")
HELD = [(key, {}) for key in environments()] + [
    *(("friction", {"model": model}) for model in MODELS),
    *(("hard_surface", {"material": material}) for material in ("rubber", "wood", "aluminium")),
    *(("texture", {"kind": kind}) for kind in ("grating", "sandpaper")),
    ("bump_valley", {"law": "height"}),
    ("bump_valley", {"profile": "cosine"}),
    ("bump_valley", {"profile": "cosine", "law": "height"}),
    *((key, {"integrator": method}) for key in ("mass_spring_damper", "puck") for method in METHODS),
]


@pytest.mark.parametrize(("key", "given"), HELD)
def test_each_law_at_its_rate_leaves_a_fifth_of_the_processor(tmp_path, key, given):
    environment = environments()[key]
    values = environment.values(given)
    run = render(tmp_path, key, list(values.values()), environment.board_rate(values), 0.3, SWEEP)
    assert run.share <= 0.80
    assert run.skipped == 0
    assert 0 < run.summary["interrupts_off_cycles"] <= 250
    assert np.ptp([shown.count for shown in run.telemetry]) > 1000


@pytest.mark.parametrize("method", [("difference", {}), ("iir", {"cutoff": 35.5}), ("kalman", {"q": 1e-2})])
def test_the_boards_velocity_is_the_computers(tmp_path, method):
    _, numbers = design(method, 1000.0, QUANTUM)
    kind = {"difference": Estimator.DIFFERENCE, "iir": Estimator.IIR, "kalman": Estimator.KALMAN}[method[0]]
    loop = Loop(1000, kind, float(numbers[0]), float(numbers[1] * 1000.0))
    shown = render(tmp_path, "free", (), 1000, 0.35, SWEEP, loop).telemetry
    position = QUANTUM * np.array([s.count for s in shown])
    wanted = estimate_velocity(position, 1000.0, method, QUANTUM)
    assert np.abs(wanted).max() > 0.2
    got = np.array([s.velocity for s in shown])
    np.testing.assert_allclose(got[50:], wanted[50:], rtol=1e-4, atol=2e-5)
