"""What identification answers: numbers with intervals, and the points they were drawn from."""

from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True)
class Term:
    """One thing that can be identified: fine is an interval so narrow that a hand feels no difference."""

    key: str
    label: str
    unit: str
    fine: float
    advice: str


TERMS = {
    term.key: term
    for term in (
        Term("stiffness", "Stiffness", "N/m", 10.0, "Move farther: the piece keeps within {travel}."),
        Term("damping", "Damping", "N·s/m", 0.25, "Move faster: the piece holds no speed above {speed}."),
        Term(
            "damping_in",
            "Damping, going in",
            "N·s/m",
            0.25,
            "Go in faster: the piece holds no speed above {speed}.",
        ),
        Term(
            "damping_out",
            "Damping, going out",
            "N·s/m",
            0.25,
            "Come out faster: the piece holds no speed above {speed}.",
        ),
        Term("friction", "Friction", "N", 0.05, "Move both ways, at more than one speed."),
        Term("centre", "Centre", "m", 0.5e-3, "Move farther: the piece keeps within {travel}."),
        Term("mass", "Mass", "kg", 5e-3, "Shake faster: the piece holds no acceleration above {jolt}."),
        Term("viscous", "Viscous friction", "N·s/m", 0.1, "Move faster: no speed above {speed}."),
        Term("coulomb", "Coulomb friction", "N", 0.03, "Move both ways, at more than one speed."),
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
    """The windows that were used: time s, columns (m, p) named, coefficients (p,), force and residual in N.

    The force is the sum of columns times coefficients; the last column is 1. middle is the position in m that
    the column of positions counts from.
    """

    time: np.ndarray
    names: tuple[str, ...]
    columns: np.ndarray
    beta: np.ndarray
    covariance: np.ndarray
    quantile: float
    force: np.ndarray
    residual: np.ndarray
    middle: float = 0.0

    def share(self, name: str) -> tuple[np.ndarray, np.ndarray]:
        """Return what a term acts on (k,) and the force in N (k,) that is left without the other terms.

        Positions are the sensor's own, and the constant force stays with them.
        """
        at = self.names.index(name)
        own = self.columns[:, at]
        there = own != 0.0
        moved, offset = self._constant(name)
        return own[there] + moved, own[there] * self.beta[at] + offset + self.residual[there]

    def line(self, name: str, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the term's force in N at values (k,) of what it acts on, and its band's half width (k,)."""
        moved, offset = self._constant(name)
        place, own = self.names.index(name), at - moved
        gradient = np.zeros((len(at), len(self.beta)))
        gradient[:, place] = own
        gradient[:, -1] = 1.0 if name == "stiffness" else 0.0
        variance = np.einsum("ki,ij,kj->k", gradient, self.covariance, gradient)
        return own * self.beta[place] + offset, self.quantile * np.sqrt(np.maximum(variance, 0.0))

    def _constant(self, name: str) -> tuple[float, float]:
        return (self.middle, float(self.beta[-1])) if name == "stiffness" else (0.0, 0.0)


@dataclass(frozen=True)
class Part:
    """One question's answer: key "rendered" or "handle"; estimates may be empty, then advice says why.

    explained is the share of the force's variance that the terms make; hertz the motion's own frequency,
    seconds the length of what was used; left_out counts samples by the reason, with_clamp what
    is found with the clamped samples too, damped counts those in which the passivity controller damped.
    """

    key: str
    estimates: tuple[Estimate, ...] = ()
    advice: str = ""
    explained: float = float("nan")
    hertz: float = float("nan")
    seconds: float = 0.0
    released: bool = False
    points: Points | None = field(default=None, repr=False)
    left_out: dict[str, int] = field(default_factory=dict)
    with_clamp: tuple[Estimate, ...] = ()
    damped: int = 0

    def __getitem__(self, key: str) -> Estimate:
        """Return an estimate by its key; raise KeyError."""
        return next((e for e in self.estimates if e.key == key), None) or self._missing(key)

    def _missing(self, key: str) -> Estimate:
        raise KeyError(key)
