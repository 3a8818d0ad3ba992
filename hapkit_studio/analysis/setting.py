"""What a stability question is asked about: the device, its loop and the hand, in plain numbers."""

import math
from dataclasses import dataclass

import numpy as np

from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.estimators import Spec, parse
from hapkit_studio.dynamics.hand import Grip, grip_named
from hapkit_studio.errors import ParameterError
from hapkit_studio.haptics.settings_writer import LoopSettings

# Field, name in words, unit, whether it must be more than 0.
_CHECKED = (
    ("mass", "mass", "kg", True),
    ("viscous", "viscous damping", "N·s/m", False),
    ("coulomb", "Coulomb friction", "N", False),
    ("quantum", "sensor quantum", "m", False),
    ("rate", "rate", "Hz", True),
    ("delay", "delay", "s", False),
)


@dataclass(frozen=True)
class Setting:
    """A handle of mass kg, viscous N·s/m and Coulomb N, its sensor's quantum m; the loop's rate Hz, delay s.

    estimator: "iir" or ("iir", {"cutoff": 20.0}); hand: a grip's name; controller: the passivity controller.
    Limits a person has do not apply. Raise ParameterError for what no device or loop can be.
    """

    mass: float = 0.044
    viscous: float = 0.5
    coulomb: float = 0.10
    quantum: float = 20.7e-6
    rate: float = 1000.0
    delay: float = 0.0
    estimator: Spec = "difference"
    hand: str = "released"
    controller: bool = False

    def __post_init__(self) -> None:
        for field, name, unit, above in _CHECKED:
            _check(getattr(self, field), name, unit, above)
        parse(self.estimator)
        grip_named(self.hand)

    def __hash__(self) -> int:
        """Return the hash of the numbers; the estimator's options are a dictionary, which has none."""
        return hash((self.mass, self.viscous, self.rate, self.delay, self.hand))

    @property
    def period(self) -> float:
        """Return the time between two samples in s."""
        return 1.0 / self.rate

    @property
    def grip(self) -> Grip | None:
        """Return what the hand adds to the handle, None for a released one."""
        return grip_named(self.hand)

    @property
    def loop(self) -> LoopSettings:
        """Return the loop as the headless batches take it."""
        return LoopSettings(self.rate, self.delay, self.estimator, self.controller)

    @property
    def linear(self) -> bool:
        """Return whether the velocity estimator has a transfer function, and so an exact limit."""
        return parse(self.estimator)[0].response is not None

    def device(self, real: bool = True, position: float = 0.0, velocity: float = 0.0) -> SimulatedHapkit:
        """Return the handle that starts at position m and velocity m/s, without a force limit.

        real=False: without Coulomb friction and sensor steps, as the exact limits have it.
        """
        coulomb, quantum = (self.coulomb, self.quantum) if real else (0.0, 0.0)
        return SimulatedHapkit(self.mass, self.viscous, coulomb, quantum, math.inf, position, velocity)


def _check(value: float, name: str, unit: str, above: bool) -> None:
    if isinstance(value, bool) or not isinstance(value, int | float | np.number):
        raise ParameterError(f"The {name} takes a number in {unit}, not {value!r}.")
    if not math.isfinite(value) or value < 0.0 or (above and value == 0.0):
        bound = "more than 0" if above else "0 or more"
        raise ParameterError(f"The {name} must be {bound} {unit}, not {value:g} {unit}.")
