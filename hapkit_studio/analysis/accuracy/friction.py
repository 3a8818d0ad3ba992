"""Friction models: the accuracy of their stick-slip, and their drift under a small vibrating load.

In the test of stick-slip, a spring pulls a virtual mass. In the test of drift, the load is smaller than the
friction, and the friction environment's law renders each model on the handle with the loop's own tick.
"""

import math
from collections.abc import Callable
from functools import partial

import numpy as np

from hapkit_studio import environments
from hapkit_studio.analysis.accuracy import plan
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics import stick_slip
from hapkit_studio.dynamics.hand import Hand
from hapkit_studio.dynamics.integrators import instants
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.dynamics.stick_slip import MODELS
from hapkit_studio.environments.friction import MODELS as RENDERED
from hapkit_studio.haptics import headless, rows

MASS, STATIC, KINETIC = 0.05, 1.0, 0.5
SPRING, DRAWN, DRAWN_SECONDS = 300.0, 0.02, 6.0
# N, N, Hz: a constant pull, and amplitude and frequency of an added vibration; their sum is below the kinetic
# friction
PULL, TREMBLING, TREMOR = 0.3, 0.15, 20.0
HELD_SECONDS, HELD_FROM = 3.0, 1.0
# m/s: initial speed of the handle. Each model must bring the sliding handle to rest; starting at rest would
# favour a model without stiction.
SLIDES_IN = 0.02
_SOFT = 1.0  # N/m: the spring is so soft that its pull does not depend on the handle's position
STEPS = (4e-3, 2e-3, 1e-3, 0.5e-3, 0.2e-3, 0.1e-3)
LABELS = {key: key.replace("_", " ").capitalize() for key in MODELS}
LABELS |= {"lugre": "LuGre", "hayward_armstrong": "Hayward–Armstrong"}


def drawn(model: str, dt: float, times: int = 1) -> tuple[plan.Work, Callable[[], float]]:
    """Return two functions: the first computes a model's stick-slip, the second returns its period error."""
    code, declared = MODELS[model]
    options = np.array([*(p.default for p in declared), 0.0])
    t = instants(DRAWN_SECONDS, dt)
    applied, x, v = SPRING * DRAWN * t, np.zeros_like(t), np.zeros_like(t)
    levels, memory = (MASS, SPRING, 0.0, STATIC, KINETIC), np.zeros(stick_slip.MEMORY)
    period = stick_slip.exact_period(MASS, SPRING, STATIC, KINETIC, DRAWN)
    work = partial(stick_slip.run, code, times, applied, *levels, options, dt, memory, x, v)
    return work, lambda: stick_slip.period_error(t, applied - SPRING * x, period)


def period_error(model: str, dt: float) -> float:
    """Return the relative period error of a model."""
    work, error = drawn(model, dt)
    work()
    return error()


def at_rest(model: str, dt: float, times: int = 1) -> Callable[[], np.ndarray]:
    """Return a function that renders a friction model on a frictionless handle, which slides and stops."""
    law = environments.named("friction")
    levels = {"model": model, "static_force": STATIC, "kinetic_force": KINETIC}
    handle = SimulatedHapkit(coulomb_force=0.0, max_force=math.inf, initial_velocity=SLIDES_IN)
    scene = headless.Scene(law, law.values(levels), handle, LoopSettings(1.0 / dt))

    def target(t):
        return (PULL + TREMBLING * np.sin(2.0 * math.pi * TREMOR * t)) / _SOFT

    pull = Hand(stiffness=_SOFT, target=target, vectorised=True)
    return headless.prepare_run(scene, pull, times * round(HELD_SECONDS / dt) + 1).run


def handle_drift(model: str, dt: float) -> float:
    """Return the mean drift of the handle in m/s from HELD_FROM on; inf if not finite."""
    x = at_rest(model, dt)()[:, rows.TRUE_POSITION]
    found = abs(float(x[-1] - x[round(HELD_FROM / dt)])) / (HELD_SECONDS - HELD_FROM)
    return found if math.isfinite(found) else math.inf


def _draw(*given):
    return drawn(*given)[0]


def runs(scene: plan.Scene) -> list[plan.Run]:
    """Return the runs of every model at every step."""
    handle = scene.key == "handle"
    seconds, found = HELD_SECONDS if handle else DRAWN_SECONDS, []
    for model in RENDERED if handle else MODELS:
        for dt in STEPS:
            times = plan.repeats(round(seconds / dt))
            prepare: plan.Prepare = partial(at_rest if handle else _draw, model, dt, times)
            error = handle_drift(model, dt) if handle else period_error(model, dt)
            cycles = plan.board_cycles("friction", "model", model, 1.0 / dt) if handle else math.nan
            found.append((plan.Point(model, LABELS[model], dt, error, cycles), prepare, times * seconds))
    return found


RESTING = "A handle rests if it drifts by less than one count of the Hapkit's sensor (20.7 µm) in two seconds"
_LEVELS, _DRAWN = ("Friction", "1 N, then 0.5 N"), ("Mass", "0.05 kg, pulled by 300 N/m at 2 cm/s")
PLAN = plan.Plan(
    "friction",
    "Friction",
    "Which friction model slips at the right time and holds at rest, and at what cost?",
    LABELS,
    (
        plan.Scene(
            "period", "Stick-slip of a mass", "error of the period / period", 0.02,
            f"{plan.FELT}; a period is the time from one slip to the next", "",
            (_DRAWN, _LEVELS, ("Reference", "exact formula")),
        ),
        plan.Scene(
            "handle", "A handle held by friction", "drift of the handle at rest", 1e-5, RESTING, "m/s",
            (
                ("Handle", "0.044 kg, 0.5 N·s/m"), ("Sensor", "20.7 µm"),
                ("Pull", "0.3 N ± 0.15 N at 20 Hz"), _LEVELS, ("Reference", "no drift"),
            ),
        ),
    ),
    runs,
    order=40,
)  # fmt: skip
