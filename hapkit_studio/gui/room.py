"""Where the window's parts stand, and what gives way where there is little room."""

from typing import TYPE_CHECKING

from PySide6.QtWidgets import QGridLayout, QHBoxLayout, QVBoxLayout, QWidget

from hapkit_studio.gui import gallery, parameter_panel

if TYPE_CHECKING:
    from hapkit_studio.gui.window import MainWindow

_ROOM_FOR_GALLERY = 880
_ROOM_BESIDE_PANEL = 1100
_DRAWER_BELOW = (1280, 640)


class Room(QWidget):
    """Holds the parts; the panel is a drawer where the window is small, opened and closed by hand."""

    def __init__(self, window: "MainWindow"):
        super().__init__(window)
        self._window = window
        self._drawer_open: bool | None = None
        self._middle = QGridLayout()

    def arrange(self) -> None:
        """Give the window's parts their places; each was made inside the room."""
        window = self._window
        self._side: QWidget = window.panel
        left = QHBoxLayout()
        left.setSpacing(0)
        left.addWidget(window.gallery)
        left.addWidget(window.centre, 1)
        self._middle.setSpacing(0)
        self._middle.addLayout(left, 1, 0)
        self._middle.setRowStretch(1, 1)
        self._middle.setColumnStretch(0, 1)
        self._place_banners(False)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addWidget(window.header)
        column.addLayout(self._middle, 1)
        column.addWidget(window.status)

    def open_drawer(self, on: bool) -> None:
        """Show or hide the panel, whatever the size."""
        self._drawer_open = on
        self.share()

    @property
    def panel_open(self) -> bool:
        """Say whether the panel, or what a page put in its place, is seen."""
        return not self._side.isHidden()

    def show_side(self, side: QWidget | None) -> None:
        """Put a page's own side in the panel's place, None for the panel."""
        self._side.hide()
        self._middle.removeWidget(self._side)
        self._side = side or self._window.panel
        self.share()

    def share(self) -> None:
        """Decide what gives way at this size."""
        parts = self._window
        width, height = parts.width(), parts.height()
        small = width < _DRAWER_BELOW[0] or height < _DRAWER_BELOW[1]
        parts.header.panel.setVisible(small)
        rail = width - gallery.WIDE - parameter_panel.WIDE < _ROOM_FOR_GALLERY
        parts.gallery.set_rail(rail)
        parts.panel.set_room(rail, height)
        if self._side is not parts.panel:
            self._side.setFixedWidth(parts.panel.maximumWidth())
        wide = not small if self._drawer_open is None else self._drawer_open
        self._place_banners(width < _ROOM_BESIDE_PANEL and wide)
        self._side.setVisible(wide)
        used = parts.gallery.width() + (self._side.width() if wide else 0)
        bars = parts.menuBar().height() + parts.header.height() + parts.status.height() + parts.banners.room
        parts.centre.set_room(width - used, height - bars)
        parts.views.set_room(width - used, height - bars)
        column = self.layout()
        if column is not None:
            column.activate()  # at once: else a frame is painted with parts of two sizes

    def _place_banners(self, over_panel: bool) -> None:
        """Put the banners beside the panel, so that a slider being dragged stays put; above it if narrow."""
        banners, panel = self._window.banners, self._side
        for widget in (banners, panel):
            self._middle.removeWidget(widget)
        self._middle.addWidget(banners, 0, 0, 1, 2 if over_panel else 1)
        self._middle.addWidget(panel, int(over_panel), 1, 1 if over_panel else 2, 1)
