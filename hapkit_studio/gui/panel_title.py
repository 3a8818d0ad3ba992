"""The panel's head: icon, title and formula of the environment; "?" unfolds its explanation."""

from PySide6.QtCore import Qt
from PySide6.QtGui import QFont, QFontMetricsF, QResizeEvent
from PySide6.QtWidgets import QHBoxLayout, QLabel, QToolButton, QVBoxLayout, QWidget

from hapkit_studio.gui import icons
from hapkit_studio.gui.gallery import icon_name
from hapkit_studio.gui.rich import plain, rich
from hapkit_studio.gui.studio import Studio
from hapkit_studio.gui.theme import theme

_SMALLEST = 14  # px: below that a title rather takes two lines


class Title(QLabel):
    """Words in the title's font, smaller where the line would be too short for them."""

    def __init__(self, parent: QWidget | None = None):
        super().__init__(parent)
        plain(self).setWordWrap(True)

    def show_words(self, words: str) -> None:
        """Show other words."""
        self.setText(words)
        self._fit()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()

    def _fit(self) -> None:
        font = theme.font("title")
        while font.pixelSize() > _SMALLEST and self._needed(font) > self.width():
            font.setPixelSize(font.pixelSize() - 1)
        if font != self.font():
            self.setFont(font)

    def _needed(self, font: QFont) -> float:
        return QFontMetricsF(font).horizontalAdvance(self.text()) + 1.0


class PanelTitle(QWidget):
    """Icon, title and formula of the environment in force; "?" unfolds the explanation."""

    def __init__(self, studio: Studio, parent: QWidget | None = None):
        super().__init__(parent)
        self._studio = studio
        self.picture = QLabel()
        self.title = Title()
        self.formula = QLabel(textFormat=Qt.TextFormat.RichText)
        self.formula.setWordWrap(True)
        self.explanation = QLabel(textFormat=Qt.TextFormat.RichText)
        self.explanation.setWordWrap(True)
        self.explanation.setProperty("role", "hint")
        self.explanation.hide()
        self.help = QToolButton()
        self.help.setCheckable(True)
        self.help.setAccessibleName("Explain this environment")
        self.help.setToolTip("Explain this environment")
        self.help.toggled.connect(self.explanation.setVisible)
        icons.bind(self.help, "help", "ink2", 18)
        self._arrange()
        studio.environment_changed.connect(self.show_state)
        theme.changed.connect(self.show_state)
        self.show_state()

    def show_state(self) -> None:
        """Show the environment in force."""
        environment = self._studio.environment
        name = icon_name(environment.scene)
        self.picture.setPixmap(icons.pixmap(name, 24, "ink", self.devicePixelRatioF()))
        self.title.show_words(environment.title)
        upright = theme.font("formula")
        upright.setItalic(False)  # the formula itself says what is a symbol, so its words stay upright
        self.formula.setFont(upright)
        self.formula.setText(rich(environment.formula))
        self.explanation.setText(rich(environment.explanation))

    def _arrange(self) -> None:
        head = QHBoxLayout()
        head.setSpacing(6)
        head.addWidget(self.picture)
        head.addWidget(self.title, 1)
        head.addWidget(self.help)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(4)
        column.addLayout(head)
        column.addWidget(self.formula)
        column.addWidget(self.explanation)
