"""What the person has chosen, and the engine that plays it: the window's only way to the engine."""

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
    """Keeps every choice over a change of device; values are SI and checked before they are kept.

    A facade: ``library`` holds the environments and their values, ``device`` the link to the device in use,
    ``permissions`` what may be changed, ``stop_state`` the E-stop, ``board_answer`` how the board renders,
    ``recording`` the recorder. ``refused``: why an environment or its defaults are not in force.
    """

    environment_changed = Signal()
    values_changed = Signal()
    loop_changed = Signal()
    settings_changed = Signal()
    """Any of these three."""
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
        """When it was put in force, by the rows' clock in s."""
        self.readiness = Readiness(self)
        self.readiness.request_ready.connect(self.choose)
        self.permissions, self.stop_state = Permissions(self), StopState(self)
        self.device = DeviceLink(entries, build, self.stop_state.hold, self._configure, self)
        self.stop_state.device = self.device
        self.recording = Recording(self.device, lambda: self.environment.key, self)
        self.device.engine_changed.connect(self.engine_changed)
        self.device.link_changed.connect(self.link_changed)
        self.loop = USUAL_LOOP
        self.board_answer = BoardAnswer(self.device)
        self.unstable_ranges: Mapping[str, Sequence[tuple[float, float]]] = {}
        """The ranges of each parameter, SI, that are more than the loop can take, as far as is known."""
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

    # what may be changed

    @property
    def hidden(self) -> str:
        """Return why other values are rendered than the window shows, "" if they are the same."""
        return self.permissions.hidden

    @property
    def temporary(self) -> bool:
        """Return whether a measurement changes settings now and takes them back."""
        return self.permissions.temporary

    def temporarily(self) -> AbstractContextManager[None]:
        """Let a measurement change settings or take them back: no person's choice, so nothing to undo."""
        return self.permissions.temporarily()

    def why_fixed(self, *place: str) -> str:
        """Return why the setting at a place cannot be changed now, "" if it can."""
        return self.permissions.why_fixed(*place)

    def check_free(self, places: Iterable[Place]) -> None:
        """Raise ParameterError if one of some settings cannot be changed now."""
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
        """Return the values in force of the environment in force."""
        return self.library.values[self.environment.key]

    def choose(self, key: str) -> None:
        """Switch the environment, or as soon as it is ready; its values are those it was left with."""
        try:
            if key != self.environment.key:
                self.check_free([("environment", key)])
        except ParameterError as error:
            self.refused.emit(str(error))
            return
        if self.readiness.request(key) and key != self.environment.key:
            self._put_in_force(self.environments[key])

    def adopt(self, environment: "Environment") -> None:
        """Take an environment in, or a newer version of it, and put it in force; it is compiled already."""
        self.library.put(environment)
        self.readiness.drop_request()
        self._put_in_force(environment)

    def drop(self, key: str) -> None:
        """Forget an environment; raise KeyError if it is in force."""
        if key == self.environment.key:
            raise KeyError(key)
        self.library.drop(key)

    def _put_in_force(self, environment: "Environment") -> None:
        self.environment, self.environment_since = environment, time.perf_counter()
        self.unstable_ranges = {}
        self.hide_values(None)
        if self.engine is not None:
            self.engine.set_environment(environment, self.values)
        self.environment_changed.emit()
        self.values_changed.emit()

    def set_value(self, key: str, value: float) -> None:
        """Change one parameter; raise ParameterError and keep the last good values if it is bad."""
        self.set_values({key: value})

    def set_values(self, changes: Mapping[str, float]) -> None:
        """Change several parameters at once; raise ParameterError and keep all as they are if one is bad."""
        self._set_values(self.environment.changed(self.values, changes))

    def values_of(self, key: str) -> dict[str, float]:
        """Return the values an environment has, or would be played with."""
        return dict(self.library.values[key])

    def set_values_of(self, key: str, changes: Mapping[str, float]) -> None:
        """Change several parameters of any environment, in force or not; raise ParameterError."""
        if key == self.environment.key:
            self.set_values(changes)
        else:
            numbers = self.environments[key].changed(self.library.values[key], changes)
            self._check_values(key, numbers)
            self.library.values[key].update(numbers)

    def note_ranges(self, unstable_ranges: Mapping[str, Sequence[tuple[float, float]]]) -> None:
        """Take over which values are more than the loop can take, for every slider in the window."""
        self.unstable_ranges = unstable_ranges
        self.ranges_changed.emit()

    def reset_values(self) -> None:
        """Put every parameter of the environment that is free back to its default, all at once."""
        key = self.environment.key
        try:
            locked = {p: v for p, v in self.values.items() if self.why_fixed("value", key, p)}
            self._set_values(self.environment.values(locked))
        except ParameterError as error:  # they do not go with those that are locked
            self.refused.emit(str(error))

    def hide_values(self, values: Mapping[str, float] | None, why: str = BLIND) -> None:
        """Render other values than the window shows and keeps; None renders those again.

        Nothing can be changed meanwhile by a person; a measurement's values or another environment end it.
        Raise ParameterError.
        """
        numbers = None if values is None else self.environment.values(values)
        if numbers is not None and not self.hidden:
            self._check_values(self.environment.key, numbers)
        if not self.permissions.hide(numbers, why):
            return
        if self.engine is not None:
            self.engine.set_environment(self.environment, numbers or self.values)
        self.hidden_changed.emit()

    def _check_values(self, key: str, numbers: Mapping[str, float]) -> None:
        old = self.library.values[key]
        self.check_free(("value", key, name) for name, number in numbers.items() if old[name] != number)

    def _set_values(self, numbers: dict[str, float]) -> None:
        self._check_values(self.environment.key, numbers)
        if self.temporary:
            self.hide_values(None)
        if self.engine is not None:
            self.engine.put_values(self.permissions.hidden_values or numbers)
        self.values.update(numbers)
        self.values_changed.emit()

    # loop and hand

    @property
    def grip(self) -> str:
        """Return how firmly the simulated hand holds."""
        return self.loop.hand

    def set_loop(self, **changes: Any) -> None:
        """Change settings of the loop by their names in LoopSettings; raise ParameterError if refused."""
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
        """Pull the handle towards a place in m; None lets go."""
        if self.engine is not None:
            self.engine.move_hand(target)

    def release_at_rest(self) -> None:
        """Let a simulated handle go where it is, without the speed that it has."""
        if self.engine is not None:
            self.engine.release_at_rest()

    # stopping

    @property
    def stopped(self) -> bool:
        """Return whether the E-stop is latched."""
        return self.stop_state.stopped

    def stop(self) -> None:
        """Set the force to zero at the next tick, whatever else is going on."""
        self.stop_state.stop()

    def release_stop(self) -> None:
        """Release the E-stop; the force fades in."""
        self.stop_state.release()

    @property
    def held(self) -> bool:
        """Return True while a motor waits for *Render*."""
        return self.stop_state.waiting

    @property
    def fault(self) -> "Fault | None":
        """Return the latched fault of the running engine."""
        return self.engine.fault if self.engine is not None else None

    def clear_fault(self) -> None:
        """Unlatch the fault; the force fades in again."""
        if self.engine is not None:
            self.engine.clear_fault()

    # the device

    @property
    def engine(self) -> "Engine | None":
        """Return the engine of the device in use, None while there is none."""
        return self.device.engine

    @property
    def link(self) -> LinkStatus:
        """Return how the device in use is reached."""
        return self.device.link

    @property
    def entry(self) -> "DeviceEntry | None":
        """Return what was opened last, from the list of devices."""
        return self.device.entry

    def note_health(self, health: "Health") -> None:
        """Notice that the device went away, or what its board answers."""
        self.device.note_health(health)
        self.board_answer.poll()  # the board may have refused its law

    @property
    def opened(self) -> "Device | None":
        """Return the device in use and its capabilities, None while there is none."""
        return self.engine.device if self.engine is not None else None

    @property
    def models_handle(self) -> bool:
        """Return whether the loop simulates the handle, so that its true motion is known and can be set."""
        return self.opened is not None and self.opened.model is not None

    @property
    def hand_is_ours(self) -> bool:
        """Return whether mouse and keys are the hand; on a real board a person's is."""
        return self.opened is not None and self.opened.simulated_hand

    def zero_here(self) -> None:
        """Make the present position of a real board its zero."""
        if self.engine is not None and not self.why_fixed(*DEVICE):
            self.engine.zero_here()

    def flip_direction(self) -> None:
        """Turn a real board's positive direction around."""
        if self.engine is not None and not self.why_fixed(*DEVICE):
            self.engine.flip_direction()

    # what the device in use is told

    def _configure(self, engine: "Engine") -> None:
        """Tell a started engine everything that is chosen."""
        self.stop_state.hold(engine)
        if self.stop_state.waits(engine):
            self.stop()
        engine.set_environment(self.environment, self.permissions.hidden_values or self.values)
        chosen = {key: getattr(self.loop, key) for key in FIELDS}
        if engine.device.own_clock:
            del chosen["rate"]
        where, board_rate = chosen.pop("where"), chosen.pop("board_rate")
        engine.change_loop(chosen)
        engine.prefer(where, board_rate)
