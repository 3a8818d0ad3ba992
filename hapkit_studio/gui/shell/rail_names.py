"""The environments' names beside the narrow gallery; they are a hint at the first start."""

from PySide6.QtCore import QEvent, QObject, QPoint, QRect, Qt
from PySide6.QtGui import QFontMetricsF, QMouseEvent, QPainter, QPaintEvent
from PySide6.QtWidgets import QWidget

from hapkit_studio.gui.pages.views import LIVE, Views
from hapkit_studio.gui.shell.gallery import Gallery
from hapkit_studio.gui.state.stored import StoredSettings
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.gui.widgets.gallery_row import GalleryRow
from hapkit_studio.gui.widgets.theme import theme

_PAD = 10  # px: horizontal padding of the names
_CHOSEN = "environment_chosen"  # key of the setting that is True once the user has selected an environment


class RailNames(QWidget):
    """Shows the names in the view Live while the gallery is narrow, until an environment is selected once.

    A click on a name selects its environment. Any other click hides the names until the next start.
    """

    def __init__(
        self, gallery: Gallery, views: Views, studio: Studio, settings: StoredSettings, window: QWidget
    ):
        super().__init__(window)
        self.setCursor(Qt.CursorShape.PointingHandCursor)
        self._gallery, self._views, self._studio, self._settings = gallery, views, studio, settings
        self._wanted = not settings.flag(_CHOSEN, False)
        gallery.installEventFilter(self)
        gallery.verticalScrollBar().valueChanged.connect(self.update)
        views.changed.connect(self.refresh)
        theme.changed.connect(self.refresh)
        studio.environment_changed.connect(self._forget)
        self.refresh()

    def refresh(self) -> None:
        """Show the names beside the gallery if the hint is still needed."""
        gallery, window = self._gallery, self.window()
        shown = self._wanted and self._views.key == LIVE and not self._views.covered
        shown = shown and gallery.rail and gallery.isVisible()
        if shown:
            metrics = QFontMetricsF(theme.font("strong"))
            widest = max(metrics.horizontalAdvance(row.title) for row in gallery.rows.values())
            corner = gallery.mapTo(window, QPoint(gallery.width(), 0))
            self.setGeometry(corner.x(), corner.y(), int(widest) + 2 * theme.px(_PAD) + 2, gallery.height())
            self.raise_()
        self.setVisible(shown)
        self.update()

    def dismiss(self) -> None:
        """Hide the names until the next start."""
        self._wanted = False
        self.refresh()

    def _forget(self) -> None:
        """Hide the names permanently after the user selects an environment."""
        if self.window().isVisible():  # the window is hidden while the start restores the stored environment
            self._settings.setValue(_CHOSEN, True)
            self.dismiss()

    def _places(self) -> list[tuple[GalleryRow, QRect]]:
        """Return the gallery's rows and the boxes of their names."""
        return [
            (row, QRect(0, row.mapTo(self._gallery, QPoint()).y(), self.width() - 1, row.height()))
            for row in self._gallery.rows.values()
        ]

    def mousePressEvent(self, event: QMouseEvent) -> None:
        at = event.position().toPoint()
        chosen = next((row for row, box in self._places() if box.contains(at)), None)
        if chosen is not None:
            chosen.click()
        self.dismiss()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        if event.type() in (QEvent.Type.Resize, QEvent.Type.Move, QEvent.Type.Show, QEvent.Type.Hide):
            self.refresh()
        return super().eventFilter(watched, event)

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.fillRect(self.rect(), theme.color("line"))
        painter.fillRect(self.rect().adjusted(0, 0, -1, 0), theme.color("side"))
        painter.setFont(theme.font("strong"))
        for row, box in self._places():
            if row.isChecked():
                painter.fillRect(box, theme.color("accentsoft"))
            painter.setPen(theme.color("accent" if row.isChecked() else "ink"))
            text_box = box.adjusted(theme.px(_PAD), 0, 0, 0)
            painter.drawText(text_box, Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignLeft, row.title)
