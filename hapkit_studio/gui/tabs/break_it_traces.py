"""What a value of the knob showed over time: a sign, the verdict in words, and the trace."""

import re

from PySide6.QtWidgets import QHBoxLayout, QLabel, QVBoxLayout, QWidget

from hapkit_studio.gui import icons
from hapkit_studio.gui.dress import dress
from hapkit_studio.gui.tabs.break_it_record import Record, Try, reading, sentence
from hapkit_studio.gui.tabs.break_it_trace import TraceChart
from hapkit_studio.gui.theme import theme

_SIGN = 18


class Sign(QLabel):
    """A check mark, a cross, or nothing, in the theme's colours."""

    def __init__(self, size: int = _SIGN):
        super().__init__()
        self._size = size
        self._holds: bool | None = None
        self.setFixedSize(size, size)
        theme.changed.connect(self._paint)

    def show_sign(self, holds: bool | None) -> None:
        """Show that it holds, that it fails, or neither."""
        self._holds = holds
        self._paint()

    def _paint(self) -> None:
        if self._holds is None:
            self.clear()
        else:
            name, token = ("check", "ok") if self._holds else ("close", "danger")
            self.setPixmap(icons.pixmap(name, self._size, token, self.devicePixelRatioF()))


class TraceCard(QWidget):
    """The last try on one side of the limit."""

    def __init__(self, side: str):
        super().__init__()
        self._side = side
        self.sign, self.words, self.place = Sign(), QLabel(), QLabel()
        self.place.setProperty("role", "hint")
        self.chart = TraceChart()
        head = QHBoxLayout()
        head.setSpacing(6)
        for part in (self.sign, self.words):
            head.addWidget(part)
        head.addStretch(1)
        head.addWidget(self.place)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(2)
        column.addLayout(head)
        column.addWidget(self.chart, 1)

    def show_record(self, record: Record) -> None:
        """Show what a failure's knob showed on this side."""
        tried: Try | None = getattr(record, self._side)
        if tried is None:
            self._show_nothing()
            return
        found, old = tried.evidence, self._side in record.old
        self.sign.show_sign(found.holds)
        self.words.setText(verdict(found.words)[0])
        token = "ink3" if old else "ok" if found.holds else "danger"
        dress(self.words, f"QLabel {{ color: @{token}; font-weight: 600; }}")
        self.place.setText(reading(tried.value, record.failure.knob))
        name = f"{found.label}, {found.unit}" if found.unit else found.label
        self.chart.show_trace(found.time, found.trace, name, found.holds, old)
        self.chart.setAccessibleName(f"{sentence(name)} over time: {found.words}")

    def _show_nothing(self) -> None:
        self.sign.show_sign(None)
        self.words.setText(f"{sentence(self._side)} the limit: not tried yet")
        dress(self.words, "QLabel { color: @ink3; }")
        self.place.setText("")
        self.chart.clear_trace()
        self.chart.setAccessibleName("No trace yet")


def verdict(words: str) -> list[str]:
    """Return the verdict, and after it what is added, each a sentence without its full stop."""
    return [sentence(part.strip()) for part in re.split("[;,] ", words)]
