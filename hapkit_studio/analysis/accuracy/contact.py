"""Contact: how a mass's energy changes in bounces off a springy wall, with each method of simulating contact.

An ideal spring returns all energy, so every change is an error. The mass is the puck, which bounces between
its two walls.
"""

import math
from collections.abc import Iterator
from functools import partial

import numpy as np

from hapkit_studio import environments
from hapkit_studio.analysis.accuracy.integrators import STEPS
from hapkit_studio.analysis.accuracy.plan import FELT, Motion, Plan, Point, Run, Scene
from hapkit_studio.dynamics.contact import held, located
from hapkit_studio.dynamics.integrators import INTEGRATORS, Body, drive, instants
from hapkit_studio.dynamics.moving_mass import FAR
from hapkit_studio.environments.puck import REACH

BOUNCES = 100
MASS, WALL = (environments.named("puck").values()[key] for key in ("mass", "wall_stiffness"))
SHOVED, PUCK_FROM = 0.5, 0.010  # m/s, m: initial speed of the handle, and initial position of the puck
SECONDS = (BOUNCES + 1) * (math.pi * math.sqrt(MASS / WALL) + 2.0 * REACH / SHOVED)
LABELS = {
    "held": "Spring, held force", "semi_implicit": "Spring, semi-implicit", "verlet": "Spring, Verlet",
    "located": "Verlet, contact located", "exact": "Exact",
}  # fmt: skip


def bouncing(method: str, h: float, drift: bool, times: int = 1) -> Motion:
    """Return the motion of the puck in steps of h s.

    Its error is the relative change of energy: the rms over the bounces, or, with ``drift``, the total
    change.
    """
    t = instants(SECONDS, h)
    x, v = np.full_like(t, PUCK_FROM), np.full_like(t, SHOVED)
    if method in INTEGRATORS:
        numbers = Body(MASS, reach=REACH, wall=WALL).numbers()
        given = numbers, np.zeros_like(t), np.full_like(t, -FAR)
        work = partial(drive, float(INTEGRATORS.index(method)), times, h, *given, x, v)
    else:
        work = partial(held if method == "held" else located, times, h, MASS, WALL, REACH, x, v)

    def error() -> float:
        free = np.abs(x) < REACH
        begins = np.flatnonzero(np.diff(free.astype(int), prepend=0) == 1)[: BOUNCES + 1]
        found = (v[begins] / SHOVED) ** 2  # energies between bounces, relative to the first one
        if drift:
            return abs(float(found[-1]) - 1.0)
        return math.sqrt(np.mean((np.diff(found) / found[:-1]) ** 2))

    return work, error


def runs(scene: Scene) -> Iterator[Run]:
    """Yield the runs of every contact method at every step."""
    for key, label in LABELS.items():
        for h in STEPS:
            yield Point(key, label, h), partial(bouncing, key, h, scene.key == "drift"), SECONDS


CONDITIONS = (
    ("Mass", f"0.5 kg, {SHOVED:g} m/s"), ("Walls", "500 N/m, 70 mm apart"),
    ("Reference", "no energy lost in a bounce"),
)  # fmt: skip
_SCENES = {
    "bounce": ("Energy per bounce", "energy change in a bounce / energy"),
    "drift": ("Energy drift over 100 bounces", f"energy change over {BOUNCES} bounces / start energy"),
}
PLAN = Plan(
    "contact",
    "Contact",
    "Which way of computing a contact keeps the energy constant, and at what cost?",
    LABELS,
    tuple(Scene(key, title, error, 0.02, FELT, "", CONDITIONS) for key, (title, error) in _SCENES.items()),
    runs,
    order=15,
)
