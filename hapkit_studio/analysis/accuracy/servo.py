"""Servo rate: how stiff a wall may be and how true it is, over what the ticks of a second cost.

The wall is the stiffest that students choose on a Hapkit, 800 N/m. It must be stable, the handle released.
Tapped by a hand, the handle's path into it is compared with that into a wall without samples, event-located.
"""

from collections.abc import Callable
from functools import cache, partial

import numpy as np

from hapkit_studio import environments
from hapkit_studio.analysis.accuracy.plan import FELT, Default, Method, Plan, Run, Scene, repeats
from hapkit_studio.analysis.stability.limits import stiffness_limit
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.hand import SCRIPTS
from hapkit_studio.dynamics.integrators import INTEGRATORS, Body, drive
from hapkit_studio.dynamics.moving_mass import FAR
from hapkit_studio.haptics import headless, rows
from hapkit_studio.haptics.settings import RATE, LoopSettings

RATES = (250.0, 500.0, 1000.0, 2000.0, 4000.0, 8000.0, 10_000.0)
STIFFNESS = 800.0
TAP_SECONDS = 0.8
# At once, and a millisecond later, as over a USB port.
DELAYS = {"prompt": 0.0, "late": 1e-3}
LABELS = {"prompt": "Answer at once", "late": "1 ms later"}
# Samples of the continuous wall; every rate's samples are among them.
FINE_RATE = 40_000.0


def device() -> SimulatedHapkit:
    """Return the paddle with an ideal sensor, so that the rate alone is judged."""
    return SimulatedHapkit(quantum=0.0)


def wall_limit(rate: float, delay: float) -> float:
    """Return the largest stable stiffness in N/m of the wall, released."""
    return stiffness_limit(device().mass, device().viscous, rate=rate, delay=delay)


@cache
def continuous() -> np.ndarray:
    """Return the handle's path (n,) in m at FINE_RATE while the hand taps a wall without samples.

    Mass, damper, hand and wall in pieces, each exact; the hand's pull is that of the middle of a step.
    """
    hand, paddle = SCRIPTS["tap"], device()
    place = environments.named("wall").values()["position"]
    h = 1.0 / FINE_RATE
    targets = hand.target(np.arange(round(TAP_SECONDS * FINE_RATE) + 2) * h)  # type: ignore[arg-type]
    middle, rate = 0.5 * (targets[1:] + targets[:-1]), np.diff(targets) / h  # type: ignore[index]
    pull = hand.stiffness * middle + hand.damping * rate
    friction = paddle.coulomb_force
    body = Body(
        paddle.mass + hand.mass, paddle.viscous + hand.damping, hand.stiffness,
        reach=place, wall=STIFFNESS, static=friction, kinetic=friction,
    )  # fmt: skip
    x, v = np.zeros_like(pull), np.zeros_like(pull)
    exact = float(INTEGRATORS.index("exact"))
    drive(exact, 1, h, body.numbers(), pull, np.full_like(pull, -FAR), x, v)
    return x


def _stage(rate: float, delay: float, times: int) -> Callable[[], np.ndarray]:
    law = environments.named("wall")
    loop = LoopSettings(rate, delay)
    scene = headless.Scene(law, law.values({"stiffness": STIFFNESS}), device(), loop)
    return headless.prepare_run(scene, SCRIPTS["tap"], round(times * TAP_SECONDS * rate)).run


def contact_error(rate: float, delay: float) -> float:
    """Return the largest distance from the handle's true path, over the deepest penetration."""
    place = environments.named("wall").values()["position"]
    true = continuous()
    rendered = _stage(rate, delay, 1)()[:, rows.TRUE_POSITION]
    at = np.arange(rendered.size) * round(FINE_RATE / rate)
    return float(np.abs(rendered - true[at]).max() / (true.max() - place))


def runs(scene: Scene) -> list[Run]:
    """Return every rate, answered at once and late."""
    found = []
    for method, delay in DELAYS.items():
        for rate in RATES:
            times, limit = repeats(round(TAP_SECONDS * rate)), wall_limit(rate, delay)
            error = STIFFNESS / limit if scene.key == "stiffness" else contact_error(rate, delay)
            prepare = partial(_stage, rate, delay, times)
            extra = (("rate_Hz", rate), ("stable_stiffness", limit))
            seconds = times * TAP_SECONDS
            found.append(Run(method, LABELS[method], 1.0 / rate, error, prepare, seconds, extra=extra))
    return found


def _scenes() -> tuple[Scene, Scene]:
    paddle, hand, default = device(), SCRIPTS["tap"], Default("prompt", 1.0 / RATE.default)
    wall = ("Wall", f"{STIFFNESS:,g} N/m")
    handle = ("Handle", f"{paddle.mass:g} kg, {paddle.viscous:g} N·s/m")
    held = ("Hand", f"taps, {hand.mass:g} kg, {hand.damping:g} N·s/m, {hand.stiffness:,g} N/m")
    return (
        Scene(
            "stiffness", "The stiffest wall", f"{STIFFNESS:,g} N/m as a share of the stable stiffness", 1.0,
            "The stiffest wall that students choose must be stable with the handle released", default,
            conditions=(wall, handle, ("Hand", "released"), ("Reference", "exact limit")), step_s=None,
            goal="stable",
        ),
        Scene(
            "contact", "A tap on a wall", "largest error / deepest penetration", 0.02,
            f"{FELT}; the force is in proportion to the depth",
            default, conditions=(wall, handle, held, ("Reference", "no samples, event-located")), step_s=None,
        ),
    )  # fmt: skip


PLAN = Plan(
    "servo",
    "Servo rate",
    tuple(Method(key, label) for key, label in LABELS.items()),
    _scenes(),
    runs,
    order=30,
)
