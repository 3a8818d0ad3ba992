"""Rows of the gallery: an icon, a title, one line and a key; in a narrow rail icon and key alone."""

from functools import lru_cache

from PySide6.QtCore import QRectF, QSize, Qt
from PySide6.QtGui import QFont, QFontMetrics, QKeyEvent, QPainter, QPaintEvent, QPen, QPixmap
from PySide6.QtWidgets import QAbstractButton, QSizePolicy, QWidget

from hapkit_studio.gui import icons
from hapkit_studio.gui.rich import plain_tip
from hapkit_studio.gui.theme import theme

WIDE, RAIL = 228, 64
ROW, RAIL_ROW = 51, 42
LEAST_ROW, LEAST_RAIL_ROW = 42, 34
_ICON, _LEFT, _RIGHT = 10, 41, 30
_EDGES = 2
_PALE = 0.45
_TIGHT = -0.5


def icon_name(scene: str) -> str:
    """Return the icon of a scene; environments from elsewhere may have none."""
    return scene if scene in icons.names() else "circle"


@lru_cache(maxsize=64)
def _picture(icon: str, _shade: str, color: str, ratio: float) -> QPixmap:
    return icons.pixmap(icon, 24, color, ratio)


class GalleryRow(QAbstractButton):
    """One line of the gallery; checked while it is in force. ``color`` is the token of icon and title."""

    color = "ink"

    def __init__(self, icon: str, title: str, summary: str, key: str = "", parent: QWidget | None = None):
        super().__init__(parent)
        self.picture, self.title, self.summary, self.key = icon, title, summary, key
        self.waiting = ""
        self.setCheckable(True)
        # a click leaves the arrow keys with the scene, where they move the hand
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.setCursor(Qt.CursorShape.PointingHandCursor)
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Fixed)  # a title may be cut
        self._name()
        self.set_rail(False, ROW)
        theme.changed.connect(self.update)

    def set_words(self, icon: str, title: str, summary: str) -> None:
        """Show other words."""
        self.picture, self.title, self.summary = icon, title, summary
        self._name()
        self.set_rail(self.rail, self.height())

    def set_waiting(self, words: str) -> None:
        """Say why it cannot be had yet, in paler colours; "" if it can."""
        if words != self.waiting:
            self.waiting = words
            self._name()
            self.set_rail(self.rail, self.height())

    def set_rail(self, rail: bool, height: int) -> None:
        """Draw icon and key alone, title and summary as a tooltip; or all of it."""
        self.rail = rail
        self.setFixedHeight(height)
        self.setToolTip(plain_tip(self.accessibleName()) if rail else "")
        self.update()

    def sizeHint(self) -> QSize:
        if self.rail:
            return QSize(RAIL - _EDGES, LEAST_RAIL_ROW)
        words = max(self._width("strong", self.title), self._width("hint", self.summary))
        return QSize(_LEFT + words + (_RIGHT if self.key else 8), LEAST_ROW)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Let Enter choose: Space is the pause key."""
        if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            self.click()
        else:
            super().keyPressEvent(event)

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        if self.isChecked() or self.underMouse():
            painter.fillRect(self.rect(), theme.color("accentsoft" if self.isChecked() else "grid"))
        if self.isChecked():
            painter.fillRect(0, 0, 3, self.height(), theme.color("accent"))
        color = "accent" if self.isChecked() else self.color
        painter.setOpacity(_PALE if self.waiting else 1.0)
        self._paint_icon(painter, color)
        if self.key:
            self._paint_key(painter)
        painter.setOpacity(1.0)
        if not self.rail:
            self._paint_words(painter, color)
        if self.hasFocus():
            painter.setPen(QPen(theme.color("accent"), 2))
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.drawRoundedRect(QRectF(self.rect()).adjusted(4, 3, -4, -3), 6, 6)

    def _name(self) -> None:
        words = self.waiting or self.summary
        self.setAccessibleName(f"{self.title}: {words}" if words else self.title)

    def _paint_icon(self, painter: QPainter, color: str) -> None:
        picture = _picture(self.picture, theme.color(color).name(), color, self.devicePixelRatioF())
        painter.drawPixmap(12 if self.rail else _ICON, (self.height() - 24) // 2, picture)

    def _paint_words(self, painter: QPainter, color: str) -> None:
        middle = Qt.AlignmentFlag.AlignVCenter
        room = self.width() - _LEFT - (_RIGHT if self.key else 8)
        top = (self.height() - 37) // 2
        words = self.waiting or self.summary
        lines = [("strong", color, self.title, top, 20), ("hint", "ink3", words, top + 19, 18)]
        if not words:
            lines = [("body", color, self.title, 0, self.height())]
        for role, token, words, top, height in lines:
            painter.setPen(theme.color(token))
            painter.setFont(self._fitting(theme.font(role), words, room))
            words = painter.fontMetrics().elidedText(words, Qt.TextElideMode.ElideRight, room)
            painter.drawText(QRectF(_LEFT, top, room, height), middle, words)

    @staticmethod
    def _fitting(font: QFont, words: str, room: int) -> QFont:
        """Return a font with its letters closer together where the words would be cut otherwise."""
        if QFontMetrics(font).horizontalAdvance(words) > room:
            font.setLetterSpacing(QFont.SpacingType.AbsoluteSpacing, _TIGHT)
        return font

    def _paint_key(self, painter: QPainter) -> None:
        painter.setFont(theme.font("hint"))
        if self.rail:
            painter.setPen(theme.color("ink2"))
            painter.drawText(QRectF(39, 0, 20, self.height()), Qt.AlignmentFlag.AlignCenter, self.key)
            return
        box = QRectF(self.width() - 26.5, self.height() / 2 - 10, 19, 20)
        painter.setPen(QPen(theme.color("line"), 1))
        painter.setBrush(theme.color("surface"))
        painter.drawRoundedRect(box, 4, 4)
        painter.setPen(theme.color("ink3"))
        painter.drawText(box, Qt.AlignmentFlag.AlignCenter, self.key)

    @staticmethod
    def _width(role: str, text: str) -> int:
        return QFontMetrics(theme.font(role)).horizontalAdvance(text) + 2
