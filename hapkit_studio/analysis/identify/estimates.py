"""What identification answers: numbers with intervals, and when a piece does not tell them."""

import math
from dataclasses import dataclass, field

import numpy as np

from hapkit_studio.analysis.identify.regression import Fit
from hapkit_studio.analysis.identify.windows import Windows


@dataclass(frozen=True)
class Term:
    """One thing that can be identified: fine is an interval so narrow that a hand feels no difference."""

    key: str
    label: str
    unit: str
    fine: float
    advice: str


_FARTHER = "Move farther: the piece keeps within {travel}."
_FASTER = "{} faster: the piece holds no speed above {{speed}}."
_BOTH_WAYS = "Move both ways, at more than one speed."
TERMS = {
    term.key: term
    for term in (
        Term("stiffness", "Stiffness", "N/m", 10.0, _FARTHER),
        Term("damping", "Damping", "N·s/m", 0.25, _FASTER.format("Move")),
        Term("damping_in", "Damping, going in", "N·s/m", 0.25, _FASTER.format("Go in")),
        Term("damping_out", "Damping, going out", "N·s/m", 0.25, _FASTER.format("Come out")),
        Term("friction", "Friction", "N", 0.05, _BOTH_WAYS),
        Term("centre", "Centre", "m", 0.5e-3, _FARTHER),
        Term("mass", "Mass", "kg", 5e-3, "Shake faster: the piece holds no acceleration above {jolt}."),
        Term("viscous", "Viscous friction", "N·s/m", 0.1, _FASTER.format("Move")),
        Term("coulomb", "Coulomb friction", "N", 0.03, _BOTH_WAYS),
    )
}


@dataclass(frozen=True)
class Estimate:
    """A number with the half width of its 95 % interval, in SI units.

    asked is what had been set, expected what the loop must make of that (hold, delay, estimator); told says
    whether the piece tells it at all, advice what to do where not.
    """

    key: str
    value: float
    half: float
    asked: float | None = None
    expected: float | None = None
    told: bool = True
    advice: str = ""

    @property
    def term(self) -> Term:
        """Return the words and the unit."""
        return TERMS[self.key]

    @property
    def low(self) -> float:
        """Return the lower end of the interval."""
        return self.value - self.half

    @property
    def high(self) -> float:
        """Return the upper end of the interval."""
        return self.value + self.half

    def holds(self, value: float) -> bool:
        """Return whether a value lies in the interval."""
        return self.low <= value <= self.high


@dataclass(frozen=True)
class Points:
    """The windows that were used: time s, columns (m, p) named, force in N, and the fit to them.

    The force is the sum of columns times coefficients; the last column is 1. middle is the position in m that
    the column of positions counts from.
    """

    time: np.ndarray
    names: tuple[str, ...]
    columns: np.ndarray
    force: np.ndarray
    fit: Fit
    middle: float = 0.0

    def share(self, name: str) -> tuple[np.ndarray, np.ndarray]:
        """Return what a term acts on (k,) and the force in N (k,) that is left without the other terms.

        Positions are the sensor's own, and the constant force stays with them.
        """
        at = self.names.index(name)
        own = self.columns[:, at]
        there = own != 0.0
        moved, offset = self._constant(name)
        return own[there] + moved, own[there] * self.fit.beta[at] + offset + self.fit.residual[there]

    def line(self, name: str, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the term's force in N at values (k,) of what it acts on, and its band's half width (k,)."""
        moved, offset = self._constant(name)
        place, own = self.names.index(name), at - moved
        gradient = np.zeros((len(at), len(self.names)))
        gradient[:, place] = own
        gradient[:, -1] = 1.0 if name == "stiffness" else 0.0
        return own * self.fit.beta[place] + offset, self.fit.half_of(gradient)

    def _constant(self, name: str) -> tuple[float, float]:
        return (self.middle, float(self.fit.beta[-1])) if name == "stiffness" else (0.0, 0.0)


@dataclass(frozen=True)
class Part:
    """One question's answer: key "rendered" or "handle"; estimates may be empty, then advice says why.

    explained is the share of the force's variance that the terms make; turning the motion's RMS speed over
    its RMS distance from its mean, in rad/s; seconds the length of what was used; left_out counts samples by
    the reason, damped those in which the passivity controller damped.
    """

    key: str
    estimates: tuple[Estimate, ...] = ()
    advice: str = ""
    explained: float = float("nan")
    turning: float = 0.0
    seconds: float = 0.0
    released: bool = False
    points: Points | None = field(default=None, repr=False)
    left_out: dict[str, int] = field(default_factory=dict)
    damped: int = 0

    def __getitem__(self, key: str) -> Estimate:
        """Return an estimate by its key; raise KeyError."""
        return {e.key: e for e in self.estimates}[key]


# Sums over samples stand for integrals only so well: no interval is finer than that share of what is felt.
_FINEST = 1e-3


@dataclass(frozen=True)
class Sizes:
    """How far, how fast and how hard a piece moves: m peak to peak, m/s, m/s^2, turning rad/s, mean m."""

    travel: float
    speed: float
    jolt: float
    turning: float
    middle: float = 0.0


def sizes(position: np.ndarray, windows: Windows, kept: np.ndarray) -> Sizes:
    """Return the sizes of a position (n,) in the windows kept; zeros where there is none."""
    if not kept.any():
        return Sizes(0.0, 0.0, 0.0, 0.0)
    x, v, a = (windows.derivative(position, order)[kept] for order in range(3))
    spread = float(np.std(x))
    turning = float(np.sqrt(np.mean(v**2))) / spread if spread > 0.0 else 0.0
    return Sizes(float(np.ptp(x)), float(np.abs(v).max()), float(np.abs(a).max()), turning, float(x.mean()))


def estimate(
    name: str,
    value: float,
    half: float,
    moved: Sizes,
    asked: float | None = None,
    expected: float | None = None,
) -> Estimate:
    """Return the estimate; an interval wider than its value and than what is felt tells nothing."""
    term, value = TERMS[name], float(value)
    half = max(float(half), _FINEST * term.fine)
    # a mass is above zero, no friction pushes
    possible = {"mass": value > half, "viscous": value >= -half, "coulomb": value >= -half}.get(name, True)
    told = math.isfinite(half) and (half <= abs(value) or half <= term.fine) and possible
    words = {
        "travel": f"{1e3 * moved.travel:.2g} mm",
        "speed": f"{1e3 * moved.speed:.2g} mm/s",
        "jolt": f"{moved.jolt:.2g} m/s²",
    }
    advice = "" if told else f"Cannot tell. {term.advice.format(**words)}"
    return Estimate(name, value, half, asked, expected, told, advice)
