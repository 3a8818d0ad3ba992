"""Friction models: how true they make stick-slip, and how well what rests under a trembling pull holds.

Two scenes are a virtual mass alone, drawn by a spring or pulled by less than friction holds: there the
default is projection, as in every integrator of a moving mass. In the third the friction environment's law
renders its models on a handle, by the loop's own tick, and its default is judged.
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
from hapkit_studio.dynamics.stick_slip import MODELS
from hapkit_studio.environments.friction import MODELS as RENDERED
from hapkit_studio.haptics import headless, rows
from hapkit_studio.haptics.settings import LoopSettings

MASS, STATIC, KINETIC = 0.05, 1.0, 0.5
SPRING, DRAWN, DRAWN_SECONDS = 300.0, 0.02, 6.0
# Beside a steady pull one that trembles, together below what kinetic friction holds; watched for two seconds.
PULL, TREMBLING, TREMOR = 0.3, 0.15, 20.0
HELD_SECONDS, HELD_FROM = 3.0, 1.0
# It comes to rest by sliding, or a model without rest would start in it.
SLIDES_IN = 0.02


def trembling(t: np.ndarray) -> np.ndarray:
    """Return the pull in N at the times (n,)."""
    return PULL + TREMBLING * np.sin(2.0 * math.pi * TREMOR * t)


def drift(t: np.ndarray, x: np.ndarray) -> float:
    """Return the mean drift in m/s from HELD_FROM on; inf where the motion is not finite."""
    begin = int(np.searchsorted(t, HELD_FROM - 1e-9))
    found = abs(float(x[-1] - x[begin])) / float(t[-1] - t[begin])
    return found if math.isfinite(found) else math.inf


def computed(
    model: str, dt: float, held: bool, times: int = 1
) -> tuple[plan.Work, np.ndarray, np.ndarray, np.ndarray]:
    """Return what computes a model at one step, its times, applied forces and positions, each (n,).

    held: pulled by less than friction holds, else drawn by a spring.
    """
    code, declared = MODELS[model]
    options = np.array([*(p.default for p in declared), 0.0])
    t = instants(HELD_SECONDS if held else DRAWN_SECONDS, dt)
    applied = trembling(t) if held else SPRING * DRAWN * t
    x, v = np.zeros_like(t), np.zeros_like(t)
    v[0] = SLIDES_IN if held else 0.0
    levels, memory = (MASS, 0.0 if held else SPRING, 0.0, STATIC, KINETIC), np.zeros(stick_slip.MEMORY)
    work = partial(stick_slip.run, code, times, applied, *levels, options, dt, memory, x, v)
    return work, t, applied, x


def trial_error(model: str, dt: float, held: bool) -> float:
    """Return the drift in m/s, or the share by which the period is off."""
    work, t, applied, x = computed(model, dt, held)
    work()
    if held:
        return drift(t, x)
    period = stick_slip.exact_period(MASS, SPRING, STATIC, KINETIC, DRAWN)
    return stick_slip.period_error(t, applied - SPRING * x, period)


# So soft a spring pulls with the same force wherever the handle is: it goes to 1 m for a newton.
_SOFT = 1.0
LEVELS = {"static_force": STATIC, "kinetic_force": KINETIC}


def _target(t: np.ndarray) -> np.ndarray:
    return trembling(t) / _SOFT


def prepared_handle(model: str, dt: float, times: int = 1) -> Callable[[], np.ndarray]:
    """Return what renders a handle without friction of its own, slid to rest and held by a model."""
    law = environments.named("friction")
    handle = SimulatedHapkit(coulomb_force=0.0, max_force=math.inf, initial_velocity=SLIDES_IN)
    scene = headless.Scene(law, law.values({"model": model, **LEVELS}), handle, LoopSettings(1.0 / dt))
    pull = Hand(stiffness=_SOFT, target=_target, vectorised=True)  # type: ignore[arg-type]
    return headless.prepare_run(scene, pull, times * round(HELD_SECONDS / dt) + 1).run


def handle_drift(model: str, dt: float) -> float:
    """Return the drift in m/s."""
    x = prepared_handle(model, dt)()[:, rows.TRUE_POSITION]
    return drift(dt * np.arange(x.size), x)


STEPS = (4e-3, 2e-3, 1e-3, 0.5e-3, 0.2e-3, 0.1e-3)
LABELS = {
    "coulomb": "Coulomb",
    "smoothed": "Smoothed",
    "karnopp": "Karnopp",
    "karnopp_band": "Karnopp’s band",
    "stribeck": "Stribeck",
    "projection": "Projection",
    "tether": "Tether",
    "lugre": "LuGre",
    "dahl": "Dahl",
    "hayward_armstrong": "Hayward–Armstrong",
}
VIRTUAL = plan.Default("projection")


def runs(scene: plan.Scene) -> list[plan.Run]:
    """Return every model at every step."""
    held = scene.key != "period"
    name, seconds = ("drift_m_per_s", HELD_SECONDS) if held else ("period_error", DRAWN_SECONDS)
    found = []
    for model in RENDERED if scene.key == "handle" else MODELS:
        for dt in STEPS:
            times = plan.repeats(round(seconds / dt))
            if scene.key == "handle":
                error = handle_drift(model, dt)
                prepare: plan.Prepare = partial(prepared_handle, model, dt, times)
            else:
                error = trial_error(model, dt, held)
                prepare = plan.always(computed(model, dt, held, times)[0])
            extra = ((name, error),)
            found.append(plan.Run(model, LABELS[model], dt, error, prepare, times * seconds, extra=extra))
    return found


def _scenes() -> tuple[plan.Scene, ...]:
    resting = "In two seconds less than a count of the Hapkit's sensor, 20.7 µm: it counts as rest"
    pull = ("Pull", "0.3 N ± 0.15 N at 20 Hz")
    mass = ("Mass", "0.05 kg")
    friction = ("Friction", "1 N, then 0.5 N")
    held, drift = ("Reference", "no drift"), "drift of what should hold"
    return (
        plan.Scene(
            "period", "Stick-slip of a mass", "error of the period / period", 0.02,
            f"{plan.FELT}; a period is the time of one pull",
            VIRTUAL,
            conditions=(mass, ("Spring", "300 N/m, drawn at 2 cm/s"), friction, ("Reference", "closed form")),
        ),
        plan.Scene(
            "hold", "A mass that should hold", drift, 1e-5, resting, VIRTUAL, "m/s",
            (mass, pull, friction, held),
        ),
        plan.Scene(
            "handle", "A handle that should hold", drift, 1e-5, f"{resting}; {plan.BY_HAND}",
            plan.default_of("friction", "model"), "m/s",
            (
                ("Handle", "0.044 kg, 0.5 N·s/m"), ("Sensor", "20.7 µm"), pull, friction, held,
            ),
        ),
    )  # fmt: skip


PLAN = plan.Plan(
    "friction",
    "Friction",
    tuple(plan.Method(key, LABELS[key]) for key in MODELS),
    _scenes(),
    runs,
    order=40,
)
