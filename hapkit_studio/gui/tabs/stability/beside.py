"""What stands beside the map: the verdict, what each line means, and the conditions all of it holds for."""

from PySide6.QtCore import Qt
from PySide6.QtGui import QFontMetricsF
from PySide6.QtWidgets import QFrame, QHBoxLayout, QLabel, QScrollArea, QSizePolicy, QVBoxLayout, QWidget

from hapkit_studio.gui.panel.parameter_panel import rule
from hapkit_studio.gui.tabs.side import Pairs, hint
from hapkit_studio.gui.tabs.stability.verdict import Verdict
from hapkit_studio.gui.widgets import icons
from hapkit_studio.gui.widgets.style import dress
from hapkit_studio.gui.widgets.text import plain
from hapkit_studio.gui.widgets.theme import theme

WIDTH = 276
_MARGIN = 10
_SMALLEST = 16
_SIGN = 24


class Beside(QScrollArea):
    """Verdict, lines and conditions in a column that scrolls where it is too long."""

    def __init__(self) -> None:
        super().__init__()
        self.setFixedWidth(WIDTH)
        self.setWidgetResizable(True)
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        dress(self, "QScrollArea, #beside { background: transparent; border: none; }")
        self.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Ignored)
        self._sign = ("circle", "ink2")
        self.sign, self.hand = QLabel(), hint()
        self.headline, self.out = plain(QLabel()), plain(QLabel())
        self.lines, self.conditions = hint(), Pairs()
        heading = QLabel("Conditions")
        heading.setProperty("role", "section")
        self._above = (rule(), heading)
        self.out.setWordWrap(True)
        dress(self.hand, "QLabel { color: @ink2; font-size: 14px; }")
        dress(self.out, "QLabel { color: @danger; }")
        self._arrange()
        theme.changed.connect(self._look)
        self._look()

    def show_verdict(self, verdict: Verdict) -> None:
        """Say how far the rendered impedance is from the limit, or why nothing can be said."""
        self.headline.setText(verdict.headline)
        self.hand.setText(verdict.words)
        self.hand.setVisible(bool(verdict.words))
        self.out.setText(verdict.more)
        self.out.setVisible(bool(verdict.more))
        self._sign = verdict.sign
        self._look()

    def show_conditions(self, pairs: list[tuple[str, str]]) -> None:
        """Show what the limits hold for."""
        self.conditions.show_pairs(pairs)

    def show_lines(self, words: dict[str, tuple[str, str]]) -> None:
        """Say what each line of the map means."""
        self.lines.setText("\n".join(f"{name}: {meaning}" for name, meaning in words.values()))

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
        self._body = QWidget()
        self._body.setObjectName("beside")
        column = QVBoxLayout(self._body)
        column.setContentsMargins(4, 10, 2 * _MARGIN - 4, 10)
        column.setSpacing(6)
        column.addLayout(first)
        column.addWidget(self.hand)
        column.addWidget(self.out)
        column.addSpacing(6)
        column.addWidget(self.lines)
        for part in self._above:
            column.addWidget(part)
        column.addWidget(self.conditions)
        column.addStretch(1)
        self.setWidget(self._body)
        self.conditions.stand_under(self._above)
