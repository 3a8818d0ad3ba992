"""What had been set, and what the loop must make of it on this very motion.

A command is held for a period T and comes td late, so the force at the handle lags the position by
T / 2 + td: of -K x it makes -K x + K (T / 2 + td) v, a damping of B - K (T / 2 + td). The velocity estimate
comes later still: of -B v it makes some stiffness as well, B w^2 times its lag.
"""

from dataclasses import dataclass

import numpy as np

from hapkit_studio.analysis.identify.grid import Grid
from hapkit_studio.analysis.identify.recording import Setup
from hapkit_studio.environments.friction import COULOMB, SMOOTHED
from hapkit_studio.workshop.own import taken_keys


@dataclass(frozen=True)
class Asked:
    """What was set, in the terms that are identified; None for what the scene does not set.

    one_way: +1 or -1 where damping acts only on motion to that side; contact: only while the law pushes;
    settle: how far the handle goes after a turn until friction is all there, in m; simple: the law is no more
    than these numbers.
    """

    stiffness: float | None = None
    damping: float | None = None
    friction: float | None = None
    centre: float | None = None
    one_way: float = 0.0
    contact: bool = False
    settle: float = 0.0
    simple: bool = True
    terms: tuple[str, ...] = ("stiffness", "damping", "friction")


BOTH = ("stiffness", "damping")


def asked(setup: Setup) -> Asked:
    """Return what was set; an environment whose force is no spring, damper or friction sets nothing."""
    p, key = setup.values, setup.environment.key if setup.environment else ""
    if key == "free":
        return Asked(0.0, 0.0, terms=BOTH)
    if key == "spring":
        return Asked(p["stiffness"], p["damping"], centre=p["center"], terms=BOTH)
    if key == "damping":
        return Asked(0.0, p["damping"], terms=BOTH)
    if key == "wall":
        return _wall(p)
    if key == "hard_surface":
        return Asked(p["stiffness"], p["damping"], None, p["position"], 1.0, True, simple=False, terms=BOTH)
    if key == "friction":
        return _friction(p)
    return _other(setup)


def _other(setup: Setup) -> Asked:
    """Return what a person's own environment says of itself; others of the library set nothing."""
    environment = setup.environment
    if environment is None:
        return Asked(simple=False)
    if environment.impedance is None or environment.key in taken_keys():
        return Asked(contact=environment.shades, simple=False)
    stiffness, damping = environment.impedance(setup.values)
    return Asked(stiffness, damping, contact=environment.shades, simple=False)


def _wall(p: dict[str, float]) -> Asked:
    side = 1.0 if p["side"] == 0 else -1.0
    damping = 0.0 if p["damping_mode"] == 2 else p["damping"]
    one_way = side if p["damping_mode"] == 0 and damping > 0.0 else 0.0
    return Asked(p["stiffness"], damping, None, p["position"], one_way, True, terms=BOTH)


def _friction(p: dict[str, float]) -> Asked:
    plain = p["model"] in (COULOMB, SMOOTHED)
    level = max(p["static_force"], p["kinetic_force"])
    settle = 0.0 if plain else 2.0 * level / p["tether_stiffness"]
    terms = ("damping", "friction")
    return Asked(
        None, p["viscous"], p["kinetic_force"], settle=settle, simple=p["model"] == COULOMB, terms=terms
    )


def commands(grid: Grid, what: Asked) -> np.ndarray | None:
    """Return the commands (n,) in N of what was set, for the motion the law saw; None if not simple."""
    if not what.simple:
        return None
    depth, rate = grid.seen - (what.centre or 0.0), grid.speed
    if what.one_way:
        rate = np.where(rate * what.one_way > 0.0, rate, 0.0)
    force = -(what.stiffness or 0.0) * depth - (what.damping or 0.0) * rate
    return force - (what.friction or 0.0) * np.sign(grid.speed)


def lag(setup: Setup) -> float:
    """Return by how much the force lags the position on average, in s: half a period and the delay."""
    return 0.5 / setup.rate + setup.delay
