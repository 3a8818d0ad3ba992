"""What stands beside the map: the verdict, what each line means, and the conditions all of it holds for."""

import math
from typing import TYPE_CHECKING

from PySide6.QtCore import QPointF, QRectF, QSize
from PySide6.QtGui import QFontMetricsF, QPainter, QPaintEvent, QResizeEvent
from PySide6.QtWidgets import QHBoxLayout, QLabel, QSizePolicy, QVBoxLayout, QWidget

from hapkit_studio.analysis.margin import Margin, hand_words, short, way_out
from hapkit_studio.gui import icons
from hapkit_studio.gui.dress import dress
from hapkit_studio.gui.parameter_panel import rule
from hapkit_studio.gui.tabs.marks import DASH_DOT, DOT, line, marker
from hapkit_studio.gui.tabs.side import Pairs, hint
from hapkit_studio.gui.theme import theme

if TYPE_CHECKING:
    from hapkit_studio.analysis.plane import Plane

WIDTH = 276
_MARGIN = 10
_SMALLEST = 16
_SAMPLE = QSize(26, 18)
_SIGN = 24
# Lines: token, width, dash; the others are drawn as marks.
_DRAWN: dict[str, tuple[str, float, list[float] | None]] = {
    "exact": ("ink", 3.0, None),
    "hands": ("ink2", 1.6, None),
    "simple": ("asked", 2.0, DOT),
    "passive": ("velocity", 2.0, DASH_DOT),
    "coulomb": ("warn", 2.0, [6.0, 3.0]),
}
_FILLED = {"buzzes": "warnsoft"}


class Sample(QWidget):
    """A line or mark as the map draws it."""

    def __init__(self, key: str):
        super().__init__()
        self._key = key
        self.setFixedSize(_SAMPLE)
        theme.changed.connect(self.update)

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        middle = QPointF(0.5 * self.width(), 0.5 * self.height())
        if self._key in _DRAWN:
            token, width, dash = _DRAWN[self._key]
            line(painter, [QPointF(0.0, middle.y()), QPointF(self.width(), middle.y())], token, width, dash)
        elif self._key in _FILLED:
            painter.setPen(theme.color("edge"))
            painter.setBrush(theme.color(_FILLED[self._key]))
            painter.drawRect(QRectF(middle.x() - 7.0, middle.y() - 6.0, 14.0, 12.0))
        else:
            token = "applied" if self._key == "controlled" else "position"
            marker(painter, "circle", middle, token, 6.0, filled=False)


class Row(QWidget):
    """One line's sample, name and explanation; folded, the explanation is the tooltip."""

    def __init__(self, key: str):
        super().__init__()
        self.name, self.words = QLabel(), hint()
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(12)
        top = QVBoxLayout()
        top.addWidget(Sample(key))
        top.addStretch(1)
        row.addLayout(top)
        column = QVBoxLayout()
        column.setSpacing(0)
        column.addWidget(self.name)
        column.addWidget(self.words)
        row.addLayout(column, 1)

    def show_words(self, name: str, words: str) -> None:
        """Name the line and explain it."""
        self.name.setText(name)
        self.words.setText(words)
        self.setToolTip(words)


class Legend(QWidget):
    """The lines that there are, from top to bottom."""

    def __init__(self) -> None:
        super().__init__()
        self.rows: dict[str, Row] = {}
        self._folded = False
        self._column = QVBoxLayout(self)
        self._column.setContentsMargins(0, 0, 0, 0)
        self._column.setSpacing(8)
        for key in ("exact", "hands", "measured", "controlled", "buzzes", "simple", "passive", "coulomb"):
            self.rows[key] = Row(key)
            self._column.addWidget(self.rows[key])

    def show_lines(self, words: dict[str, tuple[str, str]]) -> None:
        """Show these lines, by key: name and explanation."""
        for key, row in self.rows.items():
            row.setVisible(key in words)
            if key in words:
                row.show_words(*words[key])

    def fold(self, on: bool) -> None:
        """Leave the explanations to the tooltips."""
        self._column.setSpacing(3 if on else 8)
        for row in self.rows.values():
            row.words.setVisible(not on)


