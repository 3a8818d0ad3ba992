"""The header line of a plot: its title, a sample of each line, and the live value in the trace's colour."""

import math
from collections.abc import Sequence

from PySide6.QtCore import QPointF, QSize, Qt
from PySide6.QtGui import QPainter, QResizeEvent
from PySide6.QtWidgets import QLabel, QPushButton, QSizePolicy, QWidget

from hapkit_studio.gui.live.plots.declared import TimePlot
from hapkit_studio.gui.widgets import icons
from hapkit_studio.gui.widgets.canvas import RIGHT
from hapkit_studio.gui.widgets.parts import hbox, label
from hapkit_studio.gui.widgets.strokes import pen
from hapkit_studio.gui.widgets.text import plain
from hapkit_studio.gui.widgets.theme import number, theme

HEIGHT = 29
_WIDTH = 22
Stroke = tuple[str, float, list[float] | None]


class Sample(QWidget):
    """A short sample of a line as the plot draws it.

    Strokes (token, width, dash) are drawn on top of each other.
    """

    def __init__(self, *strokes: Stroke):
        super().__init__()
        self.strokes = strokes
        theme.changed.connect(self.update)

    def sizeHint(self) -> QSize:
        return QSize(theme.px(_WIDTH), 12)

    def paintEvent(self, event) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        middle = self.height() / 2
        for token, width, dash in self.strokes:
            painter.setPen(pen(theme.color(token), width, dash))
            painter.drawLine(QPointF(0, middle), QPointF(self.width(), middle))


def _line(stroke: Stroke, text: str, help: str) -> list[QWidget]:
    """Return the sample of a line and its label."""
    parts: list[QWidget] = [Sample(stroke), plain(QLabel(text))]
    parts[1].setProperty("ink", "axis")
    for part in parts:
        part.setToolTip(help)
    return parts


def _button(tip: str) -> QPushButton:
    """Return a link-like button for the header line."""
    button = QPushButton()
    button.setProperty("link", True)
    button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
    button.setToolTip(tip)
    return button


class Remark(QLabel):
    """A label with several texts: it shows the longest one that fits. The tooltip shows the longest one."""

    def __init__(self) -> None:
        super().__init__(textFormat=Qt.TextFormat.PlainText)
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        self.setContentsMargins(8, 0, 0, 0)
        self._texts: tuple[str, ...] = ()

    def set_texts(self, *texts: str) -> None:
        """Set alternative texts, longest first; the first one that fits is shown."""
        self._texts = texts
        self.setToolTip(texts[0] if texts else "")
        self._fit()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()

    def _fit(self) -> None:
        wide = self.fontMetrics().horizontalAdvance
        self.setText(next((text for text in self._texts if wide(text) <= self.contentsRect().width()), ""))


class Header(QWidget):
    """Shows the title and the live value of a time plot, and an optional remark."""

    def __init__(self, plot: TimePlot):
        super().__init__()
        self.plot = plot
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Fixed)
        self.lines: list[QWidget] = []
        self.object: list[QWidget] = []
        several = len([trace for trace in plot.traces if trace.label]) > 1
        for trace in reversed(plot.traces):
            dash = [d / 2.0 for d in trace.dash] or ([2.5, 1.75] if trace.dashed else None)
            line = _line((trace.color, 2.0 if trace.dash else 2.6, dash), trace.label, trace.help)
            if not trace.label:
                self.object = line
            elif several:
                self.lines += line
        if plot.limits:
            limit = (
                "The largest force that the motor may give. If the law asks for more, the force is cut to "
                "this value"
            )
            self.lines += _line(("danger", 1.6, [1.2, 2.6]), "limit", limit)
        surface = _line(("matline", 1.6, [3.5, 2.5]), "", "Position of the surface")
        self.surface = surface if plot.surface else []
        self.back = _button("Back to the live plots, and switch the trigger off (Backspace)")
        self.unlock = _button("Unlock the axes (Y)")
        icons.bind(self.back, "play", "accent", 12)
        icons.bind(self.unlock, "lock", "accent", 14)
        self.unlock.setAccessibleName("Unlock the axes")
        self.remark, self.value = Remark(), QLabel()
        title = label(plot.title, "strong", wrap=False)
        self.value.setProperty("role", "readout")
        self.value.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        self.value.setToolTip(plot.traces[-1].help)
        self.value.setProperty("ink", plot.traces[-1].color)
        # a plot among the force plots needs no title, because the switch above it shows its name
        name = () if plot.beside else (title, 3)
        parts = (*name, *self.lines, *self.object, *self.surface)
        ends = ((self.remark, 1), self.back, self.unlock, self.value)
        hbox(*parts, *ends, into=self, margins=(0, 0, RIGHT, 0), gap=7)
        for part in (self.object, self.surface):
            self.show_part(part, "")
        self.show_view("", False)
        self.show_value(0.0)

    def sizeHint(self) -> QSize:
        """Return this header's natural width, and the common height of all headers."""
        return QSize(super().sizeHint().width(), theme.px(HEIGHT))

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Hide the samples of the lines if otherwise the value would be cut off."""
        super().resizeEvent(event)
        layout = self.layout()
        assert layout is not None
        # a hidden part is not shown on trial: the parent would resize this header again, without end
        hidden = [part for part in self.lines if part.isHidden()]
        wide = layout.totalSizeHint().width() + sum(p.sizeHint().width() + layout.spacing() for p in hidden)
        for part in self.lines:
            part.setVisible(wide <= self.width())

    def show_part(self, parts: Sequence[QWidget], name: str) -> None:
        """Show a line's sample with a label; an empty label hides the sample."""
        for part in parts:
            part.setVisible(bool(name))
            if isinstance(part, QLabel):
                part.setText(name)

    def show_view(self, text: str, locked: bool) -> None:
        """Show the view's state, such as "Paused", and whether the axes are locked; "" hides the state."""
        self.back.setText(text)
        self.back.setVisible(bool(text))
        self.unlock.setVisible(locked)

    def show_value(self, value: float) -> None:
        """Show the live value, given in SI."""
        text = self.written(value)
        self.value.setText(text)
        self.value.setAccessibleName(f"{self.plot.title} {text}")

    def written(self, value: float) -> str:
        """Format a value that is given in SI: with the unit of the plot's axis and the plot's decimals."""
        known = math.isfinite(value)
        text = number(value * self.plot.scale, self.plot.decimals, sign=True) if known else "–"
        return f"{text} {self.plot.unit}"
