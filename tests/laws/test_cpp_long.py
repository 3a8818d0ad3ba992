"""Laws of the board over a long time: what single precision rounds at every tick must not add up."""

import numpy as np
import pytest

from tests.laws import board_laws
from tests.laws.board_laws import ENVIRONMENTS, Job, by_python, needs_compiler, single

pytestmark = needs_compiler

BOUND = 2e-3  # N
QUANTUM = 20.7e-6  # m


@pytest.fixture(scope="module")
def driver(tmp_path_factory):
    """Return the board's laws, built with the sanitizers."""
    return board_laws.build(tmp_path_factory.mktemp("laws"), "driver")


def asked(driver, key, given, rate, rows):
    """Return the job and what the board makes of it: force (n,), state after (n, k)."""
    job = Job(ENVIRONMENTS[key], ENVIRONMENTS[key].values(given), 1.0 / rate, single(rows))
    return job, *board_laws.run(driver, [job])[0]


@pytest.mark.parametrize("rate", [500.0, 1000.0, 2000.0])
def test_the_longest_and_highest_ringing_keeps_time(driver, rate):
    """Against the formula: the slowest decay, 400 Hz, a tap at 0.3 m/s, then held on the surface."""
    sound = {"amplitude": 100.0, "decay": 5.0, "frequency": 400.0, "limit": 3.0}
    rows = np.zeros((round(2.0 * rate), 2))
    rows[1:, 0] = QUANTUM
    rows[1, 1] = 0.3
    given = {"stiffness": 0.0, "position": 0.0} | sound
    _, force, _ = asked(driver, "hard_surface", given, rate, rows)
    since = np.arange(len(rows) - 1) * float(np.float32(1.0 / rate))
    ringing = 100.0 * 0.3 * np.exp(-5.0 * since) * np.sin(2.0 * np.pi * 400.0 * since)
    assert np.ptp(ringing[since > 1.0]) > 0.05
    np.testing.assert_allclose(force[1:], -np.clip(ringing, -3.0, 3.0), atol=BOUND)


@pytest.mark.parametrize("kinetic", [0.0, 1e-3, 0.03, 0.4])
@pytest.mark.parametrize("stiffness", [100.0, 500.0, 2e4])
@pytest.mark.parametrize("model", ["tether", "projection"])
def test_what_slides_does_not_stick_before_it_turns(driver, model, stiffness, kinetic):
    """A slide in counts, most ticks none, then back: between the turns there is kinetic friction alone."""
    rate = 2000.0
    time = np.arange(round(3.0 * rate)) / rate
    there = 0.03 - 0.06 * np.abs(time / 1.5 - 1.0)  # 40 mm/s to the right, then to the left
    x = QUANTUM * np.floor(there / QUANTUM)
    given = {"model": model, "kinetic_force": kinetic, "static_force": 3.0, "tether_stiffness": stiffness}
    rows = np.column_stack([x, np.zeros_like(x)])
    job, force, after = asked(driver, "friction", given | {"viscous": 0.0}, rate, rows)
    slides = np.flatnonzero(after[:, 1] == 0.0)
    for start, end in ((0.0, 1.5), (1.5, 3.0)):
        inside = slides[(slides > start * rate) & (slides < end * rate)]
        assert len(inside)
        level = np.abs(force[inside[0] : round(end * rate)])
        np.testing.assert_allclose(level, kinetic, atol=BOUND)
    np.testing.assert_allclose(force, by_python(job)[0], atol=BOUND)
