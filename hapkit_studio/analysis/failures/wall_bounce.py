"""One bounce off a sampled wall: by the tick, and by exact motion between events for damping in contact."""

import math

import numpy as np

from hapkit_studio import environments
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.paddle import transition
from hapkit_studio.haptics import headless, rows
from hapkit_studio.haptics.settings_writer import LoopSettings

SPEED = 0.1
WALL = 0.005
_MOST_SAMPLES = 100_000
_HALVINGS = 60


def rendered(
    mass: float, stiffness: float, rate: float, delay: float, phase: float, damping: float = 0.0
) -> np.ndarray:
    """Return the rows of a bounce by the tick; phase: where between two samples it meets the wall.

    damping is the handle's own: it acts outside the wall as well.
    """
    start = WALL - phase * SPEED / rate
    device = SimulatedHapkit(mass, damping, 0.0, 0.0, math.inf, start, SPEED)
    values = {**environments.named("wall").values(), "stiffness": stiffness, "position": WALL}
    scene = headless.Scene(environments.named("wall"), values, device, LoopSettings(rate, delay))
    contact = math.pi * math.sqrt(mass / stiffness)
    count = math.ceil((1.6 * contact + 4.0 * delay) * rate) + 20
    return headless.render(scene, None, count)[0]


def rendered_gain(
    mass: float, stiffness: float, rate: float, delay: float, phase: float, damping: float = 0.0
) -> float:
    """Return energy out over energy in: once the last force has ended, over the last sample outside."""
    out = rendered(mass, stiffness, rate, delay, phase, damping)
    touching, speed = np.flatnonzero(out[:, rows.ASKED]), out[:, rows.TRUE_VELOCITY]
    after = int(touching[-1]) + 1 + math.ceil(delay * rate - 1e-9)
    return float(speed[after] / speed[touching[0] - 1]) ** 2


def _moved(mass: float, damping: float, x: float, v: float, force: float, seconds: float):
    a, b, c, d, g0, _, g1, _ = transition(mass, damping, 0.0, seconds)
    return a * x + b * v + g0 * force, c * x + d * v + g1 * force


def _crossing(mass: float, damping: float, x: float, v: float, force: float, seconds: float) -> float:
    """Return when the depth changes its sign within ``seconds``, at whose end it has."""
    low, high = 0.0, seconds
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        place, speed = _moved(mass, damping, x, v, force, middle)
        # at the surface itself the speed says on which side it is
        before = (place > 0.0) == (x > 0.0 or (x == 0.0 and v > 0.0)) or (place == 0.0 and speed == v)
        low, high = (middle, high) if before else (low, middle)
    return high


def _piece(mass: float, damping: float, x: float, v: float, force: float, seconds: float):
    """Return depth and speed after a piece of constant force, the damper acting inside the wall alone."""
    while seconds > 0.0:
        inside = x > 0.0 or (x == 0.0 and v > 0.0)
        here = damping if inside else 0.0
        place, speed = _moved(mass, here, x, v, force, seconds)
        if (place > 0.0) == inside or place == 0.0:
            return place, speed
        when = _crossing(mass, here, x, v, force, seconds)
        _, v = _moved(mass, here, x, v, force, when)
        x, seconds = 0.0, seconds - when
    return x, v


def exact_gain(
    mass: float, damping: float, stiffness: float, rate: float, delay: float, phase: float
) -> float:
    """Return energy out over energy in of a bounce, its damper acting in contact alone.

    Exact motion under the held force, entry and exit located within a period: nothing of the tick is in it.
    """
    period = 1.0 / rate
    whole = math.floor(delay * rate + 1e-9)
    rest = max(delay - whole * period, 0.0)
    forces = [0.0] * (whole + 2)
    x, v = -phase * SPEED * period, SPEED
    for _ in range(_MOST_SAMPLES):
        forces = [-stiffness * max(x, 0.0), *forces[:-1]]
        old, new = forces[whole + 1], forces[whole]
        if x <= 0.0 and v < 0.0 and not any(forces):
            return (v / SPEED) ** 2
        x, v = _piece(mass, damping, x, v, old, rest)
        x, v = _piece(mass, damping, x, v, new, period - rest)
    return math.inf


def formula(mass: float, damping: float, stiffness: float, rate: float, delay: float) -> float:
    """Return exp(π (K (T/2 + td) − b)/(m ω)), ω = √(K/m)."""
    given = stiffness * (0.5 / rate + delay) - damping
    return math.exp(math.pi * given / math.sqrt(stiffness * mass))


def phases(count: int) -> np.ndarray:
    """Return evenly spread places (count,) of the wall between two samples."""
    return (np.arange(count) + 0.5) / count
