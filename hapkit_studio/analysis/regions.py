"""What friction and the sensor's steps make of the plane of damping and stiffness.

Abbott & Okamura (T-RO 21(5), 2005): friction f_c hides the steps Δ of the sensor while K <= 2 f_c/Δ.
Diolaiti, Niemeyer, Barbagli, Salisbury (T-RO 22(2), 2006): in β = b/(K T) and σ = f_c/(K Δ) the borders are
β = 1/2 + td/T and σ = 1/2. b counts all damping there is: the handle's, the hand's, and the virtual one.
"""

import math

import numpy as np

from hapkit_studio.analysis.setting import Setting

RESTS, BUZZES, NEAR, GROWS = range(4)
WORDS = {
    RESTS: "comes to rest",
    BUZZES: "buzzes by a count or two, and no more",
    NEAR: "comes to rest if let go near, grows from farther away",
    GROWS: "grows",
}


def damping_of(setting: Setting) -> float:
    """Return the damping of handle and hand in N·s/m."""
    return setting.viscous + (setting.grip.damping if setting.grip else 0.0)


def simple_rule(setting: Setting, damping: np.ndarray) -> np.ndarray:
    """Return (b + B) / (T/2 + td) in N/m: the rule of Gil et al. (2009), hopeful where B is large."""
    return (damping_of(setting) + np.asarray(damping)) / (0.5 * setting.period + setting.delay)


def coulomb_line(setting: Setting) -> float:
    """Return the stiffness 2 f_c/Δ in N/m above which friction no longer hides the sensor's steps."""
    return 2.0 * setting.coulomb / setting.quantum if setting.quantum > 0.0 else math.inf


def dimensionless(setting: Setting, damping: float, stiffness: float) -> tuple[float, float]:
    """Return Diolaiti's (β, σ); infinite without stiffness, σ also without sensor steps."""
    if stiffness <= 0.0:
        return math.inf, math.inf
    beta = (damping_of(setting) + damping) / (stiffness * setting.period)
    return beta, 0.5 * coulomb_line(setting) / stiffness


def classes(setting: Setting, stiffness: np.ndarray, limit: np.ndarray) -> np.ndarray:
    """Return the region (m, n) of each stiffness (m,) in each column whose linear limit (n,) is given, N/m.

    limit: ``simple_rule`` for Diolaiti's own borders, the exact boundary for those of this loop. What grows
    comes to rest when it is let go near, where friction also hides the steps.
    """
    rows = np.asarray(stiffness)[:, np.newaxis]
    stable = rows <= np.asarray(limit)[np.newaxis, :]
    hidden = np.broadcast_to(rows <= coulomb_line(setting), stable.shape)
    return np.where(
        stable, np.where(hidden, RESTS, BUZZES), np.where(hidden & (setting.coulomb > 0.0), NEAR, GROWS)
    )


def resting_reach(setting: Setting, damping: float, stiffness: float) -> float:
    """Return how far away in m the handle may be let go to come to rest; inf where it always does.

    Friction takes 4 f_c A a turn, the loop gives π ω A² (K (T/2 + td) - b): A = 4 f_c / (π ω (…)).
    """
    gained = stiffness * (0.5 * setting.period + setting.delay) - damping_of(setting) - damping
    if gained <= 0.0:
        return math.inf
    grip = setting.grip
    mass = setting.mass + (grip.mass if grip else 0.0)
    spring = stiffness + (grip.stiffness if grip else 0.0)
    return 4.0 * setting.coulomb / (math.pi * math.sqrt(spring / mass) * gained)
