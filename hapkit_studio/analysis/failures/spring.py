"""A rendered spring with a released handle: its simulation with the loop's tick, and its exact matrix.

The handle is ideal, or it has viscous and Coulomb friction and a quantised sensor, as in the diagram of
Diolaiti et al.
"""

import cmath
import math

import numpy as np

from hapkit_studio.analysis.failures import base
from hapkit_studio.analysis.failures.base import Case, Evidence, Live
from hapkit_studio.analysis.failures.in_window import pulled
from hapkit_studio.analysis.simulated_handle import simulated_handle
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics import nominal
from hapkit_studio.dynamics.estimators import Spec
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.dynamics.paddle import transition
from hapkit_studio.haptics import rows
from hapkit_studio.parameters import Parameter

IDEAL = "; this handle has no dry friction"
MASS = Parameter(
    "mass", "Handle's mass", "kg", nominal.MASS, 0.005, 1.0, "Mass of the handle without a hand", "m"
)
VISCOUS = Parameter(
    "viscous",
    "Handle's damping",
    "N·s/m",
    nominal.VISCOUS,
    0.01,
    10.0,
    "Viscous damping of the handle without a hand",
    "b₀",
)
DAMPING = Parameter(
    "damping", "Virtual damping", "N·s/m", 0.0, 0.0, 50.0, "Damping of the rendered spring", "b"
)
RATE = Parameter(
    "rate",
    "Servo rate",
    "Hz",
    1000.0,
    100.0,
    10_000.0,
    "How many times per second the force is computed",
    "1/T",
)
DELAY = Parameter(
    "delay", "Delay", "s", 0.0, 0.0, 0.02, "Time from the measurement of the position to the force"
)
COULOMB = Parameter(
    "coulomb", "Dry friction", "N", nominal.COULOMB_FORCE, 1e-3, 2.0, "Coulomb friction of the handle", "F_c"
)
QUANTUM = Parameter(
    "quantum",
    "Sensor step",
    "m",
    nominal.QUANTUM,
    1e-6,
    1e-3,
    "Smallest distance that the sensor measures: one count",
    "Δ",
)
STIFFNESS = Parameter(
    "stiffness", "Stiffness", "N/m", 900.0, 1.0, 200_000.0, "Stiffness of the rendered spring", "k"
)
HANDLE = MASS, VISCOUS, RATE, DELAY

START = 1e-3
# m: range of the handle; a motion that leaves it has diverged
REACH = 0.05
SECONDS = 12.0
TURNS = 80.0


def setting(case: Case, estimator: Spec = "difference") -> LoopSettings:
    """Return loop settings with an ideal device, for a case with mass, viscous, rate and optionally delay."""
    delay = case.get("delay", 0.0)
    return LoopSettings(
        case["rate"], delay, estimator, mass=case["mass"], viscous=case["viscous"], coulomb=0.0, quantum=0.0
    )


def released(where: LoopSettings, damping: float, stiffness: float) -> np.ndarray:
    """Return the rows of a rendered spring after the handle's release at START, until the motion diverges."""
    seconds = max(SECONDS, TURNS * math.sqrt(where.mass / stiffness))
    given = {"stiffness": stiffness, "damping": damping, "center": 0.0}
    handle = simulated_handle(where, real=False, position=START)
    out = base.render("spring", given, handle, where, round(seconds * where.rate))
    return out[: base.before_lost(out[:, rows.TRUE_POSITION], REACH)]


def rate_of(where: LoopSettings, stiffness: float, out: np.ndarray) -> float:
    """Return the growth rate in 1/s of a recorded motion, from the amplitude of speed and acceleration."""
    speed = out[:, rows.TRUE_VELOCITY]
    slowest = math.sqrt(stiffness / where.mass)
    return base.growth(np.hypot(np.diff(speed) * where.rate, slowest * speed[1:]), where.period)


def evidence(where: LoopSettings, damping: float, stiffness: float) -> Evidence:
    """Return the motion after a release 1 mm from the centre, and whether the motion decays or grows."""
    out = released(where, damping, stiffness)
    rate = rate_of(where, stiffness, out)
    place = 1e3 * out[:, rows.TRUE_POSITION]
    return base.growth_evidence(place, where.period, rate, more=IDEAL)


def loop_of(case: Case, estimator: Spec = "difference") -> dict[str, object]:
    """Return the loop of a case as settings for the window."""
    return {"rate": base.live_rate(case["rate"]), "delay": case.get("delay", 0.0), "estimator": estimator}


