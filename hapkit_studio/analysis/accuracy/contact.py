"""Contact: how a mass's energy changes in bounces off a springy wall, with each method of simulating contact.

An ideal spring returns all energy, so every change is an error. The mass is the puck, which bounces between
its two walls.
"""

import math
from collections.abc import Callable
from functools import partial

import numpy as np

from hapkit_studio import environments
from hapkit_studio.analysis.accuracy.integrators import STEPS
from hapkit_studio.analysis.accuracy.plan import FELT, Plan, Point, Run, Scene, always, repeats
from hapkit_studio.dynamics.contact import held, located
from hapkit_studio.dynamics.integrators import INTEGRATORS, Body, drive, instants
from hapkit_studio.dynamics.moving_mass import FAR
from hapkit_studio.environments.puck import REACH

BOUNCES = 100
MASS, WALL = (environments.named("puck").values()[key] for key in ("mass", "wall_stiffness"))
SHOVED, PUCK_FROM = 0.5, 0.010  # m/s, m: initial speed of the handle, and initial position of the puck
Motion = tuple[Callable[[], object], np.ndarray, np.ndarray]
LABELS = {
    "held": "Penalty, held force", "semi_implicit": "Penalty, semi-implicit", "verlet": "Penalty, Verlet",
    "located": "Verlet, contact located", "exact": "Exact",
}  # fmt: skip


def moving(method: str, h: float, seconds: float, times: int = 1) -> Motion:
    """Return a function that computes the motion in steps of h s, and the arrays (n,) that it fills."""
    t = instants(seconds, h)
    x, v = np.full_like(t, PUCK_FROM), np.full_like(t, SHOVED)
    if method in INTEGRATORS:
        body = Body(MASS, reach=REACH, wall=WALL)
        given = body.numbers(), np.zeros_like(t), np.full_like(t, -FAR)
        return partial(drive, float(INTEGRATORS.index(method)), times, h, *given, x, v), x, v
    return partial(held if method == "held" else located, times, h, MASS, WALL, REACH, x, v), x, v


def energies(method: str, h: float, bounces: int = BOUNCES) -> np.ndarray:
    """Return the energies (bounces + 1,) between bounces, relative to the first; NaN becomes inf."""
    one = math.pi * math.sqrt(MASS / WALL) + 2.0 * REACH / SHOVED
    work, x, v = moving(method, h, (bounces + 1) * one)
    work()
    free = np.abs(x) < REACH
    begins = np.flatnonzero(np.diff(free.astype(int), prepend=0) == 1)[: bounces + 1]
    found = (v[begins] / SHOVED) ** 2
    return np.where(np.isfinite(found), found, np.inf)


def error(method: str, h: float, drift: bool) -> float:
    """Return the relative change of energy: the rms of all bounces, or the total change if ``drift``."""
    found = energies(method, h)
    with np.errstate(all="ignore"):
        off = abs(found[-1] - 1.0) if drift else math.sqrt(np.mean((np.diff(found) / found[:-1]) ** 2))
    return float(off) if math.isfinite(off) else math.inf


def runs(scene: Scene) -> list[Run]:
    """Return the runs of every contact method at every step."""
    made = []
    for key, label in LABELS.items():
        for h in STEPS:
            times = repeats(round(1.0 / h))
            work, off = always(moving(key, h, 1.0, times)[0]), error(key, h, scene.key == "drift")
            made.append((Point(key, label, h, off), work, float(times)))
    return made


CONDITIONS = (
    ("Mass", f"0.5 kg, {SHOVED:g} m/s"), ("Walls", "500 N/m, 70 mm apart"),
    ("Reference", "no energy lost in a bounce"),
)  # fmt: skip
PLAN = Plan(
    "contact",
    "Contact",
    "Which way of computing a contact keeps the energy constant, and at what cost?",
    LABELS,
    tuple(
        Scene(key, title, error, 0.02, FELT, "", CONDITIONS)
        for key, title, error in (
            ("bounce", "Energy per bounce", "energy change in a bounce / energy"),
            (
                "drift",
                "Energy drift over 100 bounces",
                f"energy change over {BOUNCES} bounces / start energy",
            ),
        )
    ),
    runs,
    order=15,
)
