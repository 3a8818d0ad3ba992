"""The device list in the header: what is connected, and what else could be."""

from PySide6.QtCore import QPointF, QSize, Qt
from PySide6.QtGui import QAction, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QHBoxLayout, QLabel, QMenu, QPushButton, QWidget

from hapkit_studio.devices.hapkit import PACKET
from hapkit_studio.gui import icons
from hapkit_studio.gui.studio import Studio
from hapkit_studio.gui.theme import theme

_DOT = {"running": "ok", "failed": "danger"}  # warn else
_WORDS = {
    "preparing": "Preparing…",
    "connecting": "Connecting…",
    "idle": "Not connected",
    "gone": "{} is gone",
    "failed": "No device",
}
_FRAMES = (("As short as they are", 0), ("Filled to whole USB packets", PACKET))


class StateDot(QWidget):
    """A small disc, filled while the device is there, hollow while it is not."""

    def __init__(self, parent: QWidget | None = None):
        super().__init__(parent)
        self.setFixedSize(12, 12)
        self.token, self.filled = "warn", False

    def show_state(self, token: str, filled: bool) -> None:
        """Show a colour token, filled or hollow."""
        self.token, self.filled = token, filled
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        color = theme.color(self.token)
        painter.setPen(QPen(color, 1.6))
        painter.setBrush(color if self.filled else Qt.BrushStyle.NoBrush)
        painter.drawEllipse(QPointF(6, 6), 4, 4)


class DeviceList(QPushButton):
    """Shows the device in use; its menu is read anew at every opening."""

    def __init__(self, studio: Studio, parent: QWidget | None = None):
        super().__init__(parent)
        self._studio = studio
        self.setProperty("tall", True)
        self.setFixedHeight(34)
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.dot, self.word, self._arrow = StateDot(), QLabel(), QLabel()
        self._row = row = QHBoxLayout(self)
        row.setContentsMargins(10, 0, 10, 0)
        row.setSpacing(8)
        row.addWidget(self.dot)
        row.addWidget(self.word, 1)
        row.addWidget(self._arrow)
        for part in (self.dot, self.word, self._arrow):
            part.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.menu_of_devices = QMenu(self)
        self.menu_of_devices.aboutToShow.connect(lambda: fill_menu(self.menu_of_devices, studio))
        self.menu_of_devices.aboutToHide.connect(self._forget_pointer)
        self.clicked.connect(self._open_menu)
        studio.link_changed.connect(self.show_state)
        theme.changed.connect(self.show_state)
        self.show_state()

    def show_state(self) -> None:
        """Show dot and words for the state of the link."""
        link = self._studio.link
        words = _WORDS.get(link.state, "{}").format(link.title.partition(": ")[0])
        if link.state in ("connecting", "idle") and link.text:
            words = link.text  # what it waits for, who has it
        self.word.setText(words)
        self.setToolTip(link.text or "Choose a device")
        self.setAccessibleName(f"Device: {words}")
        self.dot.show_state(_DOT.get(link.state, "warn"), link.state == "running")
        self._arrow.setPixmap(icons.pixmap("chevron_down", 16, "ink2", self.devicePixelRatioF()))
        self.updateGeometry()

    def sizeHint(self) -> QSize:
        return QSize(max(180, self._row.sizeHint().width() + 4), 34)

    def minimumSizeHint(self) -> QSize:
        return self.sizeHint()

    def _forget_pointer(self) -> None:
        """Look as if the pointer had left: while the menu had it, nobody said so."""
        self.setAttribute(Qt.WidgetAttribute.WA_UnderMouse, False)
        self.update()

    def _open_menu(self) -> None:
        self.menu_of_devices.popup(self.mapToGlobal(self.rect().bottomLeft()))


def fill_menu(menu: QMenu, studio: Studio) -> None:
    """Fill a menu with every device there is now, the one in use marked."""
    menu.clear()
    device = studio.engine.device if studio.engine is not None else None
    own = studio.entry.key if studio.entry is not None else ""
    here = getattr(device, "port", own)  # a board that came back may have another port than its entry says
    for entry in studio.entries():
        action = QAction(entry.title, menu)
        action.setCheckable(True)
        action.setChecked(entry.key == (here if "/" in own or own.startswith("COM") else own))
        action.triggered.connect(lambda _on=False, entry=entry: studio.open(entry))
        menu.addAction(action)


def fill_frames_menu(menu: QMenu, studio: Studio) -> None:
    """Fill a menu with how a board fills its frames; the embedded device sends none."""
    menu.clear()
    device = studio.engine.device if studio.engine is not None else None
    for words, size in _FRAMES:
        action = QAction(words, menu)
        action.setCheckable(True)
        action.setChecked(studio.padding == size)
        action.setEnabled(hasattr(device, "padding"))
        action.triggered.connect(lambda _on=False, size=size: studio.set_padding(size))
        menu.addAction(action)
