"""Friction models: the accuracy of their stick-slip, and their drift under a small vibrating load.

In the test of stick-slip, a spring pulls a virtual mass. In the test of drift, the load is smaller than the
friction. The law of the friction environment renders each model on the handle, with the loop's own tick.
"""

import math
from collections.abc import Iterator
from functools import partial

import numpy as np

from hapkit_studio import environments
from hapkit_studio.analysis.accuracy.plan import FELT, Motion, Plan, Point, Run, Scene, board_cycles
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
# N, N, Hz: a constant pull, and amplitude and frequency of an added vibration; pull plus amplitude is smaller
# than the kinetic friction
PULL, TREMBLING, TREMOR = 0.3, 0.15, 20.0
HELD_SECONDS, HELD_FROM = 3.0, 1.0
# m/s: initial speed of the handle. Each model must bring the sliding handle to rest; starting at rest would
# favour a model without stiction.
SLIDES_IN = 0.02
_SOFT = 1.0  # N/m: the spring is so soft that its pull does not depend on the handle's position
STEPS = (4e-3, 2e-3, 1e-3, 0.5e-3, 0.2e-3, 0.1e-3)
LABELS = {key: key.replace("_", " ").capitalize() for key in MODELS}
LABELS |= {"lugre": "LuGre", "hayward_armstrong": "Hayward–Armstrong"}


def drawn(model: str, dt: float, times: int = 1) -> Motion:
    """Return a model's stick-slip; its error is the relative error of the period."""
    code, declared = MODELS[model]
    options = np.array([*(p.default for p in declared), 0.0])
    t = instants(DRAWN_SECONDS, dt)
    applied, x, v = SPRING * DRAWN * t, np.zeros_like(t), np.zeros_like(t)
    levels, memory = (MASS, SPRING, 0.0, STATIC, KINETIC), np.zeros(stick_slip.MEMORY)
    period = stick_slip.exact_period(MASS, SPRING, STATIC, KINETIC, DRAWN)
    work = partial(stick_slip.run, code, times, applied, *levels, options, dt, memory, x, v)
    return work, lambda: stick_slip.period_error(t, applied - SPRING * x, period)


def at_rest(model: str, dt: float, times: int = 1) -> Motion:
    """Return the motion of a frictionless handle that a friction model brings to rest.

    Its error is the mean drift of the handle in m/s from HELD_FROM on.
    """
    law = environments.named("friction")
    levels = {"model": model, "static_force": STATIC, "kinetic_force": KINETIC}
    handle = SimulatedHapkit(coulomb_force=0.0, max_force=math.inf, initial_velocity=SLIDES_IN)
    scene = headless.Scene(law, law.values(levels), handle, LoopSettings(1.0 / dt))

    def target(t):
        return (PULL + TREMBLING * np.sin(2.0 * math.pi * TREMOR * t)) / _SOFT

    pull = Hand(stiffness=_SOFT, target=target, vectorised=True)
    made = headless.prepare_run(scene, pull, times * round(HELD_SECONDS / dt) + 1)

    def drift() -> float:
        x = made.out[:, rows.TRUE_POSITION]
        return abs(float(x[-1] - x[round(HELD_FROM / dt)])) / (HELD_SECONDS - HELD_FROM)

    return made.run, drift


def runs(scene: Scene) -> Iterator[Run]:
    """Yield the runs of every model at every step."""
    handle = scene.key == "handle"
    motion, seconds = (at_rest, HELD_SECONDS) if handle else (drawn, DRAWN_SECONDS)
    for model in RENDERED if handle else MODELS:
        for dt in STEPS:
            cycles = board_cycles("friction", "model", model, 1.0 / dt) if handle else math.nan
            yield Point(model, LABELS[model], dt, cycles=cycles), partial(motion, model, dt), seconds


RESTING = "A handle rests if it drifts by less than one count of the Hapkit's sensor (20.7 µm) in two seconds"
_LEVELS, _DRAWN = ("Friction", "1 N, then 0.5 N"), ("Mass", "0.05 kg, pulled by 300 N/m at 2 cm/s")
PLAN = Plan(
    "friction",
    "Friction",
    "Which friction model slips at the right time and holds at rest, and at what cost?",
    LABELS,
    (
        Scene(
            "period", "Stick-slip of a mass", "error of the period / period", 0.02,
            f"{FELT}. A period is the time from one slip to the next", "",
            (_DRAWN, _LEVELS, ("Reference", "exact formula")),
        ),
        Scene(
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
