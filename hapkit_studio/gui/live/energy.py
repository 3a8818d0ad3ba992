"""A warning in the status bar while a scene gives more energy than it has received."""

import math
import time
from collections.abc import Callable

import numpy as np
from PySide6.QtCore import QObject

from hapkit_studio.gui.live.live import Live
from hapkit_studio.gui.state.lock import LOOP
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.gui.widgets.theme import number

SHOWN_S = 4.0
"""s: the message stays for this time after the last excess."""
# With the passivity controller on, the excess stays near its threshold. If it exceeds this multiple of the
# threshold, the controller cannot compensate it.
BEYOND_CONTROL = 3.0
# The shown number changes only by at least this factor, so that it can be read.
CHANGE = 1.5
_LOWER = "Lower the stiffness, or switch on the passivity controller."
_CANNOT = "The passivity controller already damps as much as it can. Lower the stiffness."


class EnergyWatch(QObject):
    """Detects in the rows that the scene gives excess energy, and shows a message.

    ``calm()`` returns True if the verdict on the scene is "stable"; then friction and the hand absorb the
    energy and no message is shown. ``show(text, tooltip, color, remedy=False)`` shows the message; "" hides
    it.
    """

    def __init__(self, studio: Studio, live: Live, calm: Callable[[], bool], show: Callable[..., object]):
        super().__init__()
        self._studio, self._calm, self._show = studio, calm, show
        self._reported = math.inf  # J: excess energy already reported
        self._before = self._until = self._shown = 0.0
        live.frame.connect(self.on_row)
        live.health.connect(lambda _health: self.refresh())
        for signal in (studio.engine_changed, studio.environment_changed, studio.stop_changed):
            signal.connect(self._forget)
        for signal in (studio.loop_changed, studio.hidden_changed):
            signal.connect(self._forget)

    def on_row(self, _row: np.ndarray, _clamped: bool) -> None:
        """Check one frame for new excess energy."""
        engine = self._studio.engine
        hidden = self._studio.hidden or "energy" in self._studio.permissions.left_out
        if engine is None or self._studio.environment.drives or hidden:
            return
        excess, least = engine.excess
        # ``excess`` keeps its value after the scene has come to rest, so only an increase is reported.
        self._reported = min(self._reported, excess)
        if excess <= self._reported + least * (BEYOND_CONTROL if self._studio.loop.controller else 1.0):
            return
        if not self._until:
            self._before = self._reported
        self._reported, self._until = excess, time.monotonic() + SHOWN_S
        self._report(excess - self._before)

    def refresh(self) -> None:
        """Hide the message SHOWN_S after the last excess."""
        if self._until and time.monotonic() > self._until:
            self._until = self._shown = 0.0
            self._show("")

    def _forget(self) -> None:
        """Discard the reported energy, because it belongs to settings that have changed."""
        self._reported = math.inf
        self._until = self._shown = 0.0
        self._show("")

    def _report(self, given: float) -> None:
        if self._calm() or self._shown / CHANGE < given < self._shown * CHANGE:
            return
        self._shown = given
        text = f"The scene gave you {energy_text(given)} of extra energy"
        if self._studio.loop.controller:
            self._show(text, _CANNOT, "warn")
        else:
            self._show(text, _LOWER, "warn", remedy=not self._studio.why_fixed(*LOOP))


def energy_text(joules: float) -> str:
    """Format an energy in mJ, or in J from 1 J on, with two significant digits."""
    if joules >= 1.0:
        return f"{number(joules, 1)} J"
    millijoules = 1e3 * joules
    return f"{number(millijoules, 2 if millijoules < 1.0 else 1 if millijoules < 10.0 else 0)} mJ"
