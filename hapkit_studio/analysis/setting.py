"""What a stability question is asked about: the device, its loop and the hand, in plain numbers."""

import math
from dataclasses import dataclass, field

from hapkit_studio.analysis import checks
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.estimators import Spec, parse
from hapkit_studio.dynamics.hand import Grip, grip_named
from hapkit_studio.errors import ParameterError
from hapkit_studio.haptics.settings import LoopSettings
from hapkit_studio.parameters import Parameter

# What a device or loop can be, with room around anything that was ever built.
MASS = Parameter("mass", "The mass", "kg", 0.044, 1e-6, 1e4)
VISCOUS = Parameter("viscous", "The viscous damping", "N·s/m", 0.5, 0.0, 1e5)
COULOMB = Parameter("coulomb", "The Coulomb friction", "N", 0.10, 0.0, 1e4)
QUANTUM = Parameter("quantum", "The sensor quantum", "m", 20.7e-6, 0.0, 0.1)
RATE = Parameter("rate", "The rate", "Hz", 1000.0, 1.0, 1e6)
DELAY = Parameter("delay", "The delay", "s", 0.0, 0.0, 10.0)
NUMBERS = MASS, VISCOUS, COULOMB, QUANTUM, RATE, DELAY


def estimator_words(spec: Spec) -> tuple[str, str]:
    """Write a velocity estimator with its options: for programs as the command line takes it, for people."""
    method, options = parse(spec)
    numbers = [f"{key}={value:g}" for key, value in options.items()]
    given = f"{method.key}:{','.join(numbers)}" if numbers else method.key
    words = [f"{p.label.lower()} {options[p.key]:,g} {p.unit}".rstrip() for p in method.parameters]
    return given, ", ".join([method.label, *words])


@dataclass(frozen=True)
class Setting:
    """A handle of mass kg, viscous N·s/m and Coulomb N, its sensor's quantum m; the loop's rate Hz, delay s.

    estimator: "iir" or ("iir", {"cutoff": 20.0}); hand: a grip's name; controller: the passivity controller.
    Limits a person has do not apply. Raise ParameterError for what no device or loop can be.
    """

    mass: float = MASS.default
    viscous: float = VISCOUS.default
    coulomb: float = COULOMB.default
    quantum: float = QUANTUM.default
    rate: float = RATE.default
    delay: float = DELAY.default
    estimator: Spec = field(default="difference", hash=False)  # its options are a dictionary
    hand: str = "released"
    controller: bool = False

    def __post_init__(self) -> None:
        for number in NUMBERS:
            object.__setattr__(self, number.key, number.check(getattr(self, number.key)))
        checks.check_delay(self.rate, self.delay)
        parse(self.estimator)
        if not isinstance(self.hand, str):
            raise ParameterError(f"The hand takes a grip's name, not {self.hand!r}.")
        grip_named(self.hand)

    @property
    def period(self) -> float:
        """Return the time between two samples in s."""
        return 1.0 / self.rate

    @property
    def parted(self) -> tuple[int, float]:
        """Return the delay as a number of whole periods and the rest in s."""
        whole = math.floor(self.delay * self.rate + 1e-9)
        return whole, max(self.delay - whole * self.period, 0.0)

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
