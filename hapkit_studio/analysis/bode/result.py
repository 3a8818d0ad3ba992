"""Bode diagram of the rendered impedance: the frequency response of a law in a sampled loop.

Z(jω) = -F(jω) / X(jω). F is the component at ω of the motor's force in effect, which is a staircase in
continuous time. X is the component of the handle's true position. The motion is imposed and has no component
above the Nyquist frequency, so there is no aliasing. For F = -(K x + B v^) the exact result is

    Z(jω) = (K + B V(e^jωT)) · (1 - e^-jωT) / (jωT) · e^-jω td

with the velocity estimator V, the period T and the delay td. A hand feels Z + jω b - m ω², where b and m are
the handle's damping and mass. The effective stiffness is Re Z, the effective damping Im Z / ω, and the
effective mass -Re Z / ω² where this is positive (Colonnese, Siu, Abbott and Okamura, IEEE Trans. Haptics
8(4), 2015). For ω -> 0 the damping is B - K (T/2 + td); if it is below -b, the loop adds energy (Colgate and
Schenkel, J. Robotic Systems 14(1), 1997).

A nonlinear law is excited by single sines. Z is then its describing function, and the hand does the work π Im
Z times the squared amplitude per cycle, for any waveform.

The coherence of a multisine is |Σ F X*|² / (Σ |F|² Σ |X|²) over motions with different phases. The coherence
of single sines is the fraction of the force's power at the sine's frequency. A coherence below 1 shows that
the force is nonlinear in the motion. The intervals of Z are 95 % intervals of its mean over the motions, by
Student's t.
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy.stats import t as student

from hapkit_studio.analysis.bode import COMPARED
from hapkit_studio.analysis.bode.drive import Drive, component, staircase
from hapkit_studio.dynamics.estimators import USUAL_QUANTUM, design, parse
from hapkit_studio.dynamics.loop_settings import LoopSettings, estimator_texts
from hapkit_studio.environments.base import Environment, Values
from hapkit_studio.formatting import hertz, on_screen, plain, with_unit

_FINE = 400
_DOWN = 1.0 / math.sqrt(2.0)
# Smallest ratio of the spring's force to the damper's force, at the lowest frequency, for a law to be treated
# as a spring.
_SPRING = 0.1
_STRAIGHT = 1e-6


@dataclass(frozen=True)
class LinearLaw:
    """A law F = -(stiffness x + damping v) about a place, in N/m and N·s/m."""

    stiffness: float
    damping: float


def linear_law(environment: Environment, values: Values, place: float, amplitude: float) -> LinearLaw | None:
    """Return a law's spring and damper about a place; None if the law has no force or is nonlinear there."""
    terms = environment.force_terms(values)
    law = LinearLaw(terms.stiffness or 0.0, terms.damping or 0.0)
    if not terms.simple or terms.one_way or terms.friction or law == LinearLaw(0.0, 0.0):
        return None
    away = amplitude * np.linspace(-1.0, 1.0, 9)
    force = environment.curve(values, place + away)
    straight = force[4] - law.stiffness * away
    return law if np.allclose(force, straight, atol=_STRAIGHT, rtol=_STRAIGHT) else None


def theory(setting: LoopSettings, law: LinearLaw, frequency: np.ndarray) -> np.ndarray | None:
    """Return the exact Z (n,) in N/m of a linear law at frequencies (n,) in Hz.

    Return None if the estimator is nonlinear.
    """
    turn = 2j * math.pi * frequency
    rendered = np.full(frequency.shape, law.stiffness, dtype=complex)
    if law.damping:
        response = parse(setting.estimator)[0].response
        if response is None:
            return None
        coefs = design(setting.estimator, setting.rate, setting.quantum or USUAL_QUANTUM)[1]
        rendered += law.damping * response(coefs, setting.period, np.exp(turn * setting.period))
    held = -np.expm1(-turn * setting.period) / (turn * setting.period)
    return rendered * held * np.exp(-turn * setting.delay)


@dataclass(frozen=True)
class Response:
    """The impedance Z (n,) in N/m at frequencies (n,) in Hz."""

    frequency: np.ndarray
    impedance: np.ndarray

    @property
    def stiffness(self) -> np.ndarray:
        """Return the effective stiffness (n,) in N/m."""
        return self.impedance.real

    @property
    def damping(self) -> np.ndarray:
        """Return the effective damping (n,) in N·s/m."""
        return self.impedance.imag / (2.0 * math.pi * self.frequency)

    @property
    def mass(self) -> np.ndarray:
        """Return the effective mass (n,) in kg; it is NaN where the response is that of a spring."""
        mass = -self.stiffness / (2.0 * math.pi * self.frequency) ** 2
        return np.where(mass > 0.0, mass, math.nan)

    def first(self, below: np.ndarray) -> float:
        """Return the frequency in Hz from which ``below`` (n,) is first negative; NaN if it never is."""
        there = np.flatnonzero(below < 0.0)
        if not there.size:
            return math.nan
        k = int(there[0])
        if k == 0:
            return float(self.frequency[0])
        share = below[k - 1] / (below[k - 1] - below[k])
        return float(self.frequency[k - 1] + share * (self.frequency[k] - self.frequency[k - 1]))


