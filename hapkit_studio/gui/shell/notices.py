"""Determines which banners are shown, for example after an E-stop, a fault or a lost connection."""

from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from PySide6.QtCore import QElapsedTimer, QObject, Signal
from PySide6.QtGui import QGuiApplication

from hapkit_studio import lab
from hapkit_studio.errors import ParameterError
from hapkit_studio.gui.live.live import Live
from hapkit_studio.gui.shell.banners import BannerStack, Button, Notice
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.haptics import arrays, rows

if TYPE_CHECKING:
    from hapkit_studio.haptics.health import Fault, Health

_STOP, _FAULT, _DEVICE, _LIMIT = range(4)
NO_DATA_MS = 2000
NO_DELAY_MS = 2000
"""ms: the banner appears if forces were sent for this time without a measured delay."""
STALE_SHOWN_MS = 2000
"""ms: the banner of a silent sensor stays for this time, so that it can be read and does not flicker."""
_STOPPED = (
    "Stopped. Force is zero.",
    "Press Release E-stop when nothing touches the handle.",
    "Release E-stop",
    "danger",
)
_WAITS = (
    "The motor is off until you press Render.",
    "Check scene and values first: they come from your last use of Hapkit Studio, a demo or a lesson.",
    "Render",
    "warn",
)
# headings of sections in assets/docs/troubleshooting.md
_NO_PORT, _NO_FORCE, _BUZZING, _SLOW = "No port", "No force", "Buzzing", "Slow link or computer"
_SECTIONS = {
    arrays.OVER_SPEED: _BUZZING, arrays.RUNAWAY: _SLOW, arrays.SLOW_LAW: _SLOW, arrays.SLOW_LINK: _SLOW,
    arrays.DEVICE_GONE: _NO_PORT,
}  # fmt: skip
_STEPS = {"flash": "Flash firmware", "update": "Update firmware"}


