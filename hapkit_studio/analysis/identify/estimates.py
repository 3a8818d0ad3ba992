"""Estimates with confidence intervals, and a check whether a recording determines them."""

import math
from dataclasses import dataclass, field

import numpy as np

from hapkit_studio.analysis.identify.regression import Fit
from hapkit_studio.analysis.identify.windows import Windows
from hapkit_studio.formatting import compact


@dataclass(frozen=True)
class Term:
    """A parameter that can be identified; ``fine`` is its just-noticeable difference, in its unit."""

    key: str
    label: str
    unit: str
    fine: float
    advice: str


_FARTHER = "Move farther: in these samples the handle moved only {travel}."
_FASTER = "{} faster: the highest speed in these samples is {{speed}}."
_BOTH_WAYS = "Move in both directions and at more than one speed."
TERMS = {
    term.key: term
    for term in (
        Term("stiffness", "Stiffness", "N/m", 10.0, _FARTHER),
        Term("damping", "Damping", "N·s/m", 0.25, _FASTER.format("Move")),
        Term("damping_in", "Damping on the way in", "N·s/m", 0.25, _FASTER.format("Push in")),
        Term("damping_out", "Damping on the way out", "N·s/m", 0.25, _FASTER.format("Pull out")),
        Term("friction", "Friction", "N", 0.05, _BOTH_WAYS),
        Term("centre", "Centre", "m", 0.5e-3, _FARTHER),
        Term(
            "mass", "Mass", "kg", 5e-3, "Shake faster: the largest acceleration in these samples is {jolt}."
        ),
        Term("viscous", "Viscous friction", "N·s/m", 0.1, _FASTER.format("Move")),
        Term("coulomb", "Coulomb friction", "N", 0.03, _BOTH_WAYS),
    )
}


@dataclass(frozen=True)
class Estimate:
    """An estimate with the half width of its 95 % confidence interval, in SI units.

    ``asked`` is the value that was set. ``expected`` is the value that a loop with this hold, delay and
    estimator should render for it. ``determined`` is True if the recording determines the value; otherwise
    ``advice`` says what to do.
    """

    key: str
    value: float
    half: float
    asked: float | None = None
    expected: float | None = None
    determined: bool = True
    advice: str = ""

    @property
    def term(self) -> Term:
        """Return the label, unit and advice of this parameter."""
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
        """Return True if a value lies in the interval."""
        return self.low <= value <= self.high


@dataclass(frozen=True)
class Points:
    """The windows used in a fit: time in s, named regressors (m, p), force in N, and the fit.

    The force is the sum of the regressors times their coefficients. The last regressor is the constant 1.
    ``middle`` is the position in m that is the origin of the position column.
    """

    time: np.ndarray
    names: tuple[str, ...]
    columns: np.ndarray
    force: np.ndarray
    fit: Fit
    middle: float = 0.0

    def share(self, name: str) -> tuple[np.ndarray, np.ndarray]:
        """Return a term's regressor (k,) and its partial residuals (k,) in N.

        Partial residuals are the force minus all other terms. Positions are those of the sensor. The constant
        force belongs to the stiffness term.
        """
        at = self.names.index(name)
        own = self.columns[:, at]
        there = own != 0.0
        moved, offset = self._constant(name)
        return own[there] + moved, own[there] * self.fit.beta[at] + offset + self.fit.residual[there]

    def line(self, name: str, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the fitted force (k,) in N at regressor values ``at`` (k,), and the half width (k,)."""
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
    """The result for the part "rendered" or "handle"; if there are no estimates, ``advice`` gives the reason.

    ``explained`` is R², the fraction of the force's variance that the fit explains. ``turning`` is the RMS
    speed over the RMS deviation of the position, in rad/s. ``seconds`` is the duration used. ``left_out`` is
    the number of excluded samples by reason. ``damped`` is the number of samples in which the passivity
    controller added damping.
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
        """Return an estimate by its key; raise KeyError for an unknown key."""
        return {e.key: e for e in self.estimates}[key]


# Smallest half width, as a fraction of ``Term.fine``: sums over samples have a discretisation error of this
# size.
_SMALLEST_HALF = 1e-3


@dataclass(frozen=True)
class Sizes:
    """The extent of a motion: peak-to-peak travel, largest speed and acceleration (``jolt``), mean position.

    Units are SI units. ``turning`` in rad/s is the RMS speed over the standard deviation of the position.
    """

    travel: float
    speed: float
    jolt: float
    turning: float
    middle: float = 0.0


def sizes(position: np.ndarray, windows: Windows, kept: np.ndarray) -> Sizes:
    """Return the extent of a motion (n,) in the windows marked by ``kept``; all values are 0 without any."""
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
    """Return the estimate; it is not determined if its interval exceeds both its value and ``Term.fine``."""
    term, value = TERMS[name], float(value)
    half = max(float(half), _SMALLEST_HALF * term.fine)
    # a mass is positive, and friction does not push
    possible = {"mass": value > half, "viscous": value >= -half, "coulomb": value >= -half}.get(name, True)
    determined = math.isfinite(half) and (half <= abs(value) or half <= term.fine) and possible
    texts = {
        "travel": f"{compact(1e3 * moved.travel, 2)} mm",
        "speed": f"{compact(1e3 * moved.speed, 2)} mm/s",
        "jolt": f"{compact(moved.jolt, 2)} m/s²",
    }
    advice = "" if determined else f"Unknown. {term.advice.format(**texts)}"
    return Estimate(name, value, half, asked, expected, determined, advice)
