"""A sign and the answer in one sentence, above a chart."""

from PySide6.QtWidgets import QHBoxLayout, QLabel, QWidget

from hapkit_studio.gui.widgets import icons
from hapkit_studio.gui.widgets.style import dress
from hapkit_studio.gui.widgets.text import plain
from hapkit_studio.gui.widgets.theme import theme


class VerdictLine(QWidget):
    """Shows what it was told last; before that, what to do."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self._sign = ("circle", "ink2")
        self.sign, self.words = QLabel(), plain(QLabel())
        dress(self.words, "QLabel { font-size: 14px; font-weight: 650; }")
        self.words.setWordWrap(True)
        row = QHBoxLayout(self)
        row.setContentsMargins(16, 8, 16, 0)
        row.setSpacing(8)
        row.addWidget(self.sign)
        row.addWidget(self.words, 1)
        theme.changed.connect(self._look)
        self.say(text)

    def say(self, text: str, sign: str = "circle", token: str = "ink2") -> None:
        """Show a sign and words."""
        self.words.setText(text)
        self._sign = (sign, token)
        self._look()

    def outdate(self, text: str) -> None:
        """Show that what stands below is no longer so: neither right nor wrong."""
        self.say(text, "circle", "ink2")

    def _look(self) -> None:
        self.sign.setPixmap(icons.pixmap(self._sign[0], 18, self._sign[1], self.devicePixelRatioF()))
