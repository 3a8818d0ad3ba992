"""A row of the gallery with icon, title, summary and shortcut.

On a narrow rail, the row has only an icon and a shortcut.
"""

from PySide6.QtCore import QRectF, QSize, Qt
from PySide6.QtGui import QFont, QFontMetrics, QKeyEvent, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QAbstractButton, QSizePolicy

from hapkit_studio.gui.widgets import breakpoints, icons
from hapkit_studio.gui.widgets.text import plain_tip
from hapkit_studio.gui.widgets.theme import theme

ROW, RAIL_ROW = 51, 42  # px: height of a row in the gallery and on the rail
LEAST_ROW, LEAST_RAIL_ROW = 42, 34
_ICON, _LEFT, _RIGHT = 10, 41, 30  # px: left edges of icon and text; width of the shortcut
_EDGES = 2
_PALE = 0.45  # opacity of a row that is not available yet
_TIGHT = -0.5


def icon_name(scene: str) -> str:
    """Return the icon of a scene; environments of other packages have a plain icon."""
    return scene if scene in icons.names() else "circle"


class GalleryRow(QAbstractButton):
    """A row of the gallery; it is checked while its environment is active.

    ``color`` is the colour token of icon and title.
    """

    def __init__(self, icon: str, title: str, summary: str, key: str = "", color: str = "ink"):
        super().__init__()
        self.key, self.color = key, color
        self.rail, self.waiting = False, ""
        self.setCheckable(True)
        # With TabFocus, a click leaves the focus to the scene, where the arrow keys move the hand.
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.setCursor(Qt.CursorShape.PointingHandCursor)
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Fixed)  # a title may be truncated
        self.setFixedHeight(ROW)
        self.set_text(icon, title, summary)
        theme.changed.connect(self.update)

    def set_text(self, icon: str, title: str, summary: str, waiting: str = "") -> None:
        """Set icon and texts. ``waiting`` says why the environment is not available yet.

        The icon and the shortcut of a waiting row are pale.
        """
        self.picture, self.title, self.summary, self.waiting = icon, title, summary, waiting
        text = waiting or summary
        self.setAccessibleName(f"{title}: {text}" if text else title)
        self._show_tip()
        self.update()

    def set_rail(self, rail: bool, height: int) -> None:
        """Set the height; on a rail, show icon and key only, and title and summary as a tooltip."""
        self.rail = rail
        self.setFixedHeight(height)
        self._show_tip()
        self.update()

    def _show_tip(self) -> None:
        self.setToolTip(plain_tip(self.accessibleName() if self.rail else self.long_tip()))

    def long_tip(self) -> str:
        """Return the tooltip with title and summary."""
        return ""

    def sizeHint(self) -> QSize:
        if self.rail:
            return QSize(theme.px(breakpoints.RAIL) - _EDGES, theme.px(LEAST_RAIL_ROW))
        lines = (("strong", self.title), ("hint", self.summary))
        wide = max(QFontMetrics(theme.font(role)).horizontalAdvance(text) for role, text in lines)
        return QSize(wide + 2 + theme.px(_LEFT + (_RIGHT if self.key else 8)), theme.px(LEAST_ROW))

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Choose the environment with Enter, because Space is the pause key."""
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
            self._paint_text(painter, color)
        if self.hasFocus():
            painter.setPen(QPen(theme.color("accent"), 2))
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.drawRoundedRect(QRectF(self.rect()).adjusted(4, 3, -4, -3), 6, 6)

    def _paint_icon(self, painter: QPainter, color: str) -> None:
        size = theme.px(24)
        picture = icons.pixmap(self.picture, size, color, self.devicePixelRatioF())
        painter.drawPixmap(theme.px(12 if self.rail else _ICON), (self.height() - size) // 2, picture)

    def _paint_text(self, painter: QPainter, color: str) -> None:
        middle = Qt.AlignmentFlag.AlignVCenter
        left, px = theme.px(_LEFT), theme.px
        room = self.width() - left - px(_RIGHT if self.key else 8)
        top = (self.height() - px(37)) // 2
        text = self.waiting or self.summary
        lines = [("strong", color, self.title, top, px(20)), ("hint", "ink3", text, top + px(19), px(18))]
        if not text:
            lines = [("body", color, self.title, 0, self.height())]
        for role, token, text, top, height in lines:
            font = theme.font(role)
            if (
                QFontMetrics(font).horizontalAdvance(text) > room
            ):  # with normal spacing, the text would be cut off
                font.setLetterSpacing(QFont.SpacingType.AbsoluteSpacing, _TIGHT)
            painter.setPen(theme.color(token))
            painter.setFont(font)
            text = painter.fontMetrics().elidedText(text, Qt.TextElideMode.ElideRight, room)
            painter.drawText(QRectF(left, top, room, height), middle, text)

    def _paint_key(self, painter: QPainter) -> None:
        painter.setFont(theme.font("hint"))
        if self.rail:
            painter.setPen(theme.color("ink2"))
            column = QRectF(theme.px(39), 0, theme.px(20), self.height())
            painter.drawText(column, Qt.AlignmentFlag.AlignCenter, self.key)
            return
        high = theme.px(20)
        box = QRectF(self.width() - theme.px(26) - 0.5, (self.height() - high) / 2, theme.px(19), high)
        painter.setPen(QPen(theme.color("line"), 1))
        painter.setBrush(theme.color("surface"))
        painter.drawRoundedRect(box, 4, 4)
        painter.setPen(theme.color("ink3"))
        painter.drawText(box, Qt.AlignmentFlag.AlignCenter, self.key)