class Notices(QObject):
    """Watches studio and frames, and shows or removes banners.

    ``flash`` is emitted when the user wants to flash the current device. ``help_wanted(section)`` asks the
    window to open the page on troubleshooting.
    """

    flash = Signal()
    help_wanted = Signal(str)

    def __init__(self, studio: Studio, live: Live, banners: BannerStack):
        super().__init__()
        self._studio, self._banners = studio, banners
        self._heard, self._silent, self._stale = False, QElapsedTimer(), QElapsedTimer()
        self._stale_reason = ""
        self._silent.start()
        self._unmeasured = QElapsedTimer()
        sections = (_NO_PORT, _NO_FORCE, _BUZZING, _SLOW)
        self._help = {section: partial(self.help_wanted.emit, section) for section in sections}
        self._simulated: Button = ("Use simulated Hapkit", studio.device.open_simulated)
        studio.engine_changed.connect(self._listen)
        for signal in (studio.stop_changed, studio.engine_changed):
            signal.connect(self.show_stop)
        studio.link_changed.connect(self.show_link)
        studio.engine_changed.connect(self.show_fault)
        live.frame.connect(self.on_row)
        live.health.connect(self.on_health)

    def show_stop(self) -> None:
        """Show or remove the banner of the E-stop, or of a motor that waits for a click on *Render*."""
        title, text, release, tone = _WAITS if self._studio.waits_for_render else _STOPPED
        ways = ((release, self._studio.release_stop),)
        self._show(self._studio.stopped, "stop", _STOP, (title, text), ways, tone, "octagon")

    def on_row(self, row: np.ndarray, _clamped: bool) -> None:
        """Show a fault as soon as a row reports it."""
        self._heard = True
        if int(row[rows.FLAGS]) & rows.FAULT or self._banners.get("fault") is not None:
            self.show_fault()

    def on_health(self, health: "Health") -> None:
        """Show faults, a silent sensor or an unmeasured delay; this also works while no rows arrive."""
        self.show_fault()
        self.show_silence(health)
        self.show_unmeasured(health)
        if health.stale:
            self._stale.start()
            self._stale_reason = health.stale
        recent = self._stale.isValid() and self._stale.elapsed() < STALE_SHOWN_MS
        # before the board's first sample, the banner of show_silence already shows the remedy
        recent = recent and self._banners.get("silence") is None
        silent = recent and self._studio.fault is None and self._studio.link.state == "running"
        texts = (
            f"Fault: {self._stale_reason}.",
            "The force is zero, and comes back by itself when the sensor answers again.",
        )
        self._show(silent, "stale", _FAULT, texts, tone="danger", section=_NO_FORCE)

    def show_fault(self) -> None:
        """Show the latched fault, unless the banner of a disconnected device already explains it."""
        fault: Fault | None = self._studio.fault
        if fault is None or self._studio.link.state == "gone":
            self._banners.set("fault", None)
            return
        slow = fault.code == arrays.SLOW_LINK
        ways = (*(self._board_button() if slow else ()), ("Clear fault", self._studio.clear_fault))
        # the "stale" banner says that the force returns by itself, which is wrong after a fault
        self._banners.set("stale", None)
        section = _SECTIONS.get(fault.code, _NO_FORCE)
        self._show(True, "fault", _FAULT, (fault.text, fault.detail), ways, "danger", section=section)

    def show_silence(self, health: "Health") -> None:
        """Show a banner if a board has answered, but has sent no row since it was opened."""
        link = self._studio.link
        silent = not self._heard and self._silent.elapsed() > NO_DATA_MS and health.running
        texts = (
            f"{link.title} sends no samples.",
            "Force is zero. Press the board's reset button, then try again.",
        )
        ways = (("Try again", self._studio.device.reconnect), self._simulated)
        shown = silent and link.state == "running"
        self._show(shown, "silence", _DEVICE, texts, ways, icon="unplugged", section=_NO_FORCE)

    def show_unmeasured(self, health: "Health") -> None:
        """Show a banner if delay and stability limit are unknown although the computer sends forces."""
        studio = self._studio
        measures = studio.opened is not None and studio.opened.measures_delay
        forces = health.running and self._heard and measures and studio.link.state == "running"
        if not forces or health.delay is not None or studio.stopped or studio.fault is not None:
            self._unmeasured.invalidate()
        elif not self._unmeasured.isValid():
            self._unmeasured.start()
        late = self._unmeasured.isValid() and self._unmeasured.elapsed() > NO_DELAY_MS
        texts = (
            "The delay of the link cannot be measured.",
            "The stability limit is unknown: a contact that feels stable may start to oscillate.",
        )
        self._show(late, "delay", _LIMIT, texts, self._board_button(), section=_SLOW)

    def _show(
        self,
        shown: bool,
        key: str,
        rank: int,
        texts: tuple[str, str],
        ways: tuple[Button, ...] = (),
        tone: str = "warn",
        icon: str = "triangle",
        section: str = "",
    ) -> None:
        """Show or remove a banner; its Help button opens the section of the troubleshooting page."""
        if section:
            ways = (*ways, ("Help", self._help[section]))
        self._banners.set(key, Notice(key, rank, tone, icon, *texts, ways) if shown else None)

    def _board_button(self) -> tuple[Button, ...]:
        """Return a button that moves the law to the board because the link is slow, if this is possible."""
        engine = self._studio.engine
        decision = None if engine is None else engine.decision()
        if decision is None or decision.where == "board" or not decision.plan or decision.refusal:
            return ()
        return (("Render on the board", self._render_on_board),)

    def _render_on_board(self) -> None:
        # the board may refuse after a change of settings; the switch in the panel then shows the reason
        with suppress(ParameterError):
            self._studio.set_loop(where="board")

    def _listen(self) -> None:
        """Wait for the first row of a new engine, and remove the banners of the previous engine."""
        self._heard = False
        self._silent.restart()
        self._stale.invalidate()
        self._unmeasured.invalidate()
        for key in ("silence", "stale", "delay"):
            self._banners.set(key, None)

    def show_link(self) -> None:
        """Show why no device is connected, with buttons for the remedies and for the simulated device."""
        link = self._studio.link
        title, _, rest = link.text.partition(". ")
        ways: list[Button] = []
        if link.state == "failed":
            if link.step in _STEPS:
                ways.append((_STEPS[link.step], self.flash.emit))
            if link.command:
                ways.append(("Copy command", lambda: QGuiApplication.clipboard().setText(link.command)))
            if not lab.settings().mistake:
                ways.append(("Try again", self._studio.device.reconnect))
        texts = (f"{title.rstrip('.')}.", rest or "Force is zero.")
        away = link.state in ("gone", "failed")
        section = _NO_PORT
        if lab.settings().mistake:  # the simulated device does not start, either
            section = ""
        else:
            ways.append(self._simulated)
        self._show(away, "device", _DEVICE, texts, tuple(ways), icon="unplugged", section=section)
