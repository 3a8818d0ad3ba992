"""Motions of a hand in a scene, and the difference that people feel between two renderings."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from hapkit_studio.analysis import perception
from hapkit_studio.analysis.perception import MOMENT, Difference
from hapkit_studio.dynamics.hand import Hand, hand_named
from hapkit_studio.environments.base import Environment
from hapkit_studio.formatting import compact
from hapkit_studio.haptics import headless, rows

# m/s, to the right: speed at which a released handle starts from the middle, because it would not move
# otherwise
THROWN = 0.5
THROWS = np.linspace(0.3, 0.7, 81)
SECONDS = {
    "released": 1.0, "press": 1.5, "push": 1.5, "tap": 0.8, "stroke": 2.4, "sweep": 1.8, "hold": 0.8,
    "pluck": 2.0, "shake": 2.0, "pet": 9.6, "rub": 2.4,
}  # fmt: skip
OTHER_SECONDS = 2.0
# s: duration of a longer run; time for which the handle is observed after its release
LONG, WATCHED = 3.0, 1.0
_STEP = 1e-6  # s: step of the numerical derivative of a hand's target
# the hands for an environment that declares none, such as a student's
HANDS = ("released", "press", "stroke")


@dataclass(frozen=True)
class Trial:
    """A hand's motion in a scene, with its duration in s, and the handle's initial speed in m/s."""

    label: str
    hand: Hand
    seconds: float
    thrown: float = 0.0

    @property
    def holds(self) -> bool:
        """Return True if the hand stays on the handle; the hand's mass is then added."""
        return self.hand.mass > 0.0 and math.isinf(self.hand.release)


def script(name: str) -> Trial:
    """Return the trial with the hand script of this name."""
    hand = hand_named(name)
    return Trial(name, hand, SECONDS.get(name, OTHER_SECONDS), THROWN if hand.release <= 0.0 else 0.0)


def scripts(environment: Environment) -> list[Trial]:
    """Return the trials of the hand scripts that a scene declares."""
    return [script(name) for name in environment.hands or HANDS]


def variants(trial: Trial) -> Iterator[Trial]:
    """Yield variants: other throwing speeds, a longer run, other times of release."""
    if trial.thrown:
        for speed in THROWS:
            yield replace(trial, label=f"thrown {compact(speed, 3)} m/s", seconds=LONG, thrown=speed)
        return
    if trial.seconds < LONG:
        yield replace(trial, label=f"{trial.label} for {LONG:g} s", seconds=LONG)
    for moment in np.arange(MOMENT, trial.seconds, MOMENT):
        let_go = replace(trial.hand, release=moment)
        yield Trial(f"{trial.label} until {compact(moment, 3)} s", let_go, moment + WATCHED)


def render(scene: headless.Scene, trial: Trial) -> np.ndarray:
    """Return the rows at perception.RATE of a scene in a trial; the last row is at the trial's end.

    If the loop rate is not a multiple of perception.RATE, the motion is interpolated by cubics through the
    positions and velocities.
    """
    handle = replace(scene.device, initial_velocity=trial.thrown)
    scene, rate = replace(scene, device=handle), scene.loop.rate
    count, every = math.ceil(trial.seconds * rate - 1e-9) + 1, round(rate / perception.RATE)
    if every and math.isclose(every * perception.RATE, rate, rel_tol=1e-9):
        found = headless.render_every(scene, trial.hand, count, every)
    else:
        found = _resampled(headless.render_every(scene, trial.hand, count, 1), rate, trial.seconds)
    found[:, rows.HAND_FORCE] = _hand_force(trial.hand, found)
    return found


def _resampled(found: np.ndarray, rate: float, seconds: float) -> np.ndarray:
    wanted = np.arange(round(seconds * perception.RATE) + 1) / perception.RATE
    resampled, known = found[(wanted * rate + 1e-9).astype(int)], np.arange(len(found)) / rate
    motion = found[:, (rows.TRUE_POSITION, rows.TRUE_VELOCITY)]
    if np.isfinite(motion).all():
        from scipy.interpolate import CubicHermiteSpline

        path = CubicHermiteSpline(known, *motion.T)
        resampled[:, rows.TRUE_POSITION] = path(wanted)
        resampled[:, rows.TRUE_VELOCITY] = path(wanted, 1)
    return resampled


def _hand_force(hand: Hand, found: np.ndarray) -> np.ndarray:
    """Return the force (n,) in N of a hand on a handle whose motion is in rows (n, ROW_WIDTH) at RATE.

    The hand force in the rows is not used: it contains the target's velocity of half a sample earlier, which
    causes an error of up to 11 mN at 1 kHz.
    """
    t = np.arange(len(found)) / perception.RATE
    target, before, after = (hand.target(t + s) for s in (0.0, -_STEP, _STEP))  # type: ignore[arg-type]
    position, velocity = found[:, rows.TRUE_POSITION], found[:, rows.TRUE_VELOCITY]
    force = hand.stiffness * (target - position) + hand.damping * (
        (after - before) / (2.0 * _STEP) - velocity
    )
    return np.where(t < hand.release, force, 0.0)


def felt(
    environment: Environment,
    trial: Trial,
    one: np.ndarray,
    other: np.ndarray,
    force_share: float = perception.FORCE_SHARE,
) -> Difference:
    """Return the difference that a person feels between two runs of a trial."""
    counted = [rows.STATE + environment.state_names.index(name) for name in environment.counts]
    return perception.difference_under(trial.hand, one, other, counted, force_share)
