"""The stiffest virtual spring that stays stable: exact from the sampled loop, and measured by simulation."""

import math

import numpy as np

from hapkit_studio.analysis.exact import checked_loop, stiffness_limits
from hapkit_studio.analysis.measured import stiffest
from hapkit_studio.analysis.settling import Rendered
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.estimators import Spec
from hapkit_studio.dynamics.filter_design import USUAL_QUANTUM
from hapkit_studio.dynamics.hand import Grip, Hand
from hapkit_studio.haptics.settings_writer import LoopSettings


def stiffness_limit(
    mass: float,
    viscous: float,
    *,
    damping: float = 0.0,
    rate: float = 1000.0,
    delay: float = 0.0,
    estimator: Spec = "difference",
    hand: Hand | Grip | str | None = None,
    quantum: float = USUAL_QUANTUM,
) -> float:
    """Return the largest stable virtual stiffness in N/m, exact; 0 if the damping alone is unstable.

    mass kg, viscous and virtual damping N·s/m, rate Hz, delay s; hand: a Hand, a Grip, a name, or None for a
    released handle; quantum in m: the sensor's, which the velocity estimator is designed for. Raise
    ParameterError.
    """
    loop = checked_loop(mass, viscous, damping, rate, delay, estimator, hand, quantum)
    return float(stiffness_limits(loop, np.array([loop.damping]))[0])


def measured_stiffness_limit(
    mass: float,
    viscous: float,
    *,
    damping: float = 0.0,
    rate: float = 1000.0,
    delay: float = 0.0,
    estimator: Spec = "difference",
    hand: Hand | Grip | str | None = None,
    quantum: float = USUAL_QUANTUM,
) -> float:
    """Return the largest stable virtual stiffness in N/m to 1e-4, found by rendering the spring.

    Arguments as ``stiffness_limit``; a hand rests at the centre. 0 if not even a spring of 1 mN/m is stable
    (of more, where a mass needs more than 5 million samples for 80 rad), inf beyond 1 GN/m. The rule is that
    of ``settling``, for an ideal device: with an estimator that is not linear, a buzz of up to five of the
    sensor's counts counts as stable. Raise ParameterError.
    """
    loop = checked_loop(mass, viscous, damping, rate, delay, estimator, hand, quantum)
    device = SimulatedHapkit(mass, viscous, 0.0, 0.0, math.inf)
    loop_settings = LoopSettings(rate, delay, estimator)
    what = Rendered(device, loop_settings, loop.hand, quantum=quantum or USUAL_QUANTUM)
    return stiffest(what, damping)
