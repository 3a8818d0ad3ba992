"""What the knob's present value does, in words with a sign; beside it the way into the scene and back."""

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget

from hapkit_studio.gui.tabs.break_it.record import HERE, Record, reading
from hapkit_studio.gui.widgets import icons
from hapkit_studio.gui.widgets.style import dress
from hapkit_studio.gui.widgets.theme import theme

_SIGN = 26
_BOARD = "Only the simulated Hapkit is made to fail on purpose"
_GONE = "Not in the scene any more: the scene or its values were changed by hand."
_FEEL = "Puts scene, values and loop into the window; Take back undoes that"


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


class Verdict(QWidget):
    """Emits ``feel_pressed`` and ``back_pressed``."""

    feel_pressed = Signal()
    back_pressed = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.sign, self.words, self.more = Sign(_SIGN), QLabel(), QLabel()
        self.words.setWordWrap(True)
        self.more.setWordWrap(True)
        self.feel, self.back = (
            QPushButton("Feel it", autoDefault=True),
            QPushButton("Take back", autoDefault=True),
        )
        icons.bind(self.feel, "hand", "ink", 18)
        icons.bind(self.back, "reset", "ink", 18)
        self.feel.clicked.connect(self.feel_pressed)
        self.back.clicked.connect(self.back_pressed)
        lines = QVBoxLayout()
        lines.setContentsMargins(0, 0, 0, 0)
        lines.setSpacing(1)
        lines.addWidget(self.words)
        lines.addWidget(self.more)
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(8)
        row.addWidget(self.sign, 0, Qt.AlignmentFlag.AlignTop)
        row.addLayout(lines, 1)
        for button in (self.back, self.feel):
            row.addWidget(button, 0, Qt.AlignmentFlag.AlignVCenter)

    def show_record(
        self, record: Record, simulated: bool, felt: bool, taken: bool, gone: bool = False
    ) -> None:
        """Show a verdict; felt: it is in the scene; gone: it was; taken: there is something to take back."""
        here = record.here
        holds = here.evidence.holds if here and not record.wrong else None
        fresh = here is not None and HERE not in record.old
        self.sign.show_sign(holds)
        self.words.setFont(theme.font("strong" if record.wrong else "readout"))
        self.words.setText(self._headline(record))
        token = "danger" if record.wrong else "ink3" if not fresh else "ok" if holds else "danger"
        dress(self.words, f"QLabel {{ color: @{token}; }}")
        live = here.live if here else None
        advice = live.advice if felt and live else ""
        more = f"In the scene now. {advice}".strip() if felt else _GONE if gone else self._where(record)
        self.more.setText(more)
        dress(self.more, f"QLabel {{ color: @{'accent' if felt else 'ink2'}; font-size: 12px; }}")
        self.feel.setVisible(record.failure.live is not None and not felt)
        self.feel.setEnabled(simulated and fresh and live is not None and not record.wrong)
        self.feel.setToolTip(_FEEL if simulated else _BOARD)
        self.back.setVisible(taken)

    @staticmethod
    def _headline(record: Record) -> str:
        if record.wrong:
            return record.wrong
        if record.here is not None:
            from hapkit_studio.charts.failures import clauses

            return clauses(record.here.evidence.words)[0]
        return "Not tried yet"

    @staticmethod
    def _where(record: Record) -> str:
        """Return the knob's value as a share of the limit, and what else there is to say."""
        if record.wrong or not record.ready or record.value is None or record.limit is None:
            return f"{record.failure.summary}."
        knob = record.failure.knob
        limit = reading(record.limit, knob)
        name = "" if knob.unit else f"{knob.symbol or knob.label} = "
        place = f"{name}{reading(record.value, knob)}, {record.share:.2f} of the limit {limit}"
        from hapkit_studio.charts.failures import clauses

        rest = clauses(record.here.evidence.words)[1:] if record.here else []
        return " ".join(f"{part}." for part in [place, *rest])
