"""The energy of a bounce: where the formula holds, and where it leaves the exact motion."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from hapkit_studio.analysis.failures import base, wall_bounce
from hapkit_studio.analysis.failures.in_window import thrown
from hapkit_studio.analysis.failures.loop import MASS, RATE
from hapkit_studio.analysis.failures.numbers import signed, text, thinned
from hapkit_studio.haptics import rows

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
    given = (case["mass"], k, case["rate"], delay)
    gains = [wall_bounce.rendered_gain(*given, p, damping) for p in wall_bounce.phases(PHASES)]
    return float(np.mean(gains))


def exact(lateness: float, case: base.Case, balance: float) -> float:
    """Return the same by exact motion between events, the damper acting in contact alone."""
    k, delay, damping = damper(lateness, case, balance)
    given = (case["mass"], damping, k, case["rate"], delay)
    return float(np.mean([wall_bounce.exact_gain(*given, p) for p in wall_bounce.phases(PHASES)]))


def off(lateness: float, case: base.Case, gain: float, balance: float = 0.0) -> float:
    """Return by how much the formula differs from a gain, as a share of the gain."""
    k, delay, damping = damper(lateness, case, balance)
    return wall_bounce.formula(case["mass"], damping, k, case["rate"], delay) / gain - 1.0


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
    out = wall_bounce.rendered(case["mass"], k, rate, delay, 0.5)
    time, x = thinned(np.arange(len(out)) / rate, 1e3 * (out[:, rows.TRUE_POSITION] - wall_bounce.WALL))
    words = f"energy × {text(gain, '', 4)} in a bounce; the formula is off by {signed(100.0 * error, '%', 2)}"
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
    gain = text(thrown(found, _WALL), "", 3)
    drag = "Drag to −30 mm, swing at the wall at 0.25 m/s and let go just before"
    advice = f"{drag}: it comes back {gain} × as fast."
    if values["stiffness"] < 0.999 * stiffness_of(lateness, case):
        advice += f" The window's wall takes no more than {text(values['stiffness'], 'N/m', 4)}."
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
