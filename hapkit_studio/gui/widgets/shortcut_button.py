"""A button with an icon, a text, and its shortcut as a key cap."""

from PySide6.QtCore import QSize, Qt
from PySide6.QtWidgets import QLabel, QPushButton, QWidget

from hapkit_studio.gui.widgets import icons
from hapkit_studio.gui.widgets.parts import hbox
from hapkit_studio.gui.widgets.style import mark
from hapkit_studio.gui.widgets.theme import theme


class ShortcutButton(QPushButton):
    """A push button that contains a layout, so that its size follows from the widgets in it."""

    word_role = "button"

    def __init__(self, icon: str, text: str, key: str, parent: QWidget | None = None):
        super().__init__(parent)
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.setProperty("tall", True)
        self.picture, self.word, self.cap = QLabel(), QLabel(text), QLabel(key)
        self.word.setProperty("role", self.word_role)
        self.cap.setProperty("role", "key")
        parts = (self.picture, self.word, self.cap)
        for part in parts:
            part.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self._row = hbox(*parts, into=self)
        for part in parts:
            self._row.setAlignment(part, Qt.AlignmentFlag.AlignVCenter)
        self._icon, self._color, self._cap_color = icon, "ink", "ink3"
        theme.changed.connect(self.refresh)
        self.refresh()

    def set_appearance(self, icon: str, text: str, color: str, cap_color: str = "ink3") -> None:
        """Set the icon, the text and their colour token, and the colour token of the key cap."""
        self._icon, self._color, self._cap_color = icon, color, cap_color
        self.word.setText(text)
        self.refresh()

    @property
    def cap_width(self) -> int:
        """Return the width in px that the key cap adds to the button."""
        return self.cap.sizeHint().width() + self._row.spacing()

    def set_cap(self, visible: bool) -> None:
        """Show or hide the key cap."""
        self.cap.setVisible(visible)
        self.updateGeometry()

    def refresh(self) -> None:
        """Apply the current theme to the parts."""
        scale = min(theme.scale, 1.0)  # a scale of at most 1 saves width in a projector's header
        self._row.setContentsMargins(round(14 * scale), 0, round(12 * scale), 0)
        self._row.setSpacing(round(8 * scale))
        self.picture.setPixmap(icons.pixmap(self._icon, theme.px(18), self._color, self.devicePixelRatioF()))
        mark(self.word, "ink", self._color)
        mark(self.cap, "ink", self._cap_color)

    def sizeHint(self) -> QSize:
        return QSize(self._row.sizeHint().width() + 4, super().sizeHint().height())

    def minimumSizeHint(self) -> QSize:
        return self.sizeHint()