@dataclass(frozen=True)
class Curve:
    """The response of one loop: measurement, coherence (n,) and theory, which is None for a nonlinear law.

    ``where`` is "simulated", "computer" or "board". ``interval`` contains the half widths (n,) in N/m of the
    real and imaginary parts of Z, as complex numbers. ``clamped`` is the fraction of samples at the motor's
    limit.
    """

    where: str
    setting: LoopSettings
    measured: Response
    interval: np.ndarray
    coherence: np.ndarray
    clamped: float
    theory: Response | None

    @property
    def name(self) -> str:
        """Return the curve's label: the renderer and its rate."""
        return f"{self.where}, {with_unit(1e-3 * self.setting.rate, 'kHz')}"

    @property
    def best(self) -> Response:
        """Return the response for computing the marks: the theory if it is known, else the measurement."""
        if self.theory is not None:
            return self.theory
        there = self.coherence > 0.0
        return Response(self.measured.frequency[there], self.measured.impedance[there])

    @property
    def damping_interval(self) -> np.ndarray:
        """Return the half-width (n,) in N·s/m of the 95 % interval of the effective damping."""
        return self.interval.imag / (2.0 * math.pi * self.measured.frequency)

    @property
    def uncertainty(self) -> tuple[float, float]:
        """Return the largest half widths of |Z| (a fraction) and its angle (°), up to 0.4 of Nyquist."""
        low = (self.measured.frequency <= 0.5 * COMPARED * self.setting.rate) & (self.coherence > 0.0)
        if not low.any():
            return math.nan, math.nan
        share = float((np.abs(self.interval) / np.abs(self.measured.impedance))[low].max())
        return share, math.degrees(share)

    @property
    def stiffness(self) -> float:
        """Return the effective stiffness in N/m at the lowest frequency; 0 if the law is not a spring."""
        lowest = self.best.impedance[0] if self.best.impedance.size else 0.0
        return float(lowest.real) if lowest.real > _SPRING * abs(lowest.imag) else 0.0

    @property
    def softens(self) -> float:
        """Return the -3 dB frequency in Hz of the effective stiffness; NaN if it never falls so far."""
        return self.best.first(self.best.stiffness - _DOWN * self.stiffness) if self.stiffness else math.nan

    @property
    def negative(self) -> float:
        """Return the frequency in Hz above which the effective damping is negative; NaN if it never is."""
        return self.best.first(self.best.damping)

    @property
    def gives_energy(self) -> float:
        """Return the frequency in Hz above which the loop adds more energy than the handle dissipates."""
        return self.best.first(self.best.damping + self.setting.viscous)

    @property
    def outweighed(self) -> float:
        """Return the frequency in Hz above which inertia exceeds the stiffness; NaN if it never does."""
        inertia = self.setting.mass * (2.0 * math.pi * self.best.frequency) ** 2
        return self.best.first(self.best.stiffness - inertia) if self.stiffness else math.nan

    @property
    def ends(self) -> float:
        """Return the frequency in Hz above which the wall is soft or adds energy; NaN if it never is."""
        found = [f for f in (self.softens, self.gives_energy) if not math.isnan(f)]
        return min(found, default=math.nan)

    @property
    def error(self) -> tuple[float, float] | None:
        """Return the largest errors of |Z| (a fraction) and of its angle (in °), up to 0.4 of Nyquist."""
        if self.theory is None:
            return None
        exact = np.interp(self.measured.frequency, self.theory.frequency, self.theory.impedance)
        low = self.measured.frequency <= 0.5 * COMPARED * self.setting.rate
        if not exact.any():
            return None
        ratio = self.measured.impedance[low] / exact[low]
        return float(np.abs(np.abs(ratio) - 1.0).max()), float(np.degrees(np.abs(np.angle(ratio))).max())

    @property
    def sentence(self) -> str:
        """Return a sentence that states up to which frequency the loop renders a wall, and why."""
        loop = f"{self.name[0].upper()}{self.name[1:]}"
        if not self.best.frequency.size:
            return f"{loop}: no force of this scene depends on the motion."
        own = f"the handle's damping of {with_unit(self.setting.viscous, 'N·s/m')}"
        lowest, highest = (float(f) for f in self.best.frequency[[0, -1]])
        damping = with_unit(float(self.best.damping[0]), "N·s/m", 2)
        impedance = with_unit(self.stiffness, "N/m") if self.stiffness else f"damping {damping}"
        if self.gives_energy == lowest:
            return (
                f"{loop}: from {hertz(lowest)} on, the loop adds energy. Its effective damping is negative "
                f"({damping}) and adds more energy than {own} takes away."
            )
        if self.ends == self.softens:
            return (
                f"{loop}: {impedance} up to {hertz(self.ends)}, where the stiffness drops to 71 % (by 3 dB)."
            )
        if self.ends == self.gives_energy:
            return (
                f"{loop}: {impedance} up to {hertz(self.ends)}; above this frequency, the loop adds more "
                f"energy than {own} takes away."
            )
        return f"{loop}: {impedance} at all measured frequencies, up to {hertz(highest)}."


