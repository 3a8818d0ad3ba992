"""What the status bar says while a scene gives more energy than it took."""

import math
import time
from collections.abc import Callable

import numpy as np
from PySide6.QtCore import QObject

from hapkit_studio.gui.live.live import Live
from hapkit_studio.gui.state.lock import LOOP
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.gui.widgets.theme import number

HOLD_S = 4.0
"""So long after the last of it what was given can be read."""
# While the controller damps, the excess stands about its threshold; this many times it means the end of it.
BEYOND_CONTROL = 3.0
# The number stays while it would change by less than this, so that it can be read.
CHANGE = 1.5
_LOWER = "Lower the stiffness, or switch on the passivity controller."
_CANNOT = "The passivity controller already damps as much as it can. Lower the stiffness."


class EnergyWatch(QObject):
    """Watches the rows for energy that a scene gives in excess, and says so until a while after the last.

    calm: returns True if the verdict on the scene is "stable"; then friction and the hand absorb the energy,
    and no message is shown. show(words, tooltip, color, remedy=False): shows the message, nothing for "".
    """

    def __init__(self, studio: Studio, live: Live, calm: Callable[[], bool], show: Callable[..., object]):
        super().__init__()
        self._studio, self._calm, self._show = studio, calm, show
        self._told = math.inf  # of the excess in J: so much has been said of
        self._before = self._until = self._shown = 0.0
        live.frame.connect(self.on_row)
        live.health.connect(lambda _health: self.refresh())
        for signal in (studio.engine_changed, studio.environment_changed, studio.stop_changed):
            signal.connect(self._forget)
        for signal in (studio.loop_changed, studio.hidden_changed):
            signal.connect(self._forget)

    def on_row(self, _row: np.ndarray, _clamped: bool) -> None:
        """Say what is given in the frame it is given in."""
        engine = self._studio.engine
        if engine is None or self._studio.environment.drives or self._studio.hidden:
            return
        excess, least = engine.excess
        self._told = min(self._told, excess)  # what was given once stays an excess, long after all is at rest
        if excess <= self._told + least * (BEYOND_CONTROL if self._studio.loop.controller else 1.0):
            return
        if not self._until:
            self._before = self._told
        self._told, self._until = excess, time.monotonic() + HOLD_S
        self._say(excess - self._before)

    def refresh(self) -> None:
        """Say nothing any more a while after the last."""
        if self._until and time.monotonic() > self._until:
            self._until = self._shown = 0.0
            self._show("")

    def _forget(self) -> None:
        """Begin anew: what gave energy is no more."""
        self._told = math.inf
        self._until = self._shown = 0.0
        self._show("")

    def _say(self, given: float) -> None:
        if self._calm() or self._shown / CHANGE < given < self._shown * CHANGE:
            return
        self._shown = given
        words = f"The scene gave you {energy_words(given)} more than you put in"
        if self._studio.loop.controller:
            self._show(words, _CANNOT, "warn")
        else:
            self._show(words, _LOWER, "warn", remedy=not self._studio.why_fixed(*LOOP))


def energy_words(joules: float) -> str:
    """Write an energy in mJ, or J from one on, with two digits that count."""
    if joules >= 1.0:
        return f"{number(joules, 1)} J"
    millijoules = 1e3 * joules
    return f"{number(millijoules, 2 if millijoules < 1.0 else 1 if millijoules < 10.0 else 0)} mJ"
