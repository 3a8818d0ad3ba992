"""Held traces: what the plots showed when they were held, under what comes, each switched and removed."""

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


@dataclass(frozen=True)
class Look:
    """How a past stretch is drawn: token of its colour, dash in px."""

    token: str
    dash: tuple[float, ...]

    @property
    def sample(self) -> tuple[str, float, list[float]]:
        """Return it as a stroke for a sample beside a name: the dash in widths of a line of 2 px."""
        return self.token, 2.0, [length / 2.0 for length in self.dash]


LOOKS = (
    Look("hold", (2.0, 3.0)),
    Look("energy", (9.0, 4.0, 2.0, 4.0)),
    Look("accent", (6.0, 3.0)),
    Look("ink2", (2.0, 6.0)),
)
"""How held traces look, no two alike: as many are kept."""
_COLUMNS = 2000  # that a held stretch is reduced to
_FELT_SECONDS = 10.0  # the newest ones of it are held sample by sample, too: the plot of force shows no more


@dataclass(frozen=True)
class PastTrace:
    """A past stretch: its samples at the times in s at which they are shown, in SI units; words name it.

    pinned: its times count from the zero of the plots; where those follow, it ends at the newest sample.
    felt: position in m and force in N (m,) as felt, None where the delay was not known.
    """

    words: str
    time: np.ndarray
    values: dict[str, np.ndarray]
    look: Look
    pinned: bool
    felt: tuple[np.ndarray, np.ndarray] | None = None


def paint_past(painter: QPainter, x: np.ndarray, y: np.ndarray, look: Look) -> None:
    """Paint a past line given in pixels."""
    painter.setPen(strokes.pen(theme.color(look.token), 2.0))
    strokes.segments(painter, strokes.patterned(*strokes.thinned(x, y), look.dash))


def name(environment: Environment, values: dict[str, float]) -> str:
    """Name what was set: the environment, its first parameter, and what is not as it is by default."""
    first = environment.parameters[:1]
    told = [p for p in environment.parameters if p in first or values[p.key] != p.default]
    return ", ".join([environment.title, *(f"{p.symbol or p.label} {p.text(values[p.key])}" for p in told)])


class HeldTraces(QObject):
    """The held stretches by their place among LOOKS; ``changed`` with those that are switched on."""

    changed = Signal(object)

    def __init__(self, parent: QObject | None = None):
        super().__init__(parent)
        self.traces: dict[int, PastTrace] = {}
        self.delay: float | None = None
        """Of the loop whose samples are held next, in s; None where it is not known."""
        self.off: set[int] = set()

    def hold(
        self,
        history: History,
        stretch: tuple[float, float],
        words: str,
        shift: float | None = None,
        zero: float | None = None,
    ) -> PastTrace | None:
        """Hold a stretch (start, stop) in s; the oldest goes where there are as many as LOOKS.

        It stays where it is in the plots, whose zero is its end unless one is given in s, or is shown so many
        s later; one of the same words is numbered. None without data.
        """
        edges = np.linspace(stretch[0], np.nextafter(stretch[1], np.inf), _COLUMNS)
        window = history.window(edges).known() if not history.empty else None
        if window is None or len(window.x) < 2:
            return None
        if len(self.traces) == len(LOOKS):
            self.remove(next(iter(self.traces)))
        place = min(set(range(len(LOOKS))) - set(self.traces))
        known = (name for name, found in window.y.items() if name != OBJECT and np.isfinite(found).any())
        values = {name: window.y[name] for name in known}
        pinned = shift is None
        time = window.x - (stretch[1] if zero is None else zero) if shift is None else window.x + shift
        others = {trace.words for trace in self.traces.values()}
        names = chain([words], (f"{words} ({number})" for number in count(2)))
        words = next(name for name in names if name not in others)
        felt = None
        if self.delay is not None:
            last = history.between(max(stretch[0], stretch[1] - _FELT_SECONDS), edges[-1])
            felt = as_felt(last.x, last.y["position"], last.y["applied_force"], self.delay)
        self.traces[place] = PastTrace(words, time, values, LOOKS[place], pinned, felt)
        self._tell()
        return self.traces[place]

    def drop(self, trace: PastTrace | None) -> None:
        """Forget a trace if it is held still."""
        for place in [place for place, held in self.traces.items() if held is trace]:
            self.remove(place)

    def switch(self, place: int, on: bool) -> None:
        """Show one, or leave it out of the plots for now."""
        (self.off.discard if on else self.off.add)(place)
        self._tell()

    def remove(self, place: int) -> None:
        """Forget one."""
        self.traces.pop(place, None)
        self.off.discard(place)
        self._tell()

    def _tell(self) -> None:
        self.changed.emit(tuple(trace for place, trace in self.traces.items() if place not in self.off))


class HeldList(QWidget):
    """Names the held traces, each with its line, a switch and a way to remove it."""

    def __init__(self, held: HeldTraces, parent: QWidget | None = None):
        super().__init__(parent)
        self._held = held
        self.rows: dict[int, Row] = {}
        self._line = hbox(None, into=self, margins=(12, 2, 10, 2), gap=4)
        held.changed.connect(lambda _shown: self._follow())
        self.hide()

    def _follow(self) -> None:
        for place in list(self.rows):
            if self.rows[place].trace is not self._held.traces.get(place):
                self.rows.pop(place).deleteLater()
        for place, trace in self._held.traces.items():
            if place not in self.rows:
                self.rows[place] = Row(self._held, place, trace)
                self._line.insertWidget(self._line.count() - 1, self.rows[place])
        self.setVisible(bool(self.rows))


class Row(QWidget):
    """One held trace in the list."""

    def __init__(self, held: HeldTraces, place: int, trace: PastTrace):
        super().__init__()
        self.trace = trace
        self.box, self.away = QCheckBox(trace.words), QPushButton()
        self.box.setChecked(True)
        self.box.setToolTip("Show this held trace in the plots")
        self.away.setProperty("flat", True)
        self.away.setAccessibleName(f"Remove {trace.words}")
        self.away.setToolTip("Remove this held trace")
        icons.bind(self.away, "close", "ink2", 14)
        self.box.toggled.connect(lambda on: held.switch(place, on))
        self.away.clicked.connect(lambda: held.remove(place))
        hbox(Sample(trace.look.sample), self.box, self.away, into=self, gap=4)