class Spectra:
    """The complex Fourier components (motions, n) of force F and position X at the tones of each motion."""

    def __init__(self, drive: Drive):
        self._drive = drive
        self._force: list[np.ndarray] = []
        self._position: list[np.ndarray] = []
        self._power: list[np.ndarray] = []

    def add(
        self, motion: int, times: np.ndarray, position: np.ndarray, edges: np.ndarray, force: np.ndarray
    ) -> None:
        """Add one period of samples: position (n,) in m at times in s; force (n,) in N between edges."""
        x, f, sampled = np.zeros((3, self._drive.tones.size), dtype=complex)
        own = self._drive.tones_in(motion)
        tones = self._drive.tones[own]
        x[own], f[own] = component(tones, times, position), staircase(tones, edges, force)
        sampled[own] = component(tones, times, force)
        self._position.append(x)
        self._force.append(f)
        self._power.append(
            np.divide(0.5 * np.abs(sampled) ** 2, force.var(), where=force.var() > 0.0, out=np.zeros(x.size))
        )

    def curve(self, where: str, setting: LoopSettings, clamped: float, law: LinearLaw | None) -> Curve:
        """Return the resulting curve; for a linear law it includes the theory."""
        tones, x, f = self._drive.tones, np.array(self._position), np.array(self._force)
        there = x != 0.0
        fx, xx, ff = (f * x.conj()).sum(axis=0), (np.abs(x) ** 2).sum(axis=0), (np.abs(f) ** 2).sum(axis=0)
        if self._drive.sines:
            coherence = np.array(self._power).sum(axis=0) / there.sum(axis=0)
        else:
            coherence = np.divide(np.abs(fx) ** 2, ff * xx, out=np.zeros_like(xx), where=ff > 0.0)
        impedance = -fx / xx
        away = np.where(there, -f / np.where(there, x, 1.0) - impedance, 0.0)
        count = there.sum(axis=0)
        with np.errstate(divide="ignore"):
            wide = student.ppf(0.975, count - 1) / np.sqrt(count * (count - 1))
        interval = wide * (np.sqrt((away.real**2).sum(axis=0)) + 1j * np.sqrt((away.imag**2).sum(axis=0)))
        fine = np.union1d(tones, np.geomspace(tones[0], tones[-1], _FINE))
        exact = theory(setting, law, fine) if law else None
        expected = None if exact is None else Response(fine, exact)
        return Curve(where, setting, Response(tones, impedance), interval, coherence, clamped, expected)


@dataclass(frozen=True)
class Bode:
    """The rendered impedance of a scene in one or more loops.

    ``place`` and ``amplitude`` of the excitation are in m. ``notes`` contains the reason of each failed
    measurement.
    """

    environment: Environment
    values: Values
    place: float
    amplitude: float
    curves: tuple[Curve, ...]
    notes: tuple[str, ...] = ()

    @property
    def sentence(self) -> str:
        """Return one sentence for each loop."""
        return "\n".join([*(curve.sentence for curve in self.curves), *self.notes])

    @property
    def driven(self) -> str:
        """Describe the excitation."""
        about, by = (on_screen(value, "m", 3) for value in (self.place, self.amplitude))
        pressed = float(-self.environment.curve(self.values, np.array([self.place]))[0])
        force = f", held there with {with_unit(abs(pressed), 'N', 2)}" if self.environment.shades else ""
        return f"moved by {by} about {about}{force}"

    def as_json(self) -> dict:
        """Return the result as an object of plain numbers in SI units."""
        return plain({
            "environment": self.environment.key, "parameters": dict(self.values), "place": self.place,
            "amplitude": self.amplitude, "curves": [_numbers(curve) for curve in self.curves],
            "notes": self.notes,
        })  # fmt: skip


def _numbers(curve: Curve) -> dict:
    def parts(response: Response) -> dict:
        z = response.impedance
        return {
            "frequency_Hz": response.frequency, "magnitude": np.abs(z), "phase_deg": np.degrees(np.angle(z)),
            "stiffness": response.stiffness, "damping": response.damping, "mass": response.mass,
        }  # fmt: skip

    s = curve.setting
    return {
        "where": curve.where, "rate_Hz": s.rate, "delay_s": s.delay,
        "estimator": estimator_texts(s.estimator)[0],
        "mass": s.mass, "viscous": s.viscous, "clamped": curve.clamped, **parts(curve.measured),
        "damping_interval": curve.damping_interval, "stiffness_interval": curve.interval.real,
        "coherence": curve.coherence, "theory": parts(curve.theory) if curve.theory else None,
        "off_theory": curve.error, "softens_Hz": curve.softens,
        "negative_damping_Hz": curve.negative, "gives_energy_Hz": curve.gives_energy,
        "outweighed_Hz": curve.outweighed, "ends_Hz": curve.ends, "sentence": curve.sentence,
    }  # fmt: skip
