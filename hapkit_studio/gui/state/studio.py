"""The user's choices and the engine that renders them. The window uses the engine only via Studio."""

import math
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QObject, Signal

from hapkit_studio.dynamics.loop_settings import FIELDS, USUAL_LOOP
from hapkit_studio.environments import discover
from hapkit_studio.errors import ParameterError
from hapkit_studio.gui.state.board_answer import BoardAnswer
from hapkit_studio.gui.state.device_link import Build, DeviceLink, LinkStatus, build_engine
from hapkit_studio.gui.state.environment_library import EnvironmentLibrary, Readiness
from hapkit_studio.gui.state.lock import DEVICE, GRIP, LOOP, Place
from hapkit_studio.gui.state.permissions import BLIND, Permissions
from hapkit_studio.gui.state.recording import Recording
from hapkit_studio.gui.state.stop_state import StopState

if TYPE_CHECKING:
    from hapkit_studio.devices import DeviceEntry
    from hapkit_studio.devices.base import Device
    from hapkit_studio.environments.base import Environment
    from hapkit_studio.haptics.engine import Engine
    from hapkit_studio.haptics.health import Fault, Health

_FIRST = "wall"


class Studio(QObject):
    """Keeps the user's choices when the device changes; values are in SI and checked before they are stored.

    This class is a facade. ``library`` holds the environments and their values. ``device`` is the link to the
    current device. ``permissions`` determines which settings may be changed. ``stop_state`` is the E-stop.
    ``board_answer`` polls how the board renders. ``recording`` is the recorder. ``refused`` is emitted with
    the reason why an environment or its defaults were refused.
    """

    environment_changed = Signal()
    values_changed = Signal()
    loop_changed = Signal()
    settings_changed = Signal()
    """Emitted together with each of the three signals above."""
    stop_changed = Signal()
    engine_changed = Signal()
    link_changed = Signal()
    ranges_changed = Signal()
    hidden_changed = Signal()
    lock_changed = Signal()
    refused = Signal(str)

    def __init__(
        self,
        entries: Callable[[], Sequence["DeviceEntry"]],
        build: Build = build_engine,
        parent: QObject | None = None,
    ):
        super().__init__(parent)
        self.library = EnvironmentLibrary(discover())
        self.environments = self.library.environments
        first = _FIRST if _FIRST in self.environments else next(iter(self.environments))
        self.environment = self.environments[first]
        self.environment_since = -math.inf
        """When the environment was selected, in s of the rows' clock."""
        self.readiness = Readiness(self)
        self.readiness.request_ready.connect(self.choose)
        self.permissions, self.stop_state = Permissions(self), StopState(self)
        self.device = DeviceLink(entries, build, self.stop_state.stop_if_needed, self._configure, self)
        self.stop_state.device = self.device
        self.recording = Recording(self.device, lambda: self.environment.key, self)
        self.device.engine_changed.connect(self.engine_changed)
        self.device.link_changed.connect(self.link_changed)
        self.loop = USUAL_LOOP
        self.board_answer = BoardAnswer(self.device)
        self.unstable_ranges: Mapping[str, Sequence[tuple[float, float]]] = {}
        """Each parameter's known unstable ranges in SI for the current loop."""
        for changed in (self.environment_changed, self.values_changed, self.loop_changed):
            changed.connect(self.settings_changed)
        for changed in (self.values_changed, self.loop_changed):
            changed.connect(self.board_answer.poll_soon)
        self.board_answer.changed.connect(self.loop_changed)
        self.permissions.lock_changed.connect(self.lock_changed)
        self.permissions.hidden_changed.connect(self.hidden_changed)
        self.stop_state.changed.connect(self.stop_changed)

    def close(self) -> None:
        """Stop the loop and wait for its last zero command."""
        self.readiness.stop()
        self.device.close()
        self.recording.close()

    # permissions

    @property
    def hidden(self) -> str:
        """Return why the rendered values differ from the shown ones; "" if they are equal."""
        return self.permissions.hidden

    @property
    def temporary(self) -> bool:
        """Return whether a measurement has changed settings and will restore them."""
        return self.permissions.temporary

    def temporarily(self) -> AbstractContextManager[None]:
        """Allow a measurement to change and restore settings, without undo steps."""
        return self.permissions.temporarily()

    def why_fixed(self, *place: str) -> str:
        """Return why a setting cannot be changed now; "" if it can be changed."""
        return self.permissions.why_fixed(*place)

    def check_free(self, places: Iterable[Place]) -> None:
        """Raise ParameterError if one of these settings cannot be changed now."""
        for place in places:
            if why := self.why_fixed(*place):
                raise ParameterError(f"{self._title(place)}: {why[:1].lower()}{why[1:]}.")

    def _title(self, place: Place) -> str:
        kind, *names = place
        if kind == "value":
            return next(p.label for p in self.environments[names[0]].parameters if p.key == names[1])
        return self.environments[names[0]].title if kind == "environment" else "Loop and grip"

    # environment and values

    @property
    def values(self) -> dict[str, float]:
        """Return the values of the current environment."""
        return self.library.values[self.environment.key]

    def choose(self, key: str) -> None:
        """Select an environment with its last values, either now or as soon as it is compiled."""
        try:
            if key != self.environment.key:
                self.check_free([("environment", key)])
        except ParameterError as error:
            self.refused.emit(str(error))
            return
        if self.readiness.request(key) and key != self.environment.key:
            self._activate(self.environments[key])

    def adopt(self, environment: "Environment") -> None:
        """Add a compiled environment, or a newer version of it, and select it."""
        self.library.put(environment)
        self.readiness.drop_request()
        self._activate(environment)

    def drop(self, key: str) -> None:
        """Remove an environment; raise KeyError if it is the current one."""
        if key == self.environment.key:
            raise KeyError(key)
        self.library.drop(key)

    def _activate(self, environment: "Environment") -> None:
        self.environment, self.environment_since = environment, time.perf_counter()
        self.unstable_ranges = {}
        self.hide_values(None)
        if self.engine is not None:
            self.engine.set_environment(environment, self.values)
        self.environment_changed.emit()
        self.values_changed.emit()

    def set_value(self, key: str, value: float) -> None:
        """Change one parameter; if it is invalid, change nothing and raise ParameterError."""
        self.set_values({key: value})

    def set_values(self, changes: Mapping[str, float]) -> None:
        """Change several parameters at once; if one is invalid, change nothing and raise ParameterError."""
        self._set_values(self.environment.changed(self.values, changes))

    def values_of(self, key: str) -> dict[str, float]:
        """Return the current or last values of an environment."""
        return dict(self.library.values[key])

    def set_values_of(self, key: str, changes: Mapping[str, float]) -> None:
        """Change several parameters of any environment; raise ParameterError if one is invalid."""
        if key == self.environment.key:
            self.set_values(changes)
        else:
            numbers = self.environments[key].changed(self.library.values[key], changes)
            self.check_values(key, numbers)
            self.library.values[key].update(numbers)

    def note_ranges(self, unstable_ranges: Mapping[str, Sequence[tuple[float, float]]]) -> None:
        """Set the unstable ranges for all sliders of the window."""
        self.unstable_ranges = unstable_ranges
        self.ranges_changed.emit()

    def reset_values(self) -> None:
        """Reset all parameters to their defaults at once, except locked ones."""
        key = self.environment.key
        try:
            locked = {p: v for p, v in self.values.items() if self.why_fixed("value", key, p)}
            self._set_values(self.environment.values(locked))
        except ParameterError as error:  # the defaults are invalid together with the locked values
            self.refused.emit(str(error))

    def hide_values(self, values: Mapping[str, float] | None, why: str = BLIND) -> None:
        """Render values that differ from those in the window; None renders the shown values again.

        Meanwhile the user cannot change settings. If a measurement applies its values, or another environment
        is selected, the values are no longer hidden. Raise ParameterError if a value is invalid or may not be
        changed.
        """
        numbers = None if values is None else self.environment.values(values)
        if numbers is not None and not self.hidden:
            self.check_values(self.environment.key, numbers)
        if not self.permissions.hide(numbers, why):
            return
        if self.engine is not None:
            self.engine.set_environment(self.environment, numbers or self.values)
        self.hidden_changed.emit()

    def check_values(self, key: str, numbers: Mapping[str, float]) -> None:
        """Raise ParameterError if the user may not change an environment's values to these."""
        old = self.library.values[key]
        self.check_free(("value", key, name) for name, number in numbers.items() if old[name] != number)

    def _set_values(self, numbers: dict[str, float]) -> None:
        self.check_values(self.environment.key, numbers)
        if self.temporary:
            self.hide_values(None)
        if self.engine is not None:
            self.engine.put_values(self.permissions.hidden_values or numbers)
        self.values.update(numbers)
        self.values_changed.emit()

    # loop and hand

    @property
    def grip(self) -> str:
        """Return the grip of the simulated hand."""
        return self.loop.hand

    def set_loop(self, **changes: Any) -> None:
        """Change settings of the loop by their names in LoopSettings.

        Raise ParameterError if they are refused.
        """
        loop = self.loop.changed(**changes)
        changed = {key: getattr(loop, key) for key in changes}
        differing = [key for key, value in changed.items() if value != getattr(self.loop, key)]
        self.check_free({GRIP if key == "hand" else LOOP for key in differing})
        if self.engine is not None:
            where = {key: changed.pop(key) for key in ("where", "board_rate") if key in changed}
            if changed:
                self.engine.change_loop(changed)
            if where:
                self.engine.set_where(loop.where, loop.board_rate)
        self.loop = loop
        self.loop_changed.emit()

    def move_hand(self, target: float | None) -> None:
        """Pull the handle towards a position in m; None releases it."""
        if self.engine is not None:
            self.engine.move_hand(target)

    def release_at_rest(self) -> None:
        """Release a simulated handle at its current position with zero velocity."""
        if self.engine is not None:
            self.engine.release_at_rest()

    # stopping

    @property
    def stopped(self) -> bool:
        """Return whether the E-stop is latched."""
        return self.stop_state.stopped

    def stop(self) -> None:
        """Set the force to zero at the next tick."""
        self.stop_state.stop()

    def release_stop(self) -> None:
        """Release the E-stop; the force fades in."""
        self.stop_state.release()

    @property
    def waits_for_render(self) -> bool:
        """Return whether a motor stays off until the user presses *Render*."""
        return self.stop_state.waiting

    @property
    def fault(self) -> "Fault | None":
        """Return the latched fault of the running engine."""
        return self.engine.fault if self.engine is not None else None

    def clear_fault(self) -> None:
        """Clear the latched fault; the force fades in again."""
        if self.engine is not None:
            self.engine.clear_fault()

    # the device

    @property
    def engine(self) -> "Engine | None":
        """Return the engine of the current device; None without a device."""
        return self.device.engine

    @property
    def link(self) -> LinkStatus:
        """Return the state of the connection to the current device."""
        return self.device.link

    @property
    def entry(self) -> "DeviceEntry | None":
        """Return the entry of the device list that was opened last."""
        return self.device.entry

    def note_health(self, health: "Health") -> None:
        """Detect the loss of the device, and poll the board's answer."""
        self.device.note_health(health)
        self.board_answer.poll()  # the board may have refused its law

    @property
    def opened(self) -> "Device | None":
        """Return the current device with its capabilities; None without a device."""
        return self.engine.device if self.engine is not None else None

    @property
    def models_handle(self) -> bool:
        """Return whether the handle is simulated, so that its true motion is known and can be set."""
        return self.opened is not None and self.opened.model is not None

    @property
    def hand_is_ours(self) -> bool:
        """Return whether mouse and keys move the hand; on a real board, the user moves the handle."""
        return self.opened is not None and self.opened.simulated_hand

    def zero_here(self) -> None:
        """Make the current position of a real board its zero."""
        if self.engine is not None and not self.why_fixed(*DEVICE):
            self.engine.zero_here()

    def flip_direction(self) -> None:
        """Reverse the positive direction of a real board."""
        if self.engine is not None and not self.why_fixed(*DEVICE):
            self.engine.flip_direction()

    # setting up a new device

    def _configure(self, engine: "Engine") -> None:
        """Apply all choices to an engine that has just started."""
        self.stop_state.stop_if_needed(engine)
        if self.stop_state.waits(engine):
            self.stop()
        engine.set_environment(self.environment, self.permissions.hidden_values or self.values)
        chosen = {key: getattr(self.loop, key) for key in FIELDS}
        if engine.device.own_clock:
            del chosen["rate"]
        where, board_rate = chosen.pop("where"), chosen.pop("board_rate")
        engine.change_loop(chosen)
        engine.prefer(where, board_rate)
