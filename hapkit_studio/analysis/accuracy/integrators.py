"""Integrators: the error of each integrator in an object's motion, at steps from 0.125 to 4 ms.

The oscillating mass has the environment's default values. In the stick-slip scene a spring pulls a light
slider; the literature gives a formula for the period. The cost on the board is that of the whole law of an
environment that uses the integrator.
"""

import math
from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from hapkit_studio import environments
from hapkit_studio.analysis.accuracy.plan import FELT, Motion, Plan, Point, Run, Scene, board_cycles
from hapkit_studio.dynamics.integrators import INTEGRATORS, Body, drive, instants
from hapkit_studio.dynamics.moving_mass import FAR
from hapkit_studio.dynamics.stick_slip import exact_period, period_error
from hapkit_studio.environments.pushed import LABELS

DEFLECTION, DRAWN = 0.010, 0.02  # initial deflection in m; speed of the spring's end in m/s
METHODS = dict(zip(INTEGRATORS, LABELS, strict=True))
STEPS = (4e-3, 2e-3, 1e-3, 0.5e-3, 0.25e-3, 0.125e-3)


def swinging(body: Body, method: str, h: float, times: int = 1) -> Motion:
    """Return the motion of a mass on a spring and a damper for 1 s, released 10 mm off the equilibrium.

    Its error is the largest distance from the closed-form solution, divided by the initial deflection.
    """
    t = instants(1.0, h)
    x, v = np.full_like(t, DEFLECTION), np.zeros_like(t)
    given = body.numbers(), np.zeros_like(t), np.full_like(t, -FAR)
    work = partial(drive, float(INTEGRATORS.index(method)), times, h, *given, x, v)

    def error() -> float:
        rate = body.damping / (2.0 * body.mass)
        omega = math.sqrt(body.stiffness / body.mass - rate * rate)
        true = DEFLECTION * np.exp(-rate * t) * (np.cos(omega * t) + rate / omega * np.sin(omega * t))
        return float(np.abs(x - true).max()) / DEFLECTION

    return work, error


def stick_slip(method: str, h: float, times: int = 1) -> Motion:
    """Return the motion of a slider on a rough ground for 3 s; a spring's end pulls it at 2 cm/s.

    Its error is the relative error of the period.
    """
    body, t = Body(0.05, stiffness=300.0, static=1.0, kinetic=0.5), instants(3.0, h)
    pull, x, v = body.stiffness * DRAWN * t, np.zeros_like(t), np.zeros_like(t)
    true = exact_period(body.mass, body.stiffness, body.static, body.kinetic, DRAWN)
    given = body.numbers(), pull, np.full_like(t, -FAR)
    work = partial(drive, float(INTEGRATORS.index(method)), times, h, *given, x, v)
    return work, lambda: period_error(t, pull - body.stiffness * x, true)


_VALUES = environments.named("mass_spring_damper").values()
FREE = Body(_VALUES["mass"], 0.0, _VALUES["stiffness"])
DAMPED = Body(_VALUES["mass"], _VALUES["damping"], _VALUES["stiffness"])
MOTIONS: dict[str, tuple[Callable[..., Motion], float, str]] = {
    "damped": (partial(swinging, DAMPED), 1.0, "mass_spring_damper"),
    "free": (partial(swinging, FREE), 1.0, "mass_spring_damper"),
    "stick_slip": (stick_slip, 3.0, "puck"),
}


def runs(scene: Scene) -> Iterator[Run]:
    """Yield the runs of every integrator at every step."""
    motion, seconds, law = MOTIONS[scene.key]
    for key, label in METHODS.items():
        for h in STEPS:
            cycles = board_cycles(law, "integrator", key, 1.0 / h)
            yield Point(key, label, h, cycles=cycles), partial(motion, key, h), seconds


_SWINGING = (
    ("Mass", f"{FREE.mass:g} kg"), ("Stiffness", f"{FREE.stiffness:,g} N/m"), ("Start", "10 mm, at rest"),
    ("Exact", "state matrix precomputed"), ("Reference", "exact formula, 1 s"),
)  # fmt: skip
_STICKING = (
    ("Mass", "0.05 kg"), ("Spring", "300 N/m, pulled at 2 cm/s"), ("Friction", "1 N, then 0.5 N"),
    ("Reference", "exact formula, 3 s"),
)  # fmt: skip
_DAMPER = ("Damping", f"{DAMPED.damping:g} N·s/m")
_FIRST, _THIRD = "largest error / initial deflection", f"{FELT}. Force is proportional to motion"
_PERIOD = f"{FELT}. A period is the time from one slip to the next"
PLAN = Plan(
    "integrators",
    "Integrators",
    "Which integrator is most accurate for its cost?",
    METHODS,
    (
        Scene("damped", "Damped mass", _FIRST, 0.02, _THIRD, "", (*_SWINGING, _DAMPER)),
        Scene("free", "Free mass", _FIRST, 0.02, _THIRD, "", _SWINGING),
        Scene("stick_slip", "Stick-slip", "error of the period / period", 0.02, _PERIOD, "", _STICKING),
    ),
    runs,
    order=10,
)
