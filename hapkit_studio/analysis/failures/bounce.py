"""The energy of a bounce: where the formula holds, and where it leaves the exact motion.

A bounce off a sampled wall is rendered by the tick; beside it stands exact motion between events, the damping
acting in contact alone.
"""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from hapkit_studio import environments
from hapkit_studio.analysis.failures import base
from hapkit_studio.analysis.failures.in_window import thrown
from hapkit_studio.analysis.failures.spring import MASS, RATE
from hapkit_studio.analysis.failures.traces import thinned
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.paddle import transition
from hapkit_studio.formatting import with_unit
from hapkit_studio.haptics import headless, rows
from hapkit_studio.haptics.settings_writer import LoopSettings

SPEED = 0.1
WALL = 0.005
_MOST_SAMPLES = 100_000
_HALVINGS = 60


def bounce_rows(
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
    out = bounce_rows(mass, stiffness, rate, delay, phase, damping)
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
    whole_periods = math.floor(delay * rate + 1e-9)
    fraction = max(delay - whole_periods * period, 0.0)
    forces = [0.0] * (whole_periods + 2)
    x, v = -phase * SPEED * period, SPEED
    for _ in range(_MOST_SAMPLES):
        forces = [-stiffness * max(x, 0.0), *forces[:-1]]
        old, new = forces[whole_periods + 1], forces[whole_periods]
        if x <= 0.0 and v < 0.0 and not any(forces):
            return (v / SPEED) ** 2
        x, v = _piece(mass, damping, x, v, old, fraction)
        x, v = _piece(mass, damping, x, v, new, period - fraction)
    return math.inf


def gain_formula(mass: float, damping: float, stiffness: float, rate: float, delay: float) -> float:
    """Return exp(π (K (T/2 + td) − b)/(m ω)), ω = √(K/m)."""
    surplus = stiffness * (0.5 / rate + delay) - damping
    return math.exp(math.pi * surplus / math.sqrt(stiffness * mass))


def phases(count: int) -> np.ndarray:
    """Return evenly spread places (count,) of the wall between two samples."""
    return (np.arange(count) + 0.5) / count


WITHIN = 0.01
PHASES = 32
# ω T (1 + 2 td/T) up to which the formula is within 1 %.
LATENESS = 0.4
_WALL = 0.005  # m: where it stands in the window
_LATENESS = np.linspace(0.05, 0.6, 12)


def stiffness_of(lateness: float, case: base.Case) -> float:
    """Return the stiffness in N/m whose ω T (1 + 2 td/T) that is."""
    turn = lateness / (1.0 + 2.0 * case["late"])
    return case["mass"] * (turn * case["rate"]) ** 2


def limit(case: base.Case) -> float:
    """Return ω T (1 + 2 td/T) = 0.4, up to which the formula is within about 1 %."""
    return LATENESS


def damper(lateness: float, case: base.Case, balance: float) -> tuple[float, float, float]:
    """Return stiffness N/m, delay s and the damping N·s/m that is so many times K (T/2 + td)."""
    k, delay = stiffness_of(lateness, case), case["late"] / case["rate"]
    return k, delay, balance * k * (0.5 / case["rate"] + delay)


def rendered(lateness: float, case: base.Case, balance: float = 0.0) -> float:
    """Return energy out over energy in by the tick, the mean over the sampling phases."""
    k, delay, damping = damper(lateness, case, balance)
    arguments = (case["mass"], k, case["rate"], delay)
    gains = [rendered_gain(*arguments, p, damping) for p in phases(PHASES)]
    return float(np.mean(gains))


def exact(lateness: float, case: base.Case, balance: float) -> float:
    """Return the same by exact motion between events, the damper acting in contact alone."""
    k, delay, damping = damper(lateness, case, balance)
    arguments = (case["mass"], damping, k, case["rate"], delay)
    return float(np.mean([exact_gain(*arguments, p) for p in phases(PHASES)]))


def off(lateness: float, case: base.Case, gain: float, balance: float = 0.0) -> float:
    """Return by how much the formula differs from a gain, as a share of the gain."""
    k, delay, damping = damper(lateness, case, balance)
    return gain_formula(case["mass"], damping, k, case["rate"], delay) / gain - 1.0


# What is compared: its label, where the gain comes from, b as a share of K (T/2 + td), its role.
_LINES: tuple[tuple[str, Callable[[float, base.Case, float], float], float, str], ...] = (
    ("b = 0, rendered", rendered, 0.0, base.MEASURED),
    ("b in contact alone, half the balance", exact, 0.5, base.OTHER),
    ("b everywhere, half the balance", rendered, 0.5, base.OTHER),
    ("b everywhere, the balance", rendered, 1.0, base.OTHER),
)


def probe(lateness: float, case: base.Case) -> base.Evidence:
    """Throw the handle at the wall, at every sampling phase, and compare the energy with the formula."""
    k, rate, delay = stiffness_of(lateness, case), case["rate"], case["late"] / case["rate"]
    gain = rendered(lateness, case)
    error = off(lateness, case, gain)
    out = bounce_rows(case["mass"], k, rate, delay, 0.5)
    time, x = thinned(np.arange(len(out)) / rate, 1e3 * (out[:, rows.TRUE_POSITION] - WALL))
    wrong = with_unit(100.0 * error, "%", 2, sign=True)
    words = f"energy × {with_unit(gain, '', 4)} in a bounce; the formula is off by {wrong}"
    return base.Evidence(time, x, "depth in the wall", "mm", abs(error) <= WITHIN, 100.0 * error, "%", words)


def curve(case: base.Case, progress: base.Progress) -> base.Chart:
    """Return by how much the formula is off over ω T (1 + 2 td/T), without and with damping."""
    found: list[list[float]] = [[] for _ in _LINES]
    for done, lateness in enumerate(map(float, _LATENESS), 1):
        for y, (_, gain, balance, _) in zip(found, _LINES, strict=True):
            y.append(100.0 * off(lateness, case, gain(lateness, case, balance), balance))
        progress(done, len(_LATENESS))
    lines = tuple(
        base.Line(label, _LATENESS, np.array(y), role)
        for (label, _, _, role), y in zip(_LINES, found, strict=True)
    )
    marks = (base.Mark("ω T (1 + 2 td/T) = 0.4", LATENESS),)
    label = "the formula is off by, %"
    return base.Chart("ω T (1 + 2 td/T)", label, lines, marks, 100.0 * WITHIN, "1 %", log_y=True)


def live(lateness: float, case: base.Case) -> base.Live:
    """Return the wall in the window."""
    most = stiffness_of(LATENESS, case)
    values = base.within(
        "wall", {"stiffness": base.short(stiffness_of(lateness, case), most), "damping": 0.0}
    )
    loop = {"rate": case["rate"], "delay": case["late"] / case["rate"]}
    found = base.Live("wall", {**values, "position": _WALL}, loop)
    gain = with_unit(thrown(found, _WALL), "", 3)
    drag = "Drag to −30 mm, swing at the wall at 0.25 m/s and let go just before"
    advice = f"{drag}: it comes back {gain} × as fast."
    if values["stiffness"] < 0.999 * stiffness_of(lateness, case):
        advice += f" The window's wall takes no more than {with_unit(values['stiffness'], 'N/m', 4)}."
    return replace(found, advice=advice)


FAILURE = base.Failure(
    key="bounce",
    title="The energy of a bounce",
    summary="A sampled wall gives energy at every bounce; beyond a stiffness its formula is off",
    formula="E out/E in = exp(π (K (T/2 + td) − b)/(m ω)), about 1 % off at ω T (1 + 2 td/T) = 0.4",
    explanation="A wall is a spring met late and left late, by half a period and the delay, so a bounce "
    "comes back faster than it went in. The formula takes the bounce as half a swing that grows all "
    "along. For a soft wall that is within 1 %; a stiff one is met and left within a few samples, "
    "and is no half swing. A damper in contact alone changes little of that. The handle's own damper "
    "acts outside as well, for the samples before the wall is seen and after it is left, and takes "
    "more than the formula knows.",
    knob=base.Parameter(
        "lateness", "Lateness", "", 0.4, 0.01, 2.0, "How far a swing turns while late", "ω T (1 + 2 td/T)"
    ),
    limit=limit,
    probe=probe,
    curve=curve,
    options=(base.Choice("late", "Delay", ("none", "one_period"), "none"), MASS, RATE),
    live=live,
    margin=0.2,
    span=(0.2, 2.0),
    order=15,
)
