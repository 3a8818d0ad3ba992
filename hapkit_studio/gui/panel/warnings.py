"""What the environment in force cannot render well as it is set: one line each, below its parameters."""

import numpy as np
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QWidget

from hapkit_studio.environments.base import Conditions
from hapkit_studio.gui.live.history import History
from hapkit_studio.gui.studio import Studio
from hapkit_studio.gui.widgets.parts import Sign, across, down, label, refill

LATELY_SECONDS = 5.0


class WarningLine(QWidget):
    """A triangle and one line of words."""

    def __init__(self, text: str):
        super().__init__()
        self.setObjectName("warning")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.words, sign = label(text), Sign(16, "triangle", "warn")
        self.words.setProperty("ink", "warn")
        sign.setAlignment(Qt.AlignmentFlag.AlignTop)
        across(sign, (self.words, 1), into=self, margins=(8, 6, 8, 6))
        self.setAccessibleName(f"Warning: {text}")


class WarningLines(QWidget):
    """Asks the environment whenever a value, the loop, the device or the handle's speed has changed."""

    def __init__(self, studio: Studio):
        super().__init__()
        self._studio = studio
        self._speed = 0.0
        self.texts: list[str] = []
        self._column = down(into=self, margins=(0, 2, 0, 2), gap=4)
        self.hide()
        for signal in (
            studio.environment_changed, studio.values_changed, studio.loop_changed, studio.engine_changed,
        ):  # fmt: skip
            signal.connect(self.look)
        self.look()

    @property
    def conditions(self) -> Conditions:
        """Return what the scene is rendered with now."""
        engine = self._studio.engine
        if engine is None:
            return Conditions(period=1.0 / self._studio.loop.rate, speed=self._speed)
        device = engine.device
        return Conditions(1.0 / engine.loop.rate, device.quantum, device.viscous, self._speed)

    def watch(self, history: History) -> None:
        """Take the handle's highest speed of late; call it at a few hertz."""
        velocity = history.between(history.now - LATELY_SECONDS, np.inf).y["velocity"]
        self._speed = float(np.nanmax(np.abs(velocity), initial=0.0))
        self.look()

    def look(self) -> None:
        """Ask the environment, and show what it says if that is something else than before."""
        texts = list(self._studio.environment.warnings(self._studio.values, self.conditions))
        if texts != self.texts:
            self.texts = texts
            refill(self._column, map(WarningLine, texts))
            self.setVisible(bool(texts))
