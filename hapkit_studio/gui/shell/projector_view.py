"""Switches the window between its usual view and the projector view."""

from PySide6.QtCore import QObject, QSettings, Qt
from PySide6.QtWidgets import QMainWindow, QToolButton

from hapkit_studio.gui.live.centre import Centre
from hapkit_studio.gui.pages.views import LIVE, Views
from hapkit_studio.gui.shell.header import Header
from hapkit_studio.gui.shell.window_layout import WindowLayout
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.gui.teach.projector import Title, ValueCard
from hapkit_studio.gui.widgets import icons
from hapkit_studio.gui.widgets.theme import theme

THEME = "contrast"


class Projector(QObject):
    """Switches to the projector view, and back to the previous view, theme and window state."""

    on: bool

    def __init__(
        self,
        window: QMainWindow,
        layout: WindowLayout,
        studio: Studio,
        settings: QSettings,
        header: Header,
        centre: Centre,
        views: Views,
    ):
        super().__init__(window)
        self._window, self._layout = window, layout
        self._header, self._centre, self._views = header, centre, views
        self.on = False
        self._before = window.windowState(), theme.mode, LIVE
        self.card = ValueCard(studio, settings)
        self.title = Title(studio)
        self.leave = QToolButton()
        self.leave.setToolTip("Leave the projector view (F11)")
        self.leave.setAccessibleName("Leave the projector view")
        self.leave.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        icons.bind(self.leave, "close", "ink2", 18)
        self.leave.clicked.connect(self.toggle)
        header.add_projector_parts(self.title, self.leave)
        centre.add_values_card(self.card)

    def toggle(self) -> None:
        """Switch the projector view on, or restore the previous view."""
        window = self._window
        self.on = not self.on
        if self.on:
            self._before = window.windowState(), theme.mode, self._views.key
        state, mode, view = self._before
        window.menuBar().setVisible(not self.on)
        self._header.project(self.on)
        self._centre.project(self.on)
        self._layout.projected = self.on
        with theme.together():
            self._layout.set_scale()
            if self.on:
                theme.set_mode(THEME)
            elif theme.mode == THEME:  # keep another theme that the user has chosen meanwhile
                theme.set_mode(mode)
        self._views.show(LIVE if self.on else view)
        window.setWindowState(window.windowState() | Qt.WindowState.WindowFullScreen if self.on else state)
        self._layout.share()

    def end(self) -> None:
        """Leave the projector view if it is on."""
        if self.on:
            self.toggle()
