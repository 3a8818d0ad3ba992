"""What the environment in force cannot render well as it is set: one line each, below its parameters."""

import numpy as np
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QHBoxLayout, QLabel, QVBoxLayout, QWidget

from hapkit_studio.environments.base import Conditions
from hapkit_studio.gui.live.history import History
from hapkit_studio.gui.studio import Studio
from hapkit_studio.gui.widgets import icons
from hapkit_studio.gui.widgets.text import plain
from hapkit_studio.gui.widgets.theme import theme

LATELY_SECONDS = 5.0
_SIGN = 16


class WarningLine(QWidget):
    """A triangle and one line of words."""

    def __init__(self, text: str, parent: QWidget | None = None):
        super().__init__(parent)
        self.setObjectName("warning")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.sign, self.words = QLabel(), plain(QLabel(text))
        self.sign.setPixmap(icons.pixmap("triangle", _SIGN, "warn", self.devicePixelRatioF()))
        self.words.setWordWrap(True)
        self.words.setProperty("ink", "warn")
        row = QHBoxLayout(self)
        row.setContentsMargins(8, 6, 8, 6)
        row.setSpacing(8)
        row.addWidget(self.sign, 0, Qt.AlignmentFlag.AlignTop)
        row.addWidget(self.words, 1)
        self.setAccessibleName(f"Warning: {text}")


class WarningLines(QWidget):
    """Asks the environment whenever a value, the loop, the device or the handle's speed has changed."""

    def __init__(self, studio: Studio, parent: QWidget | None = None):
        super().__init__(parent)
        self._studio = studio
        self._speed = 0.0
        self._texts: tuple[str, ...] = ()
        self.lines: list[WarningLine] = []
        self._column = QVBoxLayout(self)
        self._column.setContentsMargins(0, 2, 0, 2)
        self._column.setSpacing(4)
        for signal in (studio.environment_changed, studio.values_changed, studio.loop_changed):
            signal.connect(self.look)
        studio.engine_changed.connect(self.look)
        theme.changed.connect(self._rebuild)
        self._rebuild()
        self.look()

    @property
    def conditions(self) -> Conditions:
        """Return what the scene is rendered with now."""
        period = 1.0 / self._studio.loop.rate
        engine = self._studio.engine
        if engine is None:
            return Conditions(period=period, speed=self._speed)
        device = engine.device
        return Conditions(1.0 / engine.loop.rate, device.quantum, device.viscous, self._speed)

    def watch(self, history: History) -> None:
        """Take the handle's highest speed of late; call it at a few hertz."""
        velocity = history.between(history.now - LATELY_SECONDS, np.inf).y["velocity"]
        self._speed = float(np.nanmax(np.abs(velocity), initial=0.0))
        self.look()

    def look(self) -> None:
        """Ask the environment, and show what it says if that is something else than before."""
        environment = self._studio.environment
        texts = tuple(environment.warnings(self._studio.values, self.conditions))
        if texts != self._texts:
            self._texts = texts
            self._rebuild()

    def _rebuild(self) -> None:
        for line in self.lines:
            self._column.removeWidget(line)
            line.hide()
            line.deleteLater()
        self.lines = [WarningLine(text) for text in self._texts]
        for line in self.lines:
            self._column.addWidget(line)
        self.setVisible(bool(self.lines))
