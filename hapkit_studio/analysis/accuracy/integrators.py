"""Integrators: how far each is from the true motion of an object, at every step from 0.125 to 4 ms.

The objects are those of the environments with their defaults, so the answer is theirs; stick-slip is the
light slider whose period the literature's formula gives.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from hapkit_studio import environments
from hapkit_studio.analysis.accuracy.plan import (
    BY_HAND,
    FELT,
    Method,
    Plan,
    Point,
    Run,
    Scene,
    Trace,
    always,
    default_of,
    repeats,
)
from hapkit_studio.dynamics.integrators import INTEGRATORS, Body, drive, glide, instants
from hapkit_studio.dynamics.moving_mass import FAR
from hapkit_studio.dynamics.stick_slip import exact_period, period_error
from hapkit_studio.environments.puck import REACH
from hapkit_studio.environments.pushed import LABELS

Function = Callable[[np.ndarray], np.ndarray]
Judge = Callable[[np.ndarray, np.ndarray], float]

DEFLECTION = 0.010
# A hand that stirs the object: 5 mm to both sides of 10 mm, twice a second, never off it.
HANDLE, STIRRED, STIRRING = 0.010, 0.005, 2.0
SHOVED, PUCK_FROM = 0.5, 0.010
DRAWN = 0.02


@dataclass(frozen=True)
class Motion:
    """An object that starts at (x, v), its true path over equally spaced times; force in N, handle in m.

    Its error is the largest distance from that path, over scale in m, unless judge takes times and positions
    (n,) and returns another; scale is nan then. Unless given there is no force, and no handle.
    """

    body: Body
    x: float
    v: float
    seconds: float
    true: Function
    scale: float = math.nan
    judge: Judge | None = None
    force: Function = np.zeros_like
    touch: Function = lambda t: np.full_like(t, -FAR)

    def computed(self, method: int, h: float, times: int = 1) -> tuple[Callable[[], None], np.ndarray]:
        """Return what computes the motion by steps of h s, and the positions (n,) that it fills."""
        t = instants(self.seconds, h)
        x, v = np.full_like(t, self.x), np.full_like(t, self.v)
        given = self.body.numbers(), self.force(t), self.touch(t)
        return (lambda: drive(float(method), times, h, *given, x, v)), x

    def error(self, method: int, h: float) -> float:
        """Return the error of a method at steps of h s, inf where it left all numbers."""
        found = self.trace(method, h)
        with np.errstate(all="ignore"):
            if self.judge:
                error = self.judge(found.t, found.x)
            else:
                error = float(np.abs(found.x - found.true).max()) / self.scale
        return error if math.isfinite(error) else math.inf

    def trace(self, method: int, h: float) -> Trace:
        """Return the motion by a method at steps of h s beside the true one."""
        work, x = self.computed(method, h)
        work()
        t = instants(self.seconds, h)
        return Trace(t, x, self.true(t), self.scale)


def decay(mass: float, damping: float, stiffness: float, x: float, v: float = 0.0) -> Function:
    """Return the underdamped motion of a mass let go at x m with v m/s."""
    rate = damping / (2.0 * mass)
    omega = math.sqrt(stiffness / mass - rate * rate)
    return lambda t: np.exp(-rate * t) * (x * np.cos(omega * t) + (v + rate * x) / omega * np.sin(omega * t))


def bounced(mass: float, wall: float) -> Function:
    """Return the puck's path: straight on, half a turn of a sine in a wall, straight back, and so on."""
    omega = math.sqrt(wall / mass)
    inside, across = math.pi / omega, 2.0 * REACH / SHOVED

    def position(t: np.ndarray) -> np.ndarray:
        since = t - (REACH - PUCK_FROM) / SHOVED
        bounces = np.floor(since / (inside + across))
        s = since - bounces * (inside + across)
        deep = SHOVED / omega * np.sin(omega * np.minimum(s, inside))
        x = np.where(s < inside, REACH + deep, REACH - SHOVED * (s - inside))
        return np.where(since < 0.0, PUCK_FROM + SHOVED * t, x * np.where(bounces % 2.0 == 0.0, 1.0, -1.0))

    return position


def oscillating(mass: float, damping: float, stiffness: float) -> Motion:
    """Return a mass on a spring and damper, let go 10 mm from its rest, for a second."""
    true = decay(mass, damping, stiffness, DEFLECTION)
    return Motion(Body(mass, damping, stiffness), DEFLECTION, 0.0, 1.0, true, DEFLECTION)


def swinging(damped: bool) -> Motion:
    """Return the environment's object, with its damper or without."""
    values = environments.named("mass_spring_damper").values()
    return oscillating(values["mass"], values["damping"] if damped else 0.0, values["stiffness"])


def driven() -> Motion:
    """Return the environment's object with a handle on it that stirs it; the law knows it at samples only.

    The true path is that under the same held handle, which the object never leaves.
    """
    values = environments.named("mass_spring_damper").values()
    m, b, k, contact = (values[key] for key in ("mass", "damping", "stiffness", "contact_stiffness"))
    start = contact * HANDLE / (k + contact)

    def touch(t: np.ndarray) -> np.ndarray:
        return HANDLE + STIRRED * np.sin(2.0 * math.pi * STIRRING * t)

    def true(t: np.ndarray) -> np.ndarray:
        x, v = np.full_like(t, start), np.zeros_like(t)
        glide(t[1] - t[0], m, b, k + contact, contact * touch(t), x, v)
        return x

    scale = float(np.abs(true(instants(1.0, 1e-4)) - start).max())
    return Motion(Body(m, b, k, contact), start, 0.0, 1.0, true, scale, touch=touch)


