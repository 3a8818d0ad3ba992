"""The passivity alarm: says that the scene gives energy, how much, and what to do about it."""

import time

import numpy as np
from PySide6.QtCore import QObject

from hapkit_studio.gui.banners import BannerStack, Notice
from hapkit_studio.gui.live import Live
from hapkit_studio.gui.studio import Studio
from hapkit_studio.gui.theme import number
from hapkit_studio.haptics import rows

RANK = 4
HOLD_S = 2.0
# While the controller damps, the excess stands about its threshold; this many times it means the end of it.
BEYOND_CONTROL = 3.0
# The number stays while it would change by less than this, so that the banner stands still.
CHANGE = 1.5
_LOWER = "Lower stiffness, or switch on the passivity controller."
_CANNOT = "The passivity controller damps as much as it may. Lower stiffness."


class Passivity(QObject):
    """Watches the rows for an excess of energy and keeps one banner up while there is any."""

    def __init__(self, studio: Studio, live: Live, banners: BannerStack):
        super().__init__()
        self._studio, self._banners = studio, banners
        self._until = self._shown = 0.0
        live.frame.connect(self.look_at_row)
        live.health.connect(lambda _health: self.look())
        for signal in (studio.engine_changed, studio.environment_changed, studio.stop_changed):
            signal.connect(self.take_down)
        studio.loop_changed.connect(self.take_down)

    def look_at_row(self, row: np.ndarray, _clamped: bool) -> None:
        """Put the banner up in the frame the alarm is raised in; it stays long enough to be read."""
        if int(row[rows.FLAGS]) & rows.ACTIVE and not self._studio.environment.drives:
            self._raise()

    def look(self) -> None:
        """Take the banner down once the alarm is over."""
        if self._until and time.monotonic() > self._until:
            self.take_down()

    def take_down(self) -> None:
        """Forget the alarm: what gave energy is no more."""
        self._until = self._shown = 0.0
        self._banners.set("energy", None)

    def _raise(self) -> None:
        engine = self._studio.engine
        if engine is None:
            return
        excess, least = engine.excess
        controlled = self._studio.loop.controller
        if excess <= (BEYOND_CONTROL * least if controlled else 0.0):
            return
        self._until = time.monotonic() + HOLD_S
        if self._shown / CHANGE < excess < self._shown * CHANGE:
            return
        self._shown = excess
        title = f"Gives energy: {amount(excess)} more than it took."
        on = ("Switch it on", self._switch_on)
        notice = Notice(
            "energy", RANK, "warn", "triangle", title, _CANNOT if controlled else _LOWER,
            () if controlled else (on,),
        )  # fmt: skip
        self._banners.set("energy", notice)

    def _switch_on(self) -> None:
        self._studio.set_loop(controller=True)


def amount(joules: float) -> str:
    """Write an energy in mJ, or J from one on, with two digits that count."""
    if joules >= 1.0:
        return f"{number(joules, 1)} J"
    millijoules = 1e3 * joules
    return f"{number(millijoules, 2 if millijoules < 1.0 else 1 if millijoules < 10.0 else 0)} mJ"
