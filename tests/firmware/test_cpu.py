"""Laws in the simulated chip at the rates that the studio offers: load, skipped ticks, and velocity."""

import numpy as np
import pytest

from hapkit_studio import environments
from hapkit_studio.dynamics.estimators import design, estimate_velocity
from hapkit_studio.haptics.board_plan import RATES, BoardPlanner, PlanRequest
from hapkit_studio.laws.machine import ARENA
from hapkit_studio.parameters import Choice
from hapkit_studio.protocol.messages import Estimator
from tests.firmware.board_runs import program, render
from tests.firmware.vb import QUANTUM, needs_board
from tests.wide import wide

pytestmark = needs_board

SWEEP = ("0.02 hand 0.02 300 4 0.05 0.2", "0.25 hand -0.03 300 4 0.05 0.1", "0.36 hand 0.03 300 4 0.05 0.05")
MOST = 0.80
FASTEST = ("free", "spring", "wall", "damping")
# the cat's law is the most expensive; the puck's is expensive because of its accurate integrator
SLOWEST = ("cat", "puck")
"""With default choices, FASTEST are rendered at 4 kHz, the cat at 500 Hz or more, others at 2 kHz or more."""


def choices(key):
    """Return the default choices, then choices that differ from them in one option."""
    found = [{}]
    for parameter in environments()[key].parameters:
        if isinstance(parameter, Choice):
            others = (o for i, o in enumerate(parameter.options) if i != parameter.default)
            found += [{parameter.key: option} for option in others]
    return found


HELD = [(key, given) for key in environments() for given in choices(key)]


@pytest.mark.slow
@pytest.mark.parametrize(("key", "given"), wide(HELD, lambda key, given: not given))
def test_each_law_at_its_rate_uses_at_most_four_fifths_of_the_processor(tmp_path, key, given):
    environment = environments()[key]
    wish = PlanRequest(environment, environment.values(given), "kalman", QUANTUM)
    answer = BoardPlanner(ARENA).plan(wish)
    if given and isinstance(answer, str):
        assert "bytes" in answer or "Hz" in answer
        pytest.skip(answer)
    way = BoardPlanner(ARENA).plan(wish)
    filter = Estimator(way.estimator), way.first, way.second
    run = render(tmp_path, way.program, way.rate, 0.3, SWEEP, filter)
    assert run.share <= MOST
    assert run.skipped == 0
    assert 0 < run.summary["interrupts_off_cycles"] <= 250
    assert np.ptp([shown.count for shown in run.telemetry]) > 1000
    if not given:
        assert way.rate >= (RATES[0] if key in FASTEST else RATES[-1] if key in SLOWEST else 2000)


@pytest.mark.parametrize("method", [("difference", {}), ("iir", {"cutoff": 35.5}), ("kalman", {"q": 1e-2})])
def test_the_boards_velocity_equals_the_computers(tmp_path, method):
    _, numbers = design(method, 1000.0, QUANTUM)
    kind = {"difference": Estimator.DIFFERENCE, "iir": Estimator.IIR, "kalman": Estimator.KALMAN}[method[0]]
    filter = kind, float(numbers[0]), float(numbers[1] * 1000.0)
    law = program(environments()["free"], {}, 1000, ARENA)
    shown = render(tmp_path, law, 1000, 0.35, SWEEP, filter).telemetry
    position = QUANTUM * np.array([s.count for s in shown])
    wanted = estimate_velocity(position, 1000.0, method, QUANTUM)
    assert np.abs(wanted).max() > 0.2
    got = np.array([s.velocity for s in shown])
    np.testing.assert_allclose(got[50:], wanted[50:], rtol=1e-4, atol=2e-5)
