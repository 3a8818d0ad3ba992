"""Helpers for tests of plots: telemetry in a wall, pixels of a colour, turning the mouse wheel."""

import numpy as np
from PySide6.QtCore import QCoreApplication, QPoint, QPointF, Qt
from PySide6.QtGui import QColor, QImage, QWheelEvent

from hapkit_studio.environments import discover
from hapkit_studio.gui.widgets.theme import theme
from hapkit_studio.haptics import rows

RATE = 1000.0
LIBRARY = discover()


def telemetry(count, start=0, rate=RATE):
    """Return rows of a handle that oscillates in and out of a wall at 5 mm, with the force clamped at 3 N."""
    tick = start + np.arange(count)
    table = np.zeros((count, rows.ROW_WIDTH))
    table[:, rows.TICK], table[:, rows.HOST_TIME] = tick, tick / rate
    table[:, rows.POSITION] = 0.015 * np.sin(3.0 * tick / rate)
    table[:, rows.VELOCITY] = 0.045 * np.cos(3.0 * tick / rate)
    table[:, rows.FORCE] = -400.0 * np.maximum(table[:, rows.POSITION] - 0.005, 0.0)
    table[:, rows.APPLIED_FORCE] = np.maximum(table[:, rows.FORCE], -3.0)
    return table


def canvas_of(plots, key):
    return next(c for c in plots.canvases if c.plot_of.key == key)


def turn_wheel(canvas, across=0.5, eighths=240, key=Qt.KeyboardModifier.NoModifier):
    """Turn the wheel by eighths of a degree at a fraction of a plot's width; return the position in px."""
    box = canvas.measure()
    place = QPointF(round(box.left() + across * box.width()), round(box.center().y()))
    there = QPointF(canvas.mapToGlobal(place.toPoint()))
    button, phase = Qt.MouseButton.NoButton, Qt.ScrollPhase.NoScrollPhase
    event = QWheelEvent(place, there, QPoint(), QPoint(0, eighths), button, key, phase, False)
    QCoreApplication.sendEvent(canvas.viewport(), event)
    return place


def colored(image: QImage, token: str) -> np.ndarray:
    """Return columns and rows (n, 2) of the pixels that have exactly a token's colour."""
    image = image.convertToFormat(QImage.Format.Format_RGB32)
    raw = np.frombuffer(image.constBits(), np.uint32).reshape(image.height(), -1)[:, : image.width()]
    wanted = np.uint32(QColor(theme.tokens[token]).rgb())
    down, across = np.nonzero(raw == wanted)
    return np.column_stack([across, down])
