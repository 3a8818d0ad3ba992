"""One line under the code: a sign, words that can be copied, and what may be done about them."""

from collections.abc import Callable, Sequence

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QHBoxLayout, QLabel, QProgressBar, QPushButton, QWidget

from hapkit_studio.gui import icons
from hapkit_studio.gui.dress import dress
from hapkit_studio.gui.rich import plain
from hapkit_studio.gui.theme import theme

Button = tuple[str, Callable[[], object]]

_HEIGHT = 40
# tone: sign, colour of sign and words, ground
_TONES = {
    "": ("", "ink2", "side"),
    "ok": ("check", "ok", "oksoft"),
    "warn": ("info", "warn", "warnsoft"),
    "danger": ("cross", "danger", "dangersoft"),
}


class Strip(QWidget):
    """Shows one message at a time; ``say`` replaces it."""

    def __init__(self, parent: QWidget | None = None):
        super().__init__(parent)
        self.setObjectName("strip")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.setMinimumHeight(_HEIGHT)
        self.tone = ""
        self.sign, self.words, self.busy = QLabel(), plain(QLabel()), QProgressBar()
        self.words.setWordWrap(True)
        self.words.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.busy.setRange(0, 0)
        self.busy.setFixedWidth(72)
        self.busy.setAccessibleName("Working")
        self.buttons: list[QPushButton] = []
        self._row = QHBoxLayout(self)
        self._row.setContentsMargins(12, 4, 8, 4)
        self._row.setSpacing(8)
        for widget in (self.sign, self.busy):
            self._row.addWidget(widget)
        self._row.addWidget(self.words, 1)
        theme.changed.connect(self._show_tone)
        self.say("")

    def say(self, words: str, tone: str = "", buttons: Sequence[Button] = (), busy: bool = False) -> None:
        """Show words in a tone ("", ok, warn, danger), with buttons, or a bar while something works."""
        self.tone = tone
        self.words.setText(words)
        self.busy.setVisible(busy)
        for old in self.buttons:
            self._row.removeWidget(old)
            old.hide()
            old.deleteLater()
        self.buttons = [self._button(*button) for button in buttons]
        self._show_tone()

    def _button(self, words: str, run: Callable[[], object]) -> QPushButton:
        button = QPushButton(words, autoDefault=True)  # Enter presses it: Space is the pause key
        button.clicked.connect(lambda: run())
        self._row.addWidget(button)
        button.show()
        return button

    def _show_tone(self) -> None:
        sign, color, ground = _TONES[self.tone]
        self.sign.setVisible(bool(sign))
        if sign:
            self.sign.setPixmap(icons.pixmap(sign, 20, color, self.devicePixelRatioF()))
        dress(self, f"#strip {{ background: @{ground}; }} #strip > QLabel {{ color: @{color}; }}")
