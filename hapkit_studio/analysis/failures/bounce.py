"""Energy gained in a bounce off a sampled wall, and the range in which the formula is accurate."""

import math
from dataclasses import replace

import numpy as np

from hapkit_studio.analysis.failures import base
from hapkit_studio.analysis.failures.in_window import thrown
from hapkit_studio.analysis.failures.spring import MASS, RATE
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.formatting import with_unit
from hapkit_studio.haptics import rows

SPEED = 0.1
WALL = 0.005  # m: position of the wall, in the trial and in the window
WITHIN = 0.01
PHASES = (np.arange(32) + 0.5) / 32
# lateness ω T (1 + 2 td/T) up to which the formula is within 1 %
LATENESS = 0.4


def stiffness_of(lateness: float, case: base.Case) -> float:
    """Return the stiffness in N/m for a lateness ω T (1 + 2 td/T)."""
    turn = lateness / (1.0 + 2.0 * case["late"])
    return case["mass"] * (turn * case["rate"]) ** 2


def balance_of(lateness: float, case: base.Case) -> float:
    """Return k (T/2 + td) in N·s/m: the damping that absorbs the energy gained by lateness."""
    return stiffness_of(lateness, case) * (0.5 + case["late"]) / case["rate"]


def bounce_rows(lateness: float, case: base.Case, phase: float, damping: float = 0.0) -> np.ndarray:
    """Return the rows of a bounce; ``phase`` is the fraction of a period between a sample and the contact.

    ``damping`` is the handle's damping, which also acts outside the wall.
    """
    mass, stiffness, rate = case["mass"], stiffness_of(lateness, case), case["rate"]
    device = SimulatedHapkit(mass, damping, 0.0, 0.0, math.inf, WALL - phase * SPEED / rate, SPEED)
    loop = LoopSettings(rate, case["late"] / rate)
    count = math.ceil(1.6 * math.pi * math.sqrt(mass / stiffness) * rate + 4.0 * case["late"]) + 20
    return base.render("wall", {"stiffness": stiffness, "position": WALL}, device, loop, count)


def rendered(lateness: float, case: base.Case, balance: float = 0.0) -> float:
    """Return the simulated ratio of energy out to energy in, averaged over the sampling phases.

    The handle's damping is ``balance`` times k (T/2 + td). The energy out is that of the first sample at
    which the handle has left the wall and the last force has ended.
    """
    damping, gains = balance * balance_of(lateness, case), []
    for phase in PHASES:
        out = bounce_rows(lateness, case, phase, damping)
        touching, speed = np.flatnonzero(out[:, rows.FORCE]), out[:, rows.TRUE_VELOCITY]
        after = int(touching[-1]) + 1 + math.ceil(case["late"] - 1e-9)
        gains.append(float(speed[after] / speed[touching[0] - 1]) ** 2)
    return float(np.mean(gains))


def off(lateness: float, case: base.Case, gain: float, balance: float = 0.0) -> float:
    """Return the relative error of the formula exp(π (k (T/2 + td) − b₀)/(m ω)) against a simulated gain."""
    surplus = (1.0 - balance) * balance_of(lateness, case)
    momentum = math.sqrt(stiffness_of(lateness, case) * case["mass"])
    return math.exp(math.pi * surplus / momentum) / gain - 1.0


def probe(lateness: float, case: base.Case) -> base.Evidence:
    """Throw the handle at the wall at every sampling phase; compare the energy with the formula."""
    gain = rendered(lateness, case)
    error = off(lateness, case, gain)
    wrong = with_unit(100.0 * error, "%", 2, sign=True)
    text = f"a bounce multiplies the energy by {with_unit(gain, '', 4)}; the formula is wrong by {wrong}"
    x, holds = 1e3 * (bounce_rows(lateness, case, 0.5)[:, rows.TRUE_POSITION] - WALL), abs(error) <= WITHIN
    return base.Evidence(x, 1.0 / case["rate"], "depth in the wall", "mm", holds, 100.0 * error, "%", text)


def error(balance: float, label: str) -> base.Curve:
    """Return the curve of the formula's error in %, for b₀ as a fraction ``balance`` of k (T/2 + td)."""

    def of(lateness: float, case: base.Case) -> float:
        return 100.0 * off(lateness, case, rendered(lateness, case, balance), balance)

    return base.Curve(label, of, base.OTHER)


def live(lateness: float, case: base.Case) -> base.Live:
    """Return the live settings of the wall."""
    stiffness = stiffness_of(lateness, case)
    given = {"stiffness": base.short(stiffness, stiffness_of(LATENESS, case)), "damping": 0.0}
    values = {**base.within("wall", given), "position": WALL}
    found = base.Live("wall", values, {"rate": case["rate"], "delay": case["late"] / case["rate"]})
    drag = "Drag to −30 mm, move towards the wall at 0.25 m/s and let go just before it."
    advice = f"{drag} The handle comes back {with_unit(thrown(found, WALL), '', 3)} × as fast as it came."
    if values["stiffness"] < 0.999 * stiffness:
        advice += f" The slider in the window ends at {with_unit(values['stiffness'], 'N/m', 4)}."
    return replace(found, advice=advice)


FAILURE = base.Failure(
    key="bounce",
    title="The energy of a bounce",
    summary="A wall adds energy in every bounce; for a stiff wall the formula of this energy is inaccurate",
    formula="E out/E in = exp(π (k (T/2 + td) − b₀)/(m ω)), with energy E, stiffness k, period T, "
    "delay td, damping b₀, mass m and frequency ω. This formula has an error of about 1 % if "
    "ω T (1 + 2 td/T) = 0.4",
    explanation="A sampled wall is a spring that acts too late, by half a period plus the delay, both when "
    "the handle hits it and when the handle leaves it. So the handle bounces back faster than it came. The "
    "formula treats a bounce as half an oscillation that grows all the time. For a soft wall this is "
    "accurate to 1 %. The handle hits and leaves a stiff wall within a few samples, which is not half an "
    "oscillation. The handle's own damping also acts outside the wall, in the samples before the wall is "
    "detected and after the handle has left it. So damping removes more energy than the formula accounts "
    "for.",
    knob=base.Parameter(
        "lateness",
        "Lateness",
        "",
        0.4,
        0.01,
        2.0,
        "Phase in radians by which the oscillation advances during the delay of the force",
        "ω T (1 + 2 td/T)",
    ),
    limit=lambda case: LATENESS,
    probe=probe,
    plot=base.Plot(
        "ω T (1 + 2 td/T)",
        lambda case: np.linspace(0.05, 0.6, 12),
        (
            base.Curve("simulation without damping"),
            error(0.5, "damping takes half of the added energy"),
            error(1.0, "damping takes all of the added energy"),
        ),
        "limit 0.4",
        level=100.0 * WITHIN,
        level_label="1 %",
        log_y=True,
        y_label="error of the formula, %",
    ),
    options=(base.Choice("late", "Delay", ("none", "one_period"), "none"), MASS, RATE),
    live=live,
    margin=0.2,
    span=(0.2, 2.0),
    order=15,
)
