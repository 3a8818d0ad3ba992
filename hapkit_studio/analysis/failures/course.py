"""The mass on a spring of a haptics course: with a step of 1 ms its oscillation in contact grows."""

import math
from dataclasses import replace

import numpy as np

from hapkit_studio.analysis.failures import base
from hapkit_studio.analysis.failures.integrators import METHOD, growth_per_radian, method_of
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.hand import Prescribed
from hapkit_studio.dynamics.integrator_stability import longest_step
from hapkit_studio.dynamics.integrators import INTEGRATORS
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.haptics import rows

MASS, DAMPING, SPRING, CONTACT = 2.0, 1.0, 300.0, 1000.0
REST = 0.01
BOTH = SPRING + CONTACT
OMEGA = math.sqrt(BOTH / MASS)
RATIO = DAMPING / (2.0 * MASS * OMEGA)
# m, m, s: the handle moves slowly to PRESSED, steps by NUDGE, and is held still while the mass oscillates
PRESSED, NUDGE, RISE = 0.02, 2e-4, 2.0
SECONDS = 8.0


def limit(case: base.Case) -> float:
    """Return the longest step in s at which the oscillation of the mass in contact does not grow."""
    return longest_step(method_of(case), MASS, DAMPING, BOTH)


def values(method: str) -> dict[str, float]:
    """Return the numbers of the lecture's example as the environment's values."""
    arguments = {"mass": MASS, "damping": DAMPING, "stiffness": SPRING, "contact_stiffness": CONTACT}
    arguments |= {"contact_damping": 0.0, "rest_position": REST}
    return {**arguments, "integrator": float(INTEGRATORS.index(method))}


def _hand_motion(time: float) -> float:
    if time >= RISE:
        return PRESSED + NUDGE
    return REST + (PRESSED - REST) * (0.5 - 0.5 * math.cos(math.pi * time / RISE))


def swing(method: str, step: float) -> np.ndarray:
    """Return the simulated position (n,) of the mass relative to its rest position, while in contact."""
    device = SimulatedHapkit(coulomb_force=0.0, quantum=0.0, max_force=math.inf)
    count, loop = round((RISE + SECONDS) / step), LoopSettings(1.0 / step)
    out = base.render("mass_spring_damper", values(method), device, loop, count, Prescribed(_hand_motion))
    at_rest = (SPRING * REST + CONTACT * (PRESSED + NUDGE)) / BOTH
    place = out[math.ceil(RISE / step) + 2 :, rows.STATE] - at_rest
    return place[: max(base.before_lost(place, PRESSED + NUDGE - at_rest), 2)]


def rate_of(x: np.ndarray, step: float) -> float:
    """Return the growth in 1/s of an oscillation x (n,) about 0."""
    speed = np.gradient(x, step) if len(x) > 2 else np.zeros(len(x))
    return base.growth(np.hypot(x, speed / OMEGA), step)


def probe(step: float, case: base.Case) -> base.Evidence:
    """Press the handle against the mass, nudge it and hold it still."""
    x, true = swing(method_of(case), step), "; the true motion decays at 0.25 1/s"
    return base.growth_evidence(1e3 * x, step, rate_of(x, step), "distance of the mass from rest", more=true)


def exact(step: float, case: base.Case) -> float:
    """Return the growth of the oscillation in 1/s according to the method's formula."""
    return OMEGA * growth_per_radian(method_of(case), RATIO, OMEGA * step)


_ADVICE = (
    "Drag to 30 mm and hold the mass there for half a minute. A real mass would then be at rest, but this "
    "one still oscillates if the step is too long."
)


def live(step: float, case: base.Case) -> base.Live:
    """Return the live settings of the mass on a spring, with a time step of ``step`` s."""
    loop = {"rate": base.live_rate(1.0 / step)}
    return base.Live("mass_spring_damper", values(method_of(case)), loop, "firm", _ADVICE)


FAILURE = base.Failure(
    key="course",
    title="The course's mass–spring–damper with 1 ms steps",
    summary="With the integrator Lecture's rule, the oscillation grows by 8 % per second, although a "
    "damper acts",
    formula="Explicit Euler and the lecture's rule are stable if dt < b/k = 1/1,300 s = 0.77 ms, with "
    "step dt, damping b and stiffness k",
    explanation="A mass of 2 kg with a spring (300 N/m) and a damper (1 N·s/m) touches a handle "
    "that is held still; the contact is a second spring (1,000 N/m), so the total stiffness k is 1,300 N/m. "
    "The mass's true oscillation decays at 0.25 1/s. The lecture's rule uses the mean of the last two "
    "accelerations, so it is late by one step. This acts like a negative damping −k dt: −1.3 N·s/m at 1 ms, "
    "more than the damper's 1 N·s/m, so the oscillation grows. Semi-implicit Euler needs the same computing "
    "time and is stable up to 78 ms.",
    knob=base.Parameter("step", "Step", "s", 1e-3, 1e-4, 0.2, "Step of the loop and of the integrator", "dt"),
    limit=limit,
    probe=probe,
    plot=base.Plot(
        "time step, ms",
        lambda case: np.geomspace(0.1e-3, 7e-3, 25),
        (
            base.Curve("theory", exact, base.THEORY),
            base.Curve("simulation"),
            base.Curve("true motion", lambda step, case: -DAMPING / (2.0 * MASS), base.OTHER),
        ),
        "limit",
        lambda case: {"1 ms": 1e-3, "230 Hz": 1.0 / 230.0},
        log_x=True,
        factor=1e3,
    ),
    options=(replace(METHOD, default_option="lecture"),),
    live=live,
    order=3,
)