def live(value: float, bound: float, knob: Parameter, given: Case, loop: dict[str, object]) -> Live:
    """Return the live settings of the spring, with its knob (stiffness or damping) at a value."""

    def make(value: float) -> Live:
        values = {"damping": 0.0, "center": 0.0, **given, knob.key: base.short(value, bound)}
        return Live("spring", base.within("spring", values), loop)

    return pulled(make, value, bound, knob.key, knob.unit)


def step_matrix(
    mass: float, viscous: float, stiffness: float, damping: float, period: float, delay: float
) -> np.ndarray:
    """Return the matrix of the closed loop over one period; the state is x, v, the last x, and past commands.

    The law is a spring with backward-difference damping. The force of a sample begins to act ``delay`` s
    later and is then constant for a period. The map is derived from the equations of motion, independently of
    the tick.
    """
    whole_periods = math.floor(delay / period + 1e-9)
    fraction = max(delay - whole_periods * period, 0.0)
    first, second = _map(mass, viscous, fraction), _map(mass, viscous, period - fraction)
    size = whole_periods + 4
    out = np.zeros((size, size))
    law_row = np.zeros(size)
    law_row[0], law_row[2] = -stiffness - damping / period, damping / period
    commands = [law_row, *np.eye(size)[3:]]
    out[:2, :2] = second[:, :2] @ first[:, :2]
    out[:2] += np.outer(second[:, 2], commands[whole_periods])
    out[:2] += np.outer(second[:, :2] @ first[:, 2], commands[whole_periods + 1])
    out[2, 0] = 1.0
    for index in range(whole_periods + 1):
        out[3 + index] = commands[index]
    return out


def _map(mass: float, viscous: float, seconds: float) -> np.ndarray:
    """Return the handle's map (2, 3) from position, velocity and force to position and velocity."""
    a, b, c, d, g0, _, g1, _ = transition(mass, viscous, 0.0, seconds)
    return np.array([[a, b, g0], [c, d, g1]])


def largest_root(matrix: np.ndarray, seconds: float) -> complex:
    """Return the eigenvalue σ + jω in 1/s with the largest growth; ``matrix`` is a map over ``seconds`` s."""
    roots = np.linalg.eigvals(matrix)
    root = complex(roots[np.abs(roots).argmax()])
    return complex(math.log(abs(root)), abs(cmath.phase(root))) / seconds


def exact(case: Case, stiffness: float) -> complex:
    """Return σ + jω in 1/s of the loop's dominant root; damping and delay default to 0."""
    period = 1.0 / case["rate"]
    extra = case.get("damping", 0.0), period, case.get("delay", 0.0)
    return largest_root(step_matrix(case["mass"], case["viscous"], stiffness, *extra), period)


RESTS, CYCLES, GROWS = "rests", "cycles", "grows"
FRICTION_SECONDS = 6.0
# a motion whose amplitude exceeds this multiple of its start has diverged
LOST = 20.0


def released_with_friction(
    mass: float,
    viscous: float,
    coulomb: float,
    quantum: float,
    rate: float,
    stiffness: float,
    start: float,
    seconds: float = FRICTION_SECONDS,
    delay: float = 0.0,
) -> np.ndarray:
    """Return the position (n,) in m of a handle released ``start`` m from the edge of a sensor count.

    The spring's centre lies half a count beyond the edge, so on both sides of the edge the force is that of
    half a count. The motion ends when it diverges.
    """
    edge = quantum
    device = SimulatedHapkit(mass, viscous, coulomb, quantum, math.inf, edge + start)
    given = {"stiffness": stiffness, "damping": 0.0, "center": 0.5 * quantum}
    out = base.render("spring", given, device, LoopSettings(rate, delay), round(seconds * rate))
    x = out[:, rows.TRUE_POSITION] - edge
    return x[: base.before_lost(x, LOST * abs(start))]


def judged(x: np.ndarray, start: float, rate: float, seconds: float = FRICTION_SECONDS) -> tuple[str, float]:
    """Return the outcome of a motion (n,), and the peak-to-peak value in m of its last half second."""
    complete = len(x) == round(seconds * rate)
    last = float(np.ptp(x[-round(0.5 * rate) :])) if len(x) else math.inf
    # at the end the motion still exceeds its initial value, so it grows
    if not complete or np.abs(x[-round(0.5 * rate) :]).max() > abs(start):
        return GROWS, last
    return (RESTS if last == 0.0 else CYCLES), last
