"""What the window changes while the loop runs: checked here, in force at the next tick."""

import math
import threading
from collections.abc import Mapping

from hapkit_studio import environments
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.devices.terms import MODELS
from hapkit_studio.dynamics.estimators import Spec
from hapkit_studio.dynamics.hand import grip_named
from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import ParameterError
from hapkit_studio.haptics import arrays, block
from hapkit_studio.haptics.drivers import Driver
from hapkit_studio.haptics.fences import load_acquire
from hapkit_studio.haptics.rendering import Rendering
from hapkit_studio.haptics.settings_writer import LoopSettings, Wanted

# Ticks whose energies are kept: what a window reads late is not known any more.
ENERGIES = 1 << 13


def _environment(named: str | Environment) -> Environment:
    return named if isinstance(named, Environment) else environments.named(named)


class Controls(Rendering):
    """The settings of one loop and the block they reach it through."""

    def __init__(self, device, environment: str | Environment):
        self._block = block.new_block()
        self._arrays = arrays.new_arrays(*self._block, energies=ENERGIES)
        self._lock = threading.RLock()
        self._driver: Driver | None = None
        # a law by its address, with the last generation of settings that wanted it
        self._kept: dict[int, tuple[int, object]] = {}
        self._grip_name = "medium"
        self._target: float | None = None
        self._model = MODELS[0]
        self.device = device
        chosen = _environment(environment)
        self._wanted = Wanted(chosen, chosen.values())

    def _publish(self, wanted: Wanted) -> None:
        with self._lock:
            wanted.generation = self._wanted.generation + 1
            grip = grip_named(self._grip_name)
            wanted.grip, wanted.target = grip, self._target
            device = self._modelled(wanted.environment)
            if device is not None:
                wanted.viscous, wanted.coulomb = device.viscous, device.coulomb_force
                wanted.quantum, wanted.mass = device.quantum, device.mass
            wanted.board = self._board_way(wanted)
            content = wanted.encode()
            law = wanted.environment.force.compiled()
            self._kept[law.address] = (wanted.generation, law)
            block.publish(*self._block, *content)
            self._wanted = wanted
            accepted = int(load_acquire(self._arrays.control, arrays.ACCEPTED))
            self._kept = {address: kept for address, kept in self._kept.items() if kept[0] >= accepted}

    def _changed(self, **changes) -> None:
        with self._lock:
            self._publish(Wanted(**{**vars(self._wanted), **changes}))

    @property
    def environment(self) -> Environment:
        return self._wanted.environment

    def renders(self, environment: Environment) -> bool:
        """Return whether the newest rows hold this environment's state: a switch takes until a tick."""
        law = int(self._arrays.laws[self._arrays.word[arrays.SLOT]])
        return environment is self.environment and law == environment.force.compiled().address

    @property
    def values(self) -> dict[str, float]:
        return dict(self._wanted.values)

    @property
    def loop(self) -> LoopSettings:
        return self._wanted.loop

    def _modelled(self, environment: Environment) -> SimulatedHapkit | None:
        if not isinstance(self.device, SimulatedHapkit):
            return None
        return self.device if self._model == "everything" else self.device.reduced(environment.needs)

    @property
    def modelled(self) -> SimulatedHapkit | None:
        """Return the simulated device as the loop models it now, None for a board."""
        return self._modelled(self.environment)

    @property
    def model(self) -> str:
        return self._model

    def set_model(self, name: str) -> None:
        """Model what the scene needs ("scene"), or "everything"; raise ParameterError."""
        if name not in MODELS:
            raise ParameterError(f"The model is one of {', '.join(MODELS)}, not {name!r}.")
        with self._lock:
            self._model = name
            self._changed()

    @property
    def grip(self) -> str:
        return self._grip_name

    def set_environment(self, key: str | Environment, values: Mapping[str, object] | None = None) -> None:
        """Switch to an environment, cross-faded over 30 ms; raise ParameterError."""
        chosen = _environment(key)
        self._changed(environment=chosen, values=chosen.values(values))

    def set_parameter(self, key: str, value: object) -> None:
        """Change one parameter; raise ParameterError, and the loop keeps the last good value."""
        current = {p.key: self._wanted.values[p.key] for p in self.environment.parameters}
        self._changed(values=self.environment.values({**current, key: value}))

    def set_loop(
        self,
        rate: float | None = None,
        delay: float | None = None,
        estimator: Spec | None = None,
        controller: bool | None = None,
    ) -> None:
        """Change rate in Hz, added delay in s, velocity estimator, controller; raise ParameterError."""
        own_rate = self._driver.rate if self._driver is not None else None
        if rate is not None and own_rate not in (None, rate):
            raise ParameterError(f"{self.device.title} sets the rate: {own_rate:g} Hz, not {rate:g} Hz.")
        self._changed(loop=self.loop.changed(rate, delay, estimator, controller))

    @property
    def max_force(self) -> float:
        """Return the clamp in force in N: the device's own limit, or one below it."""
        return float(self._wanted.max_force)

    def limit_force(self, newtons: float) -> None:
        """Clamp the force to so many N, the device's own limit at most; raise ParameterError, DeviceError."""
        most = self.device.max_force
        if not 0.0 < newtons <= most:
            raise ParameterError(f"The force limit goes from 0 to {most:g} N, not {newtons:g} N.")
        self._changed(max_force=newtons)

    def set_grip(self, name: str) -> None:
        """Choose how firmly the hand holds: released, light, medium, firm; raise ParameterError."""
        grip_named(name)
        self._grip_name = name
        self._hand_moved()

    def move_hand(self, target: float | None) -> None:
        """Move the hand's target to a position in m, None lets go; raise ParameterError."""
        if target is not None and not math.isfinite(target):
            raise ParameterError(f"The hand's target must be a finite number of m, not {target:g}.")
        self._target = target
        self._hand_moved()

    def _hand_moved(self) -> None:
        self._changed()
        if self._driver is not None:
            self._driver.move_hand(self._target, self._grip_name)
