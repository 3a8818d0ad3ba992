"""The header: device list, views, Pause, Record, and the E-stop at the far right. All views share it."""

from PySide6.QtCore import QEvent, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QAction, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QLabel, QMenu, QPushButton, QWidget

from hapkit_studio.devices.serial_ports import is_path
from hapkit_studio.gui.panel.stop_button import StopButton
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.gui.widgets import breakpoints, icons
from hapkit_studio.gui.widgets.parts import hbox
from hapkit_studio.gui.widgets.shortcut_button import ShortcutButton
from hapkit_studio.gui.widgets.style import mark
from hapkit_studio.gui.widgets.tabs import Tabs
from hapkit_studio.gui.widgets.theme import theme

_DOT = {"running": "ok", "failed": "danger"}  # colour token by the link's state; other states use "warn"
_GAP, _GAP_COMPACT = 12, 7  # px: between the parts and at both ends; the E-stop has 4 px more
_WORDS = {
    "preparing": "Preparing…",
    "connecting": "Connecting…",
    "idle": "Not connected",
    "gone": "{} disconnected",
    "failed": "No device",
}


class StateDot(QWidget):
    """A small disc: filled while the device is connected, otherwise hollow."""

    def __init__(self, parent: QWidget | None = None):
        super().__init__(parent)
        self.token, self.filled = "warn", False

    def show_state(self, token: str, filled: bool) -> None:
        """Show the disc in a token's colour, filled or hollow."""
        self.token, self.filled = token, filled
        self.update()

    def sizeHint(self) -> QSize:
        return QSize(1, 1) * theme.px(12)

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        color, middle = theme.color(self.token), QRectF(self.rect()).center()
        painter.setPen(QPen(color, 1.6))
        painter.setBrush(color if self.filled else Qt.BrushStyle.NoBrush)
        painter.drawEllipse(middle, theme.px(4), theme.px(4))


class DeviceList(QPushButton):
    """Shows the device in use; its menu is refilled each time it opens."""

    def __init__(self, studio: Studio, parent: QWidget | None = None):
        super().__init__(parent)
        self._studio = studio
        self.setProperty("tall", True)
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.dot, self.word, self._arrow = StateDot(), QLabel(), QLabel()
        self._row = hbox(self.dot, (self.word, 1), self._arrow, into=self, margins=(10, 0, 10, 0))
        for part in (self.dot, self.word, self._arrow):
            part.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.menu_of_devices = QMenu(self)
        self.menu_of_devices.aboutToShow.connect(lambda: fill_menu(self.menu_of_devices, studio))
        # Qt sends no leave event while a menu is open, so the button would stay highlighted
        self.menu_of_devices.aboutToHide.connect(
            lambda: self.setAttribute(Qt.WidgetAttribute.WA_UnderMouse, False)
        )
        self.menu_of_devices.aboutToHide.connect(self.update)
        self.clicked.connect(lambda: self.menu_of_devices.popup(self.mapToGlobal(self.rect().bottomLeft())))
        studio.link_changed.connect(self.show_state)
        theme.changed.connect(self.show_state)
        self.show_state()

    def show_state(self) -> None:
        """Show the state of the link."""
        link = self._studio.link
        text = _WORDS.get(link.state, "{}").format(link.title.partition(": ")[0])
        if link.state in ("connecting", "idle") and link.text:
            text = link.text  # the text gives the reason for waiting, or the program that uses the port
        self.word.setText(text)
        self.setToolTip(link.text or "Choose a device")
        self.setAccessibleName(f"Device: {text}")
        self.dot.show_state(_DOT.get(link.state, "warn"), link.state == "running")
        self._arrow.setPixmap(icons.pixmap("chevron_down", theme.px(16), "ink2", self.devicePixelRatioF()))
        self.updateGeometry()

    def sizeHint(self) -> QSize:
        return QSize(max(theme.px(180), self._row.sizeHint().width() + 4), super().sizeHint().height())

    def minimumSizeHint(self) -> QSize:
        return self.sizeHint()


def fill_menu(menu: QMenu, studio: Studio) -> None:
    """Fill a menu with all connected devices; the device in use is checked."""
    menu.clear()
    own = studio.entry.key if studio.entry is not None else ""
    if is_path(own) and studio.opened is not None:  # a board that was reconnected may have a different port
        own = studio.opened.port
    for entry in studio.device.entries():
        action = QAction(entry.title, menu, checkable=True, checked=entry.key == own)
        action.triggered.connect(lambda _on=False, entry=entry: studio.device.open(entry))
        menu.addAction(action)