class Beside(QWidget):
    """Verdict, legend and conditions in a column."""

    def __init__(self) -> None:
        super().__init__()
        self.setFixedWidth(WIDTH)
        self.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Ignored)
        self._sign = ("circle", "ink2")
        self._known, self._line = False, rule()
        self.sign, self.headline, self.hand, self.out = QLabel(), QLabel(), hint(), QLabel()
        self.legend, self.conditions = Legend(), Pairs()
        self.heading = QLabel("Conditions")
        self.heading.setProperty("role", "section")
        self.out.setWordWrap(True)
        dress(self.hand, "QLabel { color: @ink2; font-size: 14px; }")
        dress(self.out, "QLabel { color: @danger; }")
        self._arrange()
        theme.changed.connect(self._look)
        self._look()

    def show_verdict(self, margin: Margin) -> None:
        """Say how far the rendered impedance is from the limit."""
        said, hand = short(margin), hand_words(margin.hand)
        head, cut, _ = said.partition(" the limit")
        self.headline.setText(head)
        self.hand.setText(f"the limit; {hand}." if cut else "" if said.endswith(hand) else f"{hand}.")
        self.hand.setVisible(bool(self.hand.text()))
        self._show_out(way_out(margin))
        known = not math.isnan(margin.limit)
        self._sign = (
            (("check", "ok") if margin.stable else ("cross", "danger")) if known else ("circle", "ink2")
        )
        self._look()

    def show_reason(self, headline: str, words: str) -> None:
        """Say why there is no verdict."""
        self.headline.setText(headline)
        self.hand.setText(words)
        self.hand.setVisible(True)
        self._show_out("")
        self._sign = ("circle", "ink2")
        self._look()

    def show_conditions(self, pairs: list[tuple[str, str]]) -> None:
        """Show what the limits hold for."""
        self._known = bool(pairs)
        self.conditions.show_pairs(pairs)
        self.fit()

    def show_legend(self, words: dict[str, tuple[str, str]]) -> None:
        """Show which lines there are, and what they mean."""
        self.legend.show_lines(words)
        self.fit()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self.fit()

    def fit(self) -> None:
        """Leave away what there is no room for: explanations, then conditions, then the legend."""
        layout = self.layout()
        assert layout is not None
        for level in range(4):
            self.legend.fold(level >= 1)
            for part in (self._line, self.heading, self.conditions):
                part.setVisible(level < 2 and self._known)
            self.legend.setVisible(level < 3)
            layout.activate()
            if layout.totalHeightForWidth(self.width()) <= self.height():
                break

    def _show_out(self, words: str) -> None:
        self.out.setText(words)
        self.out.setVisible(bool(words))

    def _look(self) -> None:
        name, token = self._sign
        self.sign.setPixmap(icons.pixmap(name, _SIGN, token, self.devicePixelRatioF()))
        size = self._fitting(self.headline.text())
        ink = "danger" if token == "danger" else "ink"
        dress(self.headline, f"QLabel {{ color: @{ink}; font-size: {size}px; font-weight: 700; }}")
        dress(self.out, f"QLabel {{ color: @{'danger' if token == 'danger' else 'ink2'}; }}")

    def _fitting(self, words: str) -> int:
        """Return the largest size in px at which the headline takes one line."""
        font, free = theme.font("verdict"), WIDTH - _SIGN - 2 * _MARGIN - 10
        size = font.pixelSize()
        while size > _SMALLEST and QFontMetricsF(font).horizontalAdvance(words) > free:
            size -= 1
            font.setPixelSize(size)
        return size

    def _arrange(self) -> None:
        first = QHBoxLayout()
        first.setSpacing(10)
        first.addWidget(self.sign)
        first.addWidget(self.headline, 1)
        column = QVBoxLayout(self)
        column.setContentsMargins(4, 10, 2 * _MARGIN - 4, 10)
        column.setSpacing(6)
        column.addLayout(first)
        column.addWidget(self.hand)
        column.addWidget(self.out)
        column.addSpacing(6)
        column.addWidget(self.legend)
        column.addWidget(self._line)
        column.addWidget(self.heading)
        column.addWidget(self.conditions)
        column.addStretch(1)


def legend_words(plane: "Plane", shown: dict[str, bool]) -> dict[str, tuple[str, str]]:
    """Return name and explanation of the lines that are seen; shown: what is measured, and every hand."""
    from hapkit_studio.analysis.plane_words import LINES, line

    wanted = {
        "exact": plane.setting.linear,
        "hands": shown["hands"],
        "measured": shown["measured"],
        "controlled": shown["controlled"],
        "buzzes": shown["buzzes"],
        "simple": True,
        "passive": bool(plane.edge.any()),
        "coulomb": plane.coulomb < plane.top,
    }
    own = {
        "hands": ("Other hands", "light, medium and firm grip"),
        "controlled": ("Measured, controlled", "with the passivity controller"),
    }
    found = {key: own[key] if key in own else line(plane, key) for key, on in wanted.items() if on}
    assert set(found) - set(own) <= set(LINES)
    return found