def contact() -> Motion:
    """Return the environment's puck, shoved to and fro between its walls."""
    values = environments.named("puck").values()
    body = Body(values["mass"], reach=REACH, wall=values["wall_stiffness"])
    return Motion(body, PUCK_FROM, SHOVED, 2.0, bounced(body.mass, body.wall), 2.0 * REACH)


def stick_slip() -> Motion:
    """Return a slider drawn over a rubbing ground by a spring, its end at 2 cm/s."""
    body = Body(0.05, stiffness=300.0, static=1.0, kinetic=0.5)
    true = exact_period(body.mass, body.stiffness, body.static, body.kinetic, DRAWN)

    def judge(t: np.ndarray, x: np.ndarray) -> float:
        return period_error(t, body.stiffness * (DRAWN * t - x), true)

    def path(t: np.ndarray) -> np.ndarray:
        exact, fine = INTEGRATORS.index("exact"), STEPS[-1] / _FINER
        work, x = motion.computed(exact, fine)
        work()
        return x[:: round((t[1] - t[0]) / fine)]

    motion = Motion(body, 0.0, 0.0, 3.0, path, judge=judge, force=lambda t: body.stiffness * DRAWN * t)
    return motion


# No closed form gives the path of stick-slip: the exact method does, with steps so much shorter.
_FINER = 4
STEPS = (4e-3, 2e-3, 1e-3, 0.5e-3, 0.25e-3, 0.125e-3)
THIRD = f"{FELT}; an object's force is in proportion to its motion"
MOTIONS: dict[str, Callable[[], Motion]] = {
    "free": partial(swinging, False),
    "damped": partial(swinging, True),
    "driven": driven,
    "contact": contact,
    "stick_slip": stick_slip,
}


def _of_deflection(key: str, title: str, error: str, *conditions: tuple[str, str]) -> Scene:
    return Scene(
        key, title, error, 0.02, THIRD, default_of("mass_spring_damper", "integrator"), conditions=conditions
    )


def _scenes() -> tuple[Scene, ...]:
    values = environments.named("mass_spring_damper").values()
    puck = environments.named("puck").values()
    mass = ("Mass", f"{values['mass']:g} kg")
    spring = ("Stiffness", f"{values['stiffness']:,g} N/m")
    damper = ("Damping", f"{values['damping']:g} N·s/m")
    start = ("Start", "10 mm, at rest")
    closed = ("Exact", "its map computed once"), ("Reference", "closed form, 1 s")
    first = "largest error / first deflection"
    return (
        _of_deflection("free", "Free mass on a spring", first, mass, spring, start, *closed),
        _of_deflection("damped", "Damped mass on a spring", first, mass, spring, damper, start, *closed),
        _of_deflection(
            "driven", "Mass driven by the hand", "largest error / largest deflection",
            mass, spring, damper, ("Contact", f"{values['contact_stiffness']:,g} N/m"),
            ("Handle", "±5 mm at 2 Hz, held between samples"), ("Reference", "exact, the handle held, 1 s"),
        ),
        Scene(
            "contact", "Puck between two walls", "largest error / distance between the walls", 0.02,
            f"{THIRD}; {BY_HAND}",
            default_of("puck", "integrator"),
            conditions=(
                ("Mass", f"{puck['mass']:g} kg"), ("Walls", f"{puck['wall_stiffness']:,g} N/m, 70 mm apart"),
                ("Start", f"{SHOVED:g} m/s"), ("Reference", "closed form, 2 s"),
            ),
        ),
        Scene(
            "stick_slip", "Stick-slip", "error of the period / period", 0.02,
            f"{FELT}; a period is the time of one pull; {BY_HAND}",
            default_of("puck", "integrator"),
            conditions=(
                ("Mass", "0.05 kg"), ("Spring", "300 N/m, drawn at 2 cm/s"), ("Friction", "1 N, then 0.5 N"),
                ("Reference", "closed form, 3 s"),
            ),
        ),
    )  # fmt: skip


def runs(scene: Scene) -> list[Run]:
    """Return every integrator at every step."""
    motion = MOTIONS[scene.key]()
    found = []
    for number, (key, label) in enumerate(zip(INTEGRATORS, LABELS, strict=True)):
        for h in STEPS:
            times = repeats(instants(motion.seconds, h).size)
            work, _ = motion.computed(number, h, times)
            error = motion.error(number, h)
            found.append(Run(key, label, h, error, always(work), times * motion.seconds))
    return found


def trace(point: Point) -> Trace:
    """Return a point's motion beside the true one."""
    return MOTIONS[point.scene]().trace(INTEGRATORS.index(point.method), point.step_s)


PLAN = Plan(
    "integrators",
    "Integrators",
    tuple(Method(key, label) for key, label in zip(INTEGRATORS, LABELS, strict=True)),
    _scenes(),
    runs,
    order=10,
    trace=trace,
)
