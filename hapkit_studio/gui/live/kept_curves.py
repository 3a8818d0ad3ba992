"""Kept curves: earlier intervals of the plots, drawn behind the live data.

The user can hide or remove each curve.
"""

from dataclasses import dataclass
from itertools import chain, count

import numpy as np
from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QPainter
from PySide6.QtWidgets import QCheckBox, QPushButton, QWidget

from hapkit_studio.analysis.felt import as_felt
from hapkit_studio.environments.base import Environment
from hapkit_studio.gui.live.history import History
from hapkit_studio.gui.live.plot_header import Sample
from hapkit_studio.gui.live.plots.declared import OBJECT
from hapkit_studio.gui.widgets import icons, strokes
from hapkit_studio.gui.widgets.parts import hbox
from hapkit_studio.gui.widgets.theme import theme
from hapkit_studio.parameters import Choice


@dataclass(frozen=True)
class LineStyle:
    """The line style of a kept curve: its colour token, and its dash pattern in px."""

    token: str
    dash: tuple[float, ...]

    @property
    def sample(self) -> tuple[str, float, list[float]]:
        """Return the stroke for a legend's sample; the dashes are in units of a 2 px line."""
        return self.token, 2.0, [length / 2.0 for length in self.dash]


LINE_STYLES = (
    LineStyle("hold", (2.0, 3.0)),
    LineStyle("energy", (9.0, 4.0, 2.0, 4.0)),
    LineStyle("accent", (6.0, 3.0)),
    LineStyle("ink2", (2.0, 6.0)),
)
"""Each kept curve has its own style, so the number of styles limits the number of kept curves."""
_COLUMNS = 2000  # number of points to which a kept curve is reduced
# s: the newest part is also stored at the full sampling rate, for the force plot, which shows 10 s
_FELT_SECONDS = 10.0


@dataclass(frozen=True)
class KeptCurve:
    """A kept curve: its samples in SI units, the times in s at which they are shown, and its name.

    ``pinned`` is True if the times are relative to the plots' zero; while the plots follow the newest sample,
    such a curve ends at this sample. ``felt`` contains position in m and force in N (m,) as felt by the hand;
    it is None if the delay is unknown.
    """

    name: str
    time: np.ndarray
    values: dict[str, np.ndarray]
    style: LineStyle
    pinned: bool
    felt: tuple[np.ndarray, np.ndarray] | None = None


def paint_kept_curve(painter: QPainter, x: np.ndarray, y: np.ndarray, style: LineStyle) -> None:
    """Paint a kept curve, which is given in pixels."""
    painter.setPen(strokes.pen(theme.color(style.token), 2.0))
    strokes.segments(painter, strokes.patterned(*strokes.thinned(x, y), style.dash))


def settings_name(environment: Environment, values: dict[str, float]) -> str:
    """Return a name for settings: the environment, its first parameter, and non-default parameters."""
    first = environment.parameters[:1]
    shown = [p for p in environment.parameters if p in first or values[p.key] != p.default]
    texts = [(p.phrase if isinstance(p, Choice) else p.text)(values[p.key]) for p in shown]
    names = [p.symbol or p.label for p in shown]
    return ", ".join([environment.title, *map(" ".join, zip(names, texts, strict=True))])


class KeptCurves(QObject):
    """The kept curves by their index in LINE_STYLES; ``changed`` is emitted with the visible curves."""

    changed = Signal(object)

    def __init__(self, parent: QObject | None = None):
        super().__init__(parent)
        self.curves: dict[int, KeptCurve] = {}
        self.delay: float | None = None
        """Delay in s of the loop that produced the samples; None if unknown."""
        self.off: set[int] = set()

    def keep(
        self,
        history: History,
        stretch: tuple[float, float],
        name: str,
        shift: float | None = None,
        zero: float | None = None,
    ) -> KeptCurve | None:
        """Keep the interval (start, stop) in s and return its curve; None if it has no data.

        Without ``shift``, the curve keeps its position in the plots. Their zero is at ``zero`` s; None means
        the end of the interval. With ``shift``, the curve is moved by this many s. If all styles are used,
        the oldest curve is removed. If the name exists already, a number is appended to it.
        """
        edges = np.linspace(stretch[0], np.nextafter(stretch[1], np.inf), _COLUMNS)
        window = history.window(edges).known() if not history.empty else None
        if window is None or len(window.x) < 2:
            return None
        if len(self.curves) == len(LINE_STYLES):
            self.remove(next(iter(self.curves)))
        place = min(set(range(len(LINE_STYLES))) - set(self.curves))
        known = (channel for channel, y in window.y.items() if channel != OBJECT and np.isfinite(y).any())
        values = {channel: window.y[channel] for channel in known}
        pinned = shift is None
        time = window.x - (stretch[1] if zero is None else zero) if shift is None else window.x + shift
        others = {curve.name for curve in self.curves.values()}
        names = chain([name], (f"{name} ({number})" for number in count(2)))
        name = next(text for text in names if text not in others)
        felt = None
        if self.delay is not None:
            last = history.between(max(stretch[0], stretch[1] - _FELT_SECONDS), edges[-1])
            felt = as_felt(last.x, last.y["position"], last.y["applied_force"], self.delay)
        self.curves[place] = KeptCurve(name, time, values, LINE_STYLES[place], pinned, felt)
        self._emit()
        return self.curves[place]

    def drop(self, curve: KeptCurve | None) -> None:
        """Remove a curve if it is still shown."""
        for place in [place for place, kept in self.curves.items() if kept is curve]:
            self.remove(place)

    def switch(self, place: int, on: bool) -> None:
        """Show or hide a curve."""
        (self.off.discard if on else self.off.add)(place)
        self._emit()

    def remove(self, place: int) -> None:
        """Remove a curve."""
        self.curves.pop(place, None)
        self.off.discard(place)
        self._emit()

    def _emit(self) -> None:
        self.changed.emit(tuple(curve for place, curve in self.curves.items() if place not in self.off))


class KeptCurveList(QWidget):
    """The row of kept curves; each has a sample of its line, a check box and a remove button."""

    def __init__(self, kept: KeptCurves, parent: QWidget | None = None):
        super().__init__(parent)
        self._kept = kept
        self.rows: dict[int, Row] = {}
        self._line = hbox(None, into=self, margins=(12, 2, 10, 2), gap=4)
        kept.changed.connect(lambda _shown: self._follow())
        self.hide()

    def _follow(self) -> None:
        for place in list(self.rows):
            if self.rows[place].curve is not self._kept.curves.get(place):
                self.rows.pop(place).deleteLater()
        for place, curve in self._kept.curves.items():
            if place not in self.rows:
                self.rows[place] = Row(self._kept, place, curve)
                self._line.insertWidget(self._line.count() - 1, self.rows[place])
        self.setVisible(bool(self.rows))


class Row(QWidget):
    """A row of the list that shows one kept curve."""

    def __init__(self, kept: KeptCurves, place: int, curve: KeptCurve):
        super().__init__()
        self.curve = curve
        self.box, self.away = QCheckBox(curve.name), QPushButton()
        self.box.setChecked(True)
        self.box.setToolTip("Show this kept curve in the plots")
        self.away.setProperty("flat", True)
        self.away.setAccessibleName(f"Remove the kept curve {curve.name}")
        self.away.setToolTip("Remove this kept curve")
        icons.bind(self.away, "close", "ink2", 14)
        self.box.toggled.connect(lambda on: kept.switch(place, on))
        self.away.clicked.connect(lambda: kept.remove(place))
        hbox(Sample(curve.style.sample), self.box, self.away, into=self, gap=4)