class Header(QWidget):
    """Shows the device, the views and the buttons.

    ``pause_pressed``, ``record_pressed`` and ``panel_pressed`` are emitted for three buttons; the studio
    handles the others.
    """

    pause_pressed = Signal()
    record_pressed = Signal()
    panel_pressed = Signal()

    def __init__(self, studio: Studio, parent: QWidget | None = None):
        super().__init__(parent)
        self.setObjectName("header")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.devices = DeviceList(studio)
        self.tabs = Tabs()
        self.tabs.setAccessibleName("Views")
        self.tabs.addTab("Live")
        self.pause = ShortcutButton("pause", "Pause", "Space")
        self.pause.setAccessibleName("Pause the picture")
        self.pause.setToolTip("Freeze the picture while the force continues (Space)")
        self.pause.clicked.connect(self.pause_pressed)
        self.record = ShortcutButton("record", "Record", "R")
        self.record.setToolTip("Record everything from the device into a new session (R)")
        self.record.clicked.connect(self.record_pressed)
        self._recording: tuple = ()
        self.panel = ShortcutButton("sidebar", "Panel", "F4")
        self.panel.setToolTip("Show or hide the panel with parameters, loop and stability (F4)")
        self.panel.clicked.connect(self.panel_pressed)
        self.panel.hide()
        self.stop = StopButton(studio)
        parts = (self.devices, (self.tabs, 1), self.panel, self.pause, self.record, 4, self.stop)
        self._row = hbox(*parts, into=self, margins=(_GAP, 0, _GAP, 0), gap=_GAP)
        self._row.setAlignment(self.tabs, Qt.AlignmentFlag.AlignBottom)
        self._projected: tuple[QWidget, ...] = ()
        self._on_projector = False

    def add_projector_parts(self, title: QWidget, leave: QWidget) -> None:
        """Add the widgets that a projector shows in place of device, views and Record.

        They are hidden by default.
        """
        row = self._row
        row.insertWidget(0, title, 1)
        row.insertWidget(row.count() - 2, leave)
        self._projected = title, leave
        self.project(False)

    def project(self, on: bool) -> None:
        """Switch between the projector's header and the usual one."""
        self._on_projector = on
        mark(self, "projected", on)
        for part in self._projected:
            part.setVisible(on)
        for part in (self.devices, self.tabs, self.record):
            part.setHidden(on)

    def show_paused(self, paused: bool) -> None:
        """Show Resume in place of Pause while the plots are paused."""
        mark(self.pause, "resume", paused)
        self.pause.set_appearance(*(("play", "Resume", "accent") if paused else ("pause", "Pause", "ink")))
        self.pause.setAccessibleName("Resume the picture" if paused else "Pause the picture")

    def show_recording(self, time: str, possible: bool = True) -> None:
        """Show Stop with the recording's duration, or Record if ``time`` is empty."""
        state = time, possible, self._compact
        if state == self._recording:
            return
        self._recording = state
        mark(self.record, "recording", bool(time))
        usual = "Record", "ink" if possible else "ink3"
        stop = "Stop" if self._compact else f"Stop {time}"
        self.record.set_appearance("record", *((stop, "danger") if time else usual))
        self._show_caps()
        self.record.setEnabled(possible)
        self.record.setAccessibleName("Stop recording" if time else "Record")

    @property
    def _compact(self) -> bool:
        return not self._on_projector and self.width() < theme.px(breakpoints.HEADER_ICONS)

    @property
    def _wide(self) -> bool:
        return self._on_projector or self.width() >= theme.px(breakpoints.KEY_CAPS)

    @property
    def _has_caps(self) -> bool:
        """Return True if the key caps fit beside all tabs."""
        buttons = [] if self._on_projector else [self.pause, self.record]
        hidden = sum(b.cap_width for b in buttons if b.cap.isHidden() and not b.property("recording"))
        return self._wide and (self._on_projector or self._row.sizeHint().width() + hidden <= self.width())

    def event(self, event: QEvent) -> bool:
        """Show or hide the key caps after a tab or a button has changed its width."""
        done = super().event(event)
        if event.type() == QEvent.Type.LayoutRequest:
            self._show_caps()
        return done

    def _show_caps(self) -> None:
        has_caps = self._has_caps
        for button in (self.pause, self.record, self.panel):
            shown = has_caps and not button.property("recording")
            if button.cap.isHidden() == shown:
                button.set_cap(shown)

    def resizeEvent(self, event) -> None:
        self.devices.setMinimumWidth(theme.px(breakpoints.GALLERY) - 24 if self._wide else 0)
        mark(self.tabs, "compact", not self._wide)
        self.tabs.updateGeometry()  # the style changes the tabs' width without a notification
        gap = _GAP_COMPACT if self._compact else _GAP
        self._row.setSpacing(gap)
        self._row.setContentsMargins(gap, 0, gap, 0)
        for button in (self.pause, self.record, self.panel):
            button.picture.setHidden(self._compact)
        self._show_caps()
        super().resizeEvent(event)
