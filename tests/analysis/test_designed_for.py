"""A Kalman filter is designed for the sensor's quantum, and limits use the same filter."""

import math

import numpy as np
import pytest
from scipy.linalg import expm, solve_discrete_are

from hapkit_studio.analysis.stability.kb_plane import exact_boundary, passive_edge, passivity_line
from hapkit_studio.analysis.stability.limits import stiffness_limit
from hapkit_studio.dynamics.loop_settings import LoopSettings

MASS, VISCOUS, PERIOD, DAMPING = 0.044, 0.5, 1e-3, 5.0
# columns: quantum in m, agility q in m²/s³, limit in N/m by scipy's Riccati solver and eigenvalues
WORKED = [(5e-6, 1e-2, 9553), (61e-6, 1e-2, 3628), (61e-6, 1e-3, 1448), (200e-6, 1e-3, 403)]


def spec(q):
    return "kalman", {"q": q}


def setting(quantum, q, **more):
    return LoopSettings(mass=MASS, viscous=VISCOUS, quantum=quantum, estimator=spec(q), **more)


def gains(quantum, q):
    """Return transition and gains of the steady-state filter; positions are in quanta, time in periods."""
    move = np.array([[1.0, 1.0], [0.0, 1.0]])
    noise = q * PERIOD**3 / quantum**2 * np.array([[1 / 3, 1 / 2], [1 / 2, 1.0]])
    see = np.array([[1.0, 0.0]])
    p = solve_discrete_are(move.T, see.T, noise, np.array([[1.0 / 12.0]]))
    gain = (p @ see.T / (p[0, 0] + 1.0 / 12.0)).ravel()
    scale = np.diag([1.0, 1.0 / PERIOD])
    a = move - np.outer(gain, [1.0, 0.0]) @ move
    return scale @ a @ np.linalg.inv(scale), scale @ gain


def largest_root(stiffness, damping, quantum, q):
    """Return the growth per period of the loop, whose states are handle x, v and filter x, v."""
    a, gain = gains(quantum, q)
    pad = np.zeros((3, 3))
    pad[0, 1], pad[1, 1:] = 1.0, (-VISCOUS / MASS, 1.0 / MASS)
    step = expm(pad * PERIOD)
    loop = np.zeros((4, 4))
    loop[:2, :2], loop[2:, 0], loop[2:, 2:] = step[:2, :2], gain, a
    command = -np.array([stiffness + damping * gain[1], 0.0, *(damping * a[1])])
    loop[:2] += np.outer(step[:2, 2], command)
    return np.abs(np.linalg.eigvals(loop)).max()


@pytest.mark.parametrize(("quantum", "q", "limit"), WORKED)
def test_the_exact_limit_uses_the_devices_own_filter(quantum, q, limit):
    found = exact_boundary(setting(quantum, q), np.array([DAMPING]))[0]
    assert found == pytest.approx(limit, abs=0.6)
    inside, outside = (largest_root(share * found, DAMPING, quantum, q) for share in (0.99, 1.01))
    assert inside < 1.0 < outside
    assert stiffness_limit(MASS, VISCOUS, damping=DAMPING, estimator=spec(q), quantum=quantum) == found


@pytest.mark.parametrize("quantum", [5e-6, 61e-6])
def test_the_passivity_line_uses_the_devices_own_filter(quantum):
    """The condition by Colgate & Schenkel is b > T/2 Re((1 - e^-jw) C(e^jw)) / (1 - cos w) at every w.

    C is K + B H, where H is the filter's transfer function from position to velocity.
    """
    a, gain = gains(quantum, 1e-2)
    w = np.linspace(0.0, math.pi, 4001)[1:]
    out = [a[1] @ np.linalg.solve(z * np.eye(2) - a, gain.astype(complex)) + gain[1] for z in np.exp(1j * w)]
    needed = 0.5 * PERIOD * ((1.0 - np.exp(-1j * w)) * np.array(out)).real / (1.0 - np.cos(w))
    damping = 0.3
    want = 2.0 / PERIOD * (VISCOUS - damping * needed.max())
    assert passivity_line(setting(quantum, 1e-2), np.array([damping]))[0] == pytest.approx(want, rel=1e-3)
    most = VISCOUS / needed.max()
    assert passive_edge(setting(quantum, 1e-2))[0][-1] == pytest.approx(most, rel=1e-3)
