"""A user's law that plays back a measured object from tables, and the same force computed with numpy."""

import numpy as np

FORCES = (0.0, -0.05, -0.12, -0.2, -0.42, -0.86, -1.15, -0.9, -0.4, -0.6, -1.1, -1.9, -2.5, -2.8)  # N
STEP = 0.002  # m
STRIPES = (0.3, -0.2, 0.1)  # N·s/m: damping of consecutive stripes
TEXT = f'''"""An object that was measured: forces every 2 mm, straight lines between, striped damping."""

import math

from hapkit_studio.environments.base import Environment
from hapkit_studio.laws import law
from hapkit_studio.parameters import Parameter

FORCES = {FORCES}
STRIPES = list({STRIPES})


def forces(i):
    return FORCES[i]


@law
def force(p, s, x, v, dt):
    place = (x + 0.01) / {STEP}
    drag = STRIPES[math.floor(place) % len(STRIPES)] * v
    if place < 0.0:
        return -drag
    if place >= len(FORCES) - 1:
        return p.gain * FORCES[len(FORCES) - 1] - drag
    i = math.floor(place)
    share = place - i
    return p.gain * (forces(i) * (1.0 - share) + FORCES[i + 1] * share) - drag


ENVIRONMENT = Environment(
    key="measured_object", title="Measured object", summary="Played back from tables", force=force,
    parameters=(Parameter("gain", "Gain", "", 1.0, 0.0, 2.0),),
)
'''


def force(x, v, gain=1.0):
    """Return the law's force (n,) in N at positions x (n,) in m and velocities v (n,) in m/s."""
    places = STEP * np.arange(len(FORCES)) - 0.01
    stripe = np.floor((x + 0.01) / STEP).astype(int) % len(STRIPES)
    return gain * np.interp(x, places, FORCES, left=0.0) - np.array(STRIPES)[stripe] * v
