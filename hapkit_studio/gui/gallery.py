"""The gallery: every environment with icon, title, one line and key; a narrow rail where room is short."""

from functools import lru_cache

from PySide6.QtCore import QRectF, QSize, Qt
from PySide6.QtGui import QFontMetrics, QPainter, QPaintEvent, QPen, QPixmap
from PySide6.QtWidgets import QAbstractButton, QButtonGroup, QLabel, QScrollArea, QVBoxLayout, QWidget

from hapkit_studio.environments.base import Environment
from hapkit_studio.gui import icons
from hapkit_studio.gui.studio import Studio
from hapkit_studio.gui.theme import theme

WIDE, RAIL = 228, 64
_ROW, _RAIL_ROW = 51, 45


def icon_name(scene: str) -> str:
    """Return the icon of a scene; environments from elsewhere may have none."""
    return scene if scene in icons.names() else "circle"


@lru_cache(maxsize=64)
def _picture(scene: str, _shade: str, color: str, ratio: float) -> QPixmap:
    return icons.pixmap(icon_name(scene), 24, color, ratio)


class GalleryRow(QAbstractButton):
    """One environment; checked while it is in force."""

    def __init__(self, environment: Environment, parent: QWidget | None = None):
        super().__init__(parent)
        self.environment = environment
        self.setCheckable(True)
        # a click leaves the arrow keys with the scene, where they move the hand
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.setAccessibleName(f"{environment.title}: {environment.summary}")
        self.setCursor(Qt.CursorShape.PointingHandCursor)
        self.set_rail(False)
        theme.changed.connect(self.update)

    def set_rail(self, rail: bool) -> None:
        """Draw icon and key alone, title and summary as a tooltip."""
        self._rail = rail
        self.setFixedHeight(_RAIL_ROW if rail else _ROW)
        self.setToolTip(f"{self.environment.title}: {self.environment.summary}" if rail else "")
        self.update()

    def sizeHint(self) -> QSize:
        if self._rail:
            return QSize(RAIL, _RAIL_ROW)
        words = max(
            self._metrics("strong", self.environment.title), self._metrics("hint", self.environment.summary)
        )
        return QSize(48 + words + (36 if self.environment.shortcut else 8), _ROW)

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        if self.isChecked() or self.underMouse():
            painter.fillRect(self.rect(), theme.color("accentsoft" if self.isChecked() else "line"))
        if self.isChecked():
            painter.fillRect(0, 0, 3, self.height(), theme.color("accent"))
        color = "accent" if self.isChecked() else "ink"
        self._paint_icon(painter, color)
        if not self._rail:
            self._paint_words(painter, color)
        self._paint_key(painter)
        if self.hasFocus():
            painter.setPen(QPen(theme.color("accent"), 2))
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.drawRoundedRect(QRectF(self.rect()).adjusted(4, 3, -4, -3), 6, 6)

    def _paint_icon(self, painter: QPainter, color: str) -> None:
        picture = _picture(self.environment.scene, theme.color(color).name(), color, self.devicePixelRatioF())
        painter.drawPixmap(12 if self._rail else 13, (self.height() - 24) // 2, picture)

    def _paint_words(self, painter: QPainter, color: str) -> None:
        painter.setPen(theme.color(color))
        painter.setFont(theme.font("strong"))
        painter.drawText(
            QRectF(48, 7, self.width() - 80, 20), Qt.AlignmentFlag.AlignVCenter, self.environment.title
        )
        painter.setPen(theme.color("ink3"))
        painter.setFont(theme.font("hint"))
        summary = self.environment.summary
        painter.drawText(QRectF(48, 26, self.width() - 80, 18), Qt.AlignmentFlag.AlignVCenter, summary)

    def _paint_key(self, painter: QPainter) -> None:
        key = self.environment.shortcut
        if not key:
            return
        painter.setFont(theme.font("hint"))
        if self._rail:
            painter.setPen(theme.color("ink2"))
            painter.drawText(QRectF(39, 0, 20, self.height()), Qt.AlignmentFlag.AlignCenter, key)
            return
        box = QRectF(self.width() - 32.5, self.height() / 2 - 10, 19, 20)
        painter.setPen(QPen(theme.color("line"), 1))
        painter.setBrush(theme.color("surface"))
        painter.drawRoundedRect(box, 4, 4)
        painter.setPen(theme.color("ink3"))
        painter.drawText(box, Qt.AlignmentFlag.AlignCenter, key)

    @staticmethod
    def _metrics(role: str, text: str) -> int:
        return QFontMetrics(theme.font(role)).horizontalAdvance(text) + 2


class Gallery(QScrollArea):
    """The list of environments; a click switches at once."""

    def __init__(self, studio: Studio, parent: QWidget | None = None):
        super().__init__(parent)
        self._studio = studio
        self.setObjectName("gallery")
        self.setWidgetResizable(True)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.heading = QLabel("Environments")
        self.heading.setProperty("role", "section")
        self.heading.setContentsMargins(14, 10, 14, 6)
        self.rows = {key: GalleryRow(environment) for key, environment in studio.environments.items()}
        self._group = QButtonGroup(self)
        self._arrange()
        studio.environment_changed.connect(self.show_state)
        self.set_rail(False)
        self.show_state()

    def set_rail(self, rail: bool) -> None:
        """Switch between the list and the rail."""
        self.rail = rail
        self.setFixedWidth(RAIL if rail else WIDE)
        self.heading.setVisible(not rail)
        for row in self.rows.values():
            row.set_rail(rail)

    def show_state(self) -> None:
        """Mark the environment in force."""
        self.rows[self._studio.environment.key].setChecked(True)

    def _arrange(self) -> None:
        body = QWidget()
        body.setObjectName("galleryBody")
        column = QVBoxLayout(body)
        column.setContentsMargins(0, 0, 0, 8)
        column.setSpacing(0)
        column.addWidget(self.heading)
        for key, row in self.rows.items():
            self._group.addButton(row)
            column.addWidget(row)
            row.clicked.connect(lambda _on=False, key=key: self._studio.choose(key))
        column.addStretch(1)
        self.setWidget(body)
