"""The header: device list, views, Pause, and the E-stop at the far right, in every view the same."""

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtWidgets import QHBoxLayout, QTabBar, QWidget

from hapkit_studio.gui.cap_button import CapButton
from hapkit_studio.gui.device_list import DeviceList
from hapkit_studio.gui.dress import mark
from hapkit_studio.gui.gallery import WIDE
from hapkit_studio.gui.studio import Studio

HEIGHT = 52
_ROOM_FOR_CAPS = 1300


class StopButton(CapButton):
    """Stops on the press, not on the release of the button; pressed again it does nothing."""

    word_style = "font-size: 15px; font-weight: 700;"
    _wide = 120

    def __init__(self, studio: Studio, parent: QWidget | None = None):
        super().__init__("octagon", "E-STOP", "Esc", 40, parent)
        self._studio = studio
        self.setProperty("stop", True)
        self.setAccessibleName("E-stop")
        self._row.insertStretch(0)
        self._row.addStretch()
        self._wide = self.sizeHint().width()
        self.setFixedWidth(self._wide)
        self.pressed.connect(studio.stop)
        self.clicked.connect(studio.stop)
        studio.stop_changed.connect(self.show_state)
        self.show_state()

    def sizeHint(self) -> QSize:
        """Ask for the same room stopped or not: what stands beside it stays where it is."""
        own = super().sizeHint()
        return QSize(max(self._wide, own.width()), own.height())

    def show_state(self) -> None:
        """Show red while the force may act, hollow once stopped."""
        stopped = self._studio.stopped
        mark(self, "latched", stopped)
        self.set_look(
            "octagon", "STOPPED" if stopped else "E-STOP", "danger" if stopped else "onstop", "onstop"
        )
        self.set_cap(not stopped)
        words = "Stopped. Release in the line below." if stopped else "Force to zero at the next tick (Esc)"
        self.setToolTip(words)


class Header(QWidget):
    """Emits ``pause_pressed`` and ``panel_pressed``; the rest goes to the studio."""

    pause_pressed = Signal()
    panel_pressed = Signal()

    def __init__(self, studio: Studio, parent: QWidget | None = None):
        super().__init__(parent)
        self.setObjectName("header")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.setFixedHeight(HEIGHT)
        self.devices = DeviceList(studio)
        self.devices.setMinimumWidth(WIDE - 24)
        self.tabs = QTabBar()
        self.tabs.addTab("Live")
        self.tabs.setDrawBase(False)
        self.tabs.setExpanding(False)
        self.tabs.setUsesScrollButtons(True)
        self.tabs.setElideMode(Qt.TextElideMode.ElideNone)
        self.tabs.setAccessibleName("Views")
        self.pause = CapButton("pause", "Pause", "Space")
        self.pause.setAccessibleName("Pause the plots")
        self.pause.setToolTip("Hold the plots still; the record goes on (Space)")
        self.pause.clicked.connect(self.pause_pressed)
        self.panel = CapButton("sidebar", "Panel", "F4")
        self.panel.setToolTip("Parameters, loop, stability (F4)")
        self.panel.clicked.connect(self.panel_pressed)
        self.panel.hide()
        self.stop = StopButton(studio)
        row = QHBoxLayout(self)
        row.setContentsMargins(12, 0, 12, 0)
        row.setSpacing(12)
        row.addWidget(self.devices)
        row.addWidget(self.tabs, 1, Qt.AlignmentFlag.AlignBottom)
        row.addWidget(self.panel)
        row.addWidget(self.pause)
        row.addSpacing(4)
        row.addWidget(self.stop)

    def show_paused(self, paused: bool) -> None:
        """Offer Resume while the plots are held."""
        mark(self.pause, "resume", paused)
        self.pause.set_look(*(("play", "Resume", "accent") if paused else ("pause", "Pause", "ink")))
        self.pause.setAccessibleName("Resume the plots" if paused else "Pause the plots")

    def resizeEvent(self, event) -> None:
        for button in (self.pause, self.panel):
            button.set_cap(self.width() >= _ROOM_FOR_CAPS)
        super().resizeEvent(event)
