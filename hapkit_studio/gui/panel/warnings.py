"""Warnings above the verdict: they name effects that the current environment cannot render well."""

import re

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QWidget

from hapkit_studio.environments.base import Conditions
from hapkit_studio.gui.panel.limits import LoopFacts
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.gui.widgets.parts import Sign, hbox, hint, refill, vbox
from hapkit_studio.gui.widgets.text import tip
from hapkit_studio.workshop.own import switched_off


class WarningLine(QWidget):
    """Shows a triangle and the first sentence of a warning; the tooltip shows the whole warning."""

    def __init__(self, text: str):
        super().__init__()
        self.setObjectName("warning")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        first, *more = re.split(r"[.:;] ", text, maxsplit=1)
        self.label, sign = hint(f"{first} …" if more else text), Sign(16, "triangle", "warn")
        self.setToolTip(tip((text,), ""))
        self.label.setProperty("ink", "warn")
        sign.setAlignment(Qt.AlignmentFlag.AlignTop)
        hbox(sign, (self.label, 1), into=self, margins=(8, 4, 8, 4))
        self.setAccessibleName(f"Warning: {text}")


class WarningLines(QWidget):
    """Shows the environment's warnings, and updates them when values, loop, device or handle speed change."""

    changed = Signal()

    def __init__(self, studio: Studio, facts: LoopFacts):
        super().__init__()
        self._studio, self._facts = studio, facts
        self._speed = 0.0
        self.texts: list[str] = []
        self._column = vbox(into=self, margins=(0, 2, 0, 2), gap=4)
        self.hide()
        for signal in (studio.environment_changed, studio.values_changed, facts.changed):
            signal.connect(self.refresh)
        self.refresh()

    @property
    def conditions(self) -> Conditions | None:
        """Return the conditions under which the loop renders; None without a device or a known delay."""
        setting, engine = self._facts.setting(), self._studio.engine
        if setting is None or engine is None:
            return None
        return Conditions(**{**vars(setting), "max_force": engine.max_force}, speed=self._speed)

    def watch(self, speed: float) -> None:
        """Set the highest recent speed of the handle in m/s; the window calls this a few times per second."""
        self._speed = speed
        self.refresh()

    def refresh(self) -> None:
        """Get the environment's warnings, and show them if they have changed."""
        environment, conditions = self._studio.environment, self.conditions
        if conditions is None:
            texts = switched_off(environment)
        else:
            texts = list(environment.warnings(self._studio.values, conditions))
        if texts != self.texts:
            self.texts = texts
            refill(self._column, map(WarningLine, texts))
            self.setVisible(bool(texts))
            self.changed.emit()
