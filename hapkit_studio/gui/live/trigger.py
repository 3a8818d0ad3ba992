"""The trigger: the time plots stop at a contact or at a level crossing, and also show some time before it."""

import math
from typing import NamedTuple

import numpy as np
from PySide6.QtCore import QObject, Signal

from hapkit_studio.environments.base import Environment
from hapkit_studio.gui.live.history import Window
from hapkit_studio.gui.live.time_view import TimeView
from hapkit_studio.haptics.signals import BY_NAME
from hapkit_studio.parameters import AnyParameter, Choice, Parameter
from hapkit_studio.quantity import Quantity


class Level(NamedTuple):
    """A signal whose level can be crossed; the level is given in the signal's SI unit or its shown unit."""

    channel: str
    parameter: Parameter

    @property
    def si(self) -> float:
        """Return the size of the parameter's unit in the signal's SI unit."""
        signal = BY_NAME[self.channel]
        return 1.0 if self.parameter.unit == signal.unit else 1.0 / signal.scale


LEVELS = (
    Level("position", Parameter("position", "Position", "m", 0.005, -0.05, 0.05)),
    Level("velocity", Parameter("velocity", "Velocity", "mm/s", 100.0, -2000.0, 2000.0)),
    Level("applied_force", Parameter("force", "Force", "N", -1.0, -5.0, 5.0)),
)
EVENT = Choice("event", "Event", ("contact", *(level.parameter.key for level in LEVELS)))
EDGE = Choice("edge", "Direction of crossing", ("rising", "falling"))
AGAIN = Choice("again", "How often to stop", ("single", "repeated"))
BEFORE = Parameter("before", "Time shown before the event", "%", 20.0, 0.0, 95.0)
PARAMETERS: tuple[AnyParameter, ...] = (EVENT, *(level.parameter for level in LEVELS), EDGE, AGAIN, BEFORE)


def crossings(values: np.ndarray, level: float, rising: bool) -> np.ndarray:
    """Return the indices of the samples (n,) that cross a level upwards, or downwards if not ``rising``."""
    before, now = values[:-1], values[1:]
    crossed = (before < level) & (now >= level) if rising else (before > level) & (now <= level)
    return np.flatnonzero(crossed) + 1


def _has_contact(environment: Environment) -> bool:
    """Return whether the handle can touch a surface or an object that moves by itself."""
    return environment.shades or environment.moves is not None


class Trigger(QObject):
    """Searches new samples for an event and stops the view there.

    In single mode, it stops at the first event after arming. In repeated mode, it searches for the next event
    as soon as the plots show the previous event completely.
    """

    changed = Signal()

    def __init__(self, view: TimeView, parent: QObject | None = None):
        super().__init__(parent)
        self._view = view
        self._from: float | None = None  # s: the search continues from this time
        self._environment: Environment | None = None
        self._event_chosen = False
        self.values = {parameter.key: parameter.default for parameter in PARAMETERS}

    @property
    def armed(self) -> bool:
        """Return whether the trigger waits for an event."""
        return self._from is not None

    @property
    def level(self) -> Level | None:
        """Return the level to be crossed; None if the trigger waits for a contact."""
        index = int(self.values[EVENT.key])
        return LEVELS[index - 1] if index else None

    def _crossed(self, level: Level) -> float:
        return self.values[level.parameter.key] * level.si

    @property
    def _name(self) -> str:
        """Return the event's name for use within a sentence."""
        level = self.level
        if level is None:
            return "contact"
        shown = Quantity(level.parameter)
        value = shown.text(self.values[level.parameter.key] * shown.factor)
        return f"{level.parameter.key} {value} {shown.unit}"

    def set_environment(self, environment: Environment) -> None:
        """Set the environment.

        Unless the user has chosen an event, the trigger waits for a contact if the environment has any,
        otherwise for a position.
        """
        if environment is not self._environment:
            self._environment = environment
            if not self._event_chosen:
                self.values[EVENT.key] = EVENT.check("contact" if _has_contact(environment) else "position")
            self._emit()

    def set_value(self, key: str, value: float) -> None:
        """Set one of the parameters for later events."""
        self._event_chosen |= key == EVENT.key
        self.values[key] = value
        self._emit()

    def arm(self) -> None:
        """Follow live data and wait for the event."""
        self._view.follow()
        self._from = self._now()
        self._emit()

    def disarm(self) -> None:
        """Stop waiting for the event; the plots do not change."""
        self._from = None
        self._emit()

    def toggle(self) -> None:
        """Arm, or disarm if armed."""
        self.disarm() if self.armed else self.arm()

    def refresh(self) -> None:
        """Search new samples for the event; call once per frame."""
        live, view = self._view.live, self._view
        if self._from is None:
            return
        if view.paused:
            self._from = self._now()
            return
        window = live.between(max(self._from, live.begin), math.inf).known()
        found = self._events(window)
        if len(found):
            self._trigger(float(window.x[found[0]]))
        elif len(window.x):
            self._from = float(window.x[-1])

    def _now(self) -> float:
        now = self._view.live.now
        return -math.inf if math.isnan(now) else now

    def _events(self, window: Window) -> np.ndarray:
        level = self.level
        if level is None:
            return crossings((window.y["force"] != 0.0).astype(float), 1.0, rising=True)
        rising = EDGE.text(self.values[EDGE.key]) == "rising"
        return crossings(window.y[level.channel], self._crossed(level), rising)

    def _trigger(self, time: float) -> None:
        before, again = 0.01 * self.values[BEFORE.key], AGAIN.text(self.values[AGAIN.key]) == "repeated"
        self._from = time + (1.0 - before) * self._view.span if again else None
        name = self._name
        self._view.stand(time, before, name[0].upper() + name[1:])
        self._emit()

    def _emit(self) -> None:
        level, scene, text, crossed = self.level, self._environment, "", None
        if self.armed:
            bare = scene is not None and level is None and not _has_contact(scene)
            text = f"There is no contact in {scene.title}" if scene and bare else f"Waiting for {self._name}"
            crossed = level and (level.channel, self._crossed(level))
        self._view.set_waiting(text, crossed)
        self.changed.emit()
