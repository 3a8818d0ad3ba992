"""A header button: icon, word, and the key that does the same."""

from PySide6.QtCore import QSize, Qt
from PySide6.QtWidgets import QHBoxLayout, QLabel, QPushButton, QWidget

from hapkit_studio.gui import icons
from hapkit_studio.gui.dress import dress
from hapkit_studio.gui.theme import theme

_CAP = (
    "QLabel { color: @TOKEN; border: 1px solid @TOKEN; border-radius: 4px; padding: 0 5px; font-size: 12px; }"
)


class CapButton(QPushButton):
    """A push button laid out from parts, so that its size follows all of them."""

    word_style = "font-weight: 600;"

    def __init__(self, icon: str, text: str, key: str, height: int = 34, parent: QWidget | None = None):
        super().__init__(parent)
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.setFixedHeight(height)
        self.picture, self.word, self.cap = QLabel(), QLabel(text), QLabel(key)
        self._row = row = QHBoxLayout(self)
        row.setContentsMargins(14, 0, 12, 0)
        row.setSpacing(8)
        for part in (self.picture, self.word, self.cap):
            part.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
            row.addWidget(part, 0, Qt.AlignmentFlag.AlignVCenter)
        self._icon, self._color, self._cap_color = icon, "ink", "ink3"
        theme.changed.connect(self.show_look)
        self.show_look()

    def set_look(self, icon: str, text: str, color: str, cap_color: str = "ink3") -> None:
        """Change icon, word, the colour token of both and that of the key cap."""
        self._icon, self._color, self._cap_color = icon, color, cap_color
        self.word.setText(text)
        self.show_look()

    def set_cap(self, visible: bool) -> None:
        """Show the key cap, or leave it out where room is short."""
        self.cap.setVisible(visible)
        self.updateGeometry()

    def show_look(self) -> None:
        """Paint the parts in the theme in force."""
        self.picture.setPixmap(icons.pixmap(self._icon, 18, self._color, self.devicePixelRatioF()))
        dress(self.word, f"QLabel {{ color: @{self._color}; {self.word_style} }}")
        dress(self.cap, _CAP.replace("TOKEN", self._cap_color))

    def sizeHint(self) -> QSize:
        return QSize(self._row.sizeHint().width() + 4, self.height())

    def minimumSizeHint(self) -> QSize:
        return self.sizeHint()
