"""The measured cells of the map, coloured by what rendering did there; what grows is hatched as well."""

import numpy as np
from PySide6.QtCore import QRect, Qt
from PySide6.QtGui import QPainter, QPen

from hapkit_studio.gui.tabs.chart import Chart
from hapkit_studio.gui.tabs.marks import hatching
from hapkit_studio.gui.tabs.stability_measure import Measured
from hapkit_studio.gui.theme import theme

# DECAYS, BUZZES, GROWS of the measured classes
TOKENS = ("stable", "warnsoft", "unstable")
_GROWS = 2


def paint_cells(painter: QPainter, chart: Chart, measured: Measured) -> None:
    """Paint cells over the axes they were measured on, clipped to the frame by the chart."""
    cells = measured.cells
    rows, columns = cells.classes.shape
    width, top = measured.axes[0] / columns, measured.axes[1] / rows
    painter.setRenderHint(QPainter.RenderHint.Antialiasing, False)
    painter.setPen(QPen(Qt.PenStyle.NoPen))
    for column in range(columns):
        for first, last, kind in runs(cells.classes[:, column]):
            lower = chart.at(column * width, first * top)
            upper = chart.at((column + 1) * width, (last + 1) * top)
            left, up = round(lower.x()), round(upper.y())
            box = QRect(left, up, round(upper.x()) - left, round(lower.y()) - up)
            painter.fillRect(box, theme.color(TOKENS[kind]))
            if kind == _GROWS:
                painter.fillRect(box, hatching("danger"))


def runs(classes: np.ndarray) -> list[tuple[int, int, int]]:
    """Return (first, last, class) of every stretch of equal classes (m,)."""
    ends = np.flatnonzero(np.diff(classes)) + 1
    starts = [0, *ends.tolist()]
    lasts = [*(ends - 1).tolist(), len(classes) - 1]
    return [(a, b, int(classes[a])) for a, b in zip(starts, lasts, strict=True)]
