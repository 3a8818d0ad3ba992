"""What a bounce and what friction leave of a moving mass's energy, integrator by integrator."""

from dataclasses import replace

import numpy as np
import pytest

from hapkit_studio.dynamics.integrators import INTEGRATORS, step
from tests.dynamics.reference_mass import World

OF = {name: float(n) for n, name in enumerate(INTEGRATORS)}

# energy out over energy in of one bounce off a spring at three h = omega dt: mean over the phase, range
BOUNCES = {
    "explicit_euler": ((1.275, None), (1.624, None), (2.610, None)),
    "lecture": ((1.275, None), (1.618, None), (2.536, None)),
    "semi_implicit": ((1.0, 0.0015), (1.0, 0.0045), (1.0, 0.008)),
    "verlet": ((1.0, 0.0015), (1.0, 0.0045), (1.0, 0.008)),
    "rk4": ((1.0, 0.0006), (1.0, 0.003), (1.0, 0.007)),
    "implicit_euler": ((0.784, None), (0.616, None), (0.383, None)),
}


def bounce(method, dt, phase):
    """Return energy out over energy in of 0.05 kg that meets a spring of 300 N/m."""
    world = World(m=0.05, reach=0.01, wall=300.0)
    x, v, before = 0.01 - (1.0 + phase) * 0.1 * dt, 0.1, 0.0
    for _ in range(round(0.1 / dt)):
        x, v, before = step(OF[method], x, v, before, dt, 0.0, *world.numbers)
    assert x < 0.01
    return (v / 0.1) ** 2


def bounces(method, dt):
    return np.array([bounce(method, dt, phase) for phase in np.arange(0.005, 1.0, 0.01)])


@pytest.mark.parametrize("method", BOUNCES)
def test_energy_of_a_bounce(method):
    for dt, (mean, reach) in zip((1e-3, 2e-3, 4e-3), BOUNCES[method], strict=True):
        found = bounces(method, dt)
        assert found.mean() == pytest.approx(mean, rel=2e-3), dt
        if reach is not None:
            assert [1.0 - found.min(), found.max() - 1.0] == pytest.approx([reach, reach], rel=0.25), dt


def test_energy_of_a_bounce_is_kept_by_exact():
    for dt in (1e-3, 2e-3, 4e-3):
        assert bounces("exact", dt) == pytest.approx(np.ones(100), abs=1e-11)


@pytest.mark.parametrize("method", INTEGRATORS)
def test_friction_brings_it_to_rest_and_holds(method):
    """After m v / F_c, at v^2 m / (2 F_c): 20 ms and 1 mm; exactly still, also under less than F_c."""
    world = World(m=0.1, f=0.0)
    x, v, before, seen = 0.0, 0.1, 0.0, []
    for _ in range(40):
        x, v, before = step(OF[method], x, v, before, 1e-3, 0.5, *world.numbers)
        seen.append((x, v))
    assert seen[9][1] == pytest.approx(0.05, abs=1e-12)
    assert seen[25] == seen[-1]
    assert v == 0.0
    off = 0.0 if method not in ("explicit_euler", "semi_implicit", "implicit_euler") else 0.5 * 0.1 * 1e-3
    assert abs(x - 1e-3) == pytest.approx(off, abs=1e-9)
    pulled = replace(world, f=0.499)
    for _ in range(20):
        q, v, before = step(OF[method], x, v, before, 1e-3, 0.5, *pulled.numbers)
        assert (q, v) == (pytest.approx(x, abs=1e-12), 0.0)
    away = step(OF[method], x, 0.0, 0.501 / 0.1, 1e-3, 0.5, *replace(world, f=0.501).numbers)
    assert away[1] == pytest.approx(0.001 / 0.1 * 1e-3, rel=1e-6)
