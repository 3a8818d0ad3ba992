"""The trigger: the time plots stand at contact, or where a level is crossed, with time before it."""

import math
from typing import NamedTuple

import numpy as np
from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QPushButton, QWidget

from hapkit_studio.environments.base import Environment
from hapkit_studio.gui.dialogs import FormDialog
from hapkit_studio.gui.live.history import Window
from hapkit_studio.gui.live.time_view import TimeView
from hapkit_studio.gui.panel.rows import row_of
from hapkit_studio.gui.widgets.numbers import Quantity
from hapkit_studio.parameters import Choice, Parameter


class Level(NamedTuple):
    """A level that may be crossed: of which channel, declared in the plots' unit, which is so many SI."""

    channel: str
    parameter: Parameter
    si: float


LEVELS = (
    Level("position", Parameter("position", "Position", "m", 0.005, -0.05, 0.05), 1.0),
    Level("velocity", Parameter("velocity", "Velocity", "mm/s", 100.0, -2000.0, 2000.0), 1e-3),
    Level("applied", Parameter("force", "Force", "N", -1.0, -5.0, 5.0), 1.0),
)
EVENT = Choice("event", "Stand when", ("contact", *(level.parameter.key for level in LEVELS)))
EDGE = Choice("edge", "Crosses it", ("rising", "falling"))
AGAIN = Choice("again", "Then", ("single", "repeated"))
BEFORE = Parameter("before", "Of the time shown, before it", "%", 20.0, 0.0, 95.0)
PARAMETERS = (EVENT, *(level.parameter for level in LEVELS), EDGE, AGAIN, BEFORE)
_ABOUT = (
    "The time plots stand with the event in sight; scene, loop and recording go on. Backspace: back to live."
)


def crossings(values: np.ndarray, level: float, rising: bool) -> np.ndarray:
    """Return the indices of samples (n,) that reach a level from below, or from above if not rising."""
    before, now = values[:-1], values[1:]
    crossed = (before < level) & (now >= level) if rising else (before > level) & (now <= level)
    return np.flatnonzero(crossed) + 1


class Trigger(QObject):
    """Looks for its event in what comes, and lets the view of the history stand there.

    Single: the first event after it was armed. Repeated: each one that comes once the picture is complete.
    """

    changed = Signal()

    def __init__(self, view: TimeView, parent: QObject | None = None):
        super().__init__(parent)
        self._view = view
        self._from: float | None = None  # s: where to look next
        self._has_contact, self._where = True, ""
        self.values = {parameter.key: parameter.default for parameter in PARAMETERS}

    @property
    def armed(self) -> bool:
        """Say whether it waits for an event."""
        return self._from is not None

    @property
    def level(self) -> Level | None:
        """Return what is to be crossed; None: contact is waited for."""
        index = int(self.values[EVENT.key])
        return LEVELS[index - 1] if index else None

    @property
    def name(self) -> str:
        """Name the event."""
        level = self.level
        if level is None:
            return "Contact"
        shown = Quantity(level.parameter)
        value = shown.text(self.values[level.parameter.key] * shown.factor)
        return f"{level.parameter.label} {value} {shown.unit}"

    def set_environment(self, environment: Environment) -> None:
        """Take over whether there is anything to be touched."""
        self._has_contact, self._where = environment.shades, environment.title
        self._tell()

    def set_value(self, key: str, value: float) -> None:
        """Set one of its parameters, for what comes."""
        self.values[key] = value
        self._tell()

    def arm(self) -> None:
        """Show what comes, and wait for the event."""
        self._view.follow()
        self._from = self._now()
        self._tell()

    def disarm(self) -> None:
        """Wait no longer; the picture stays as it is."""
        self._from = None
        self._tell()

    def toggle(self) -> None:
        """Arm, or wait no longer."""
        self.disarm() if self.armed else self.arm()

    def look(self) -> None:
        """Look for the event in what came; call once per frame."""
        live, view = self._view.live, self._view
        if self._from is None:
            return
        if view.paused:
            self._from = self._now()
            return
        window = live.between(max(self._from, live.begin), math.inf).known()
        found = self._events(window)
        if len(found):
            self._take(float(window.x[found[0]]))
        elif len(window.x):
            self._from = float(window.x[-1])

    def _now(self) -> float:
        now = self._view.live.now
        return -math.inf if math.isnan(now) else now

    def _events(self, window: Window) -> np.ndarray:
        level = self.level
        if level is None:
            return crossings((window.y["asked"] != 0.0).astype(float), 1.0, rising=True)
        reached = self.values[level.parameter.key] * level.si
        return crossings(window.y[level.channel], reached, EDGE.text(self.values[EDGE.key]) == "rising")

    def _take(self, time: float) -> None:
        before, again = 0.01 * self.values[BEFORE.key], AGAIN.text(self.values[AGAIN.key]) == "repeated"
        self._from = time + (1.0 - before) * self._view.span if again else None
        self._view.stand(time, before, self.name)
        self._tell()

    def _tell(self) -> None:
        missing = self.level is None and not self._has_contact
        waits = f"No contact in {self._where}" if missing else f"Waiting for {self.name.lower()}"
        self._view.set_waiting(waits if self.armed else "")
        self.changed.emit()


class TriggerDialog(FormDialog):
    """Sets the trigger; what is set holds at once."""

    def __init__(self, trigger: Trigger, parent: QWidget | None = None):
        super().__init__("Trigger", _ABOUT, parent)
        self._trigger = trigger
        self.rows = {parameter.key: row_of(parameter) for parameter in PARAMETERS}
        for key, row in self.rows.items():
            row.show_value(trigger.values[key])
            row.changed.connect(trigger.set_value)
            self.column.addWidget(row)
        self.arm = QPushButton()
        self.arm.clicked.connect(trigger.toggle)
        self.add_buttons(self.arm)
        trigger.changed.connect(self._follow)
        self._follow()

    def _follow(self) -> None:
        level = self._trigger.level
        for each in LEVELS:
            self.rows[each.parameter.key].setVisible(each is level)
        self.rows[EDGE.key].setVisible(level is not None)
        self.arm.setText("Wait no longer" if self._trigger.armed else "Arm")
