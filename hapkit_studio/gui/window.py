"""The main window: parts put together, room shared out, signals joined. Each part knows its own work."""

from PySide6.QtCore import QEvent, QSettings, Qt, Signal
from PySide6.QtGui import QCloseEvent, QHideEvent, QResizeEvent, QShowEvent
from PySide6.QtWidgets import QApplication, QGridLayout, QHBoxLayout, QMainWindow, QVBoxLayout, QWidget

from hapkit_studio.devices.hapkit import PACKET
from hapkit_studio.gui import actions, gallery
from hapkit_studio.gui.actions import ActionSet, table
from hapkit_studio.gui.banners import BannerStack
from hapkit_studio.gui.collector import Collector
from hapkit_studio.gui.dialogs import about_sheet, keys_sheet, priority_sheet
from hapkit_studio.gui.editor.controller import Desk, Files, Watch
from hapkit_studio.gui.flash_dialog import FlashSheet
from hapkit_studio.gui.gallery import Gallery
from hapkit_studio.gui.header import Header
from hapkit_studio.gui.live.centre import Centre
from hapkit_studio.gui.live.comparison import BothWays
from hapkit_studio.gui.live.display import Pictures
from hapkit_studio.gui.live.live import Live
from hapkit_studio.gui.notices import Notices, Passivity
from hapkit_studio.gui.own_environments import OwnEnvironments
from hapkit_studio.gui.panel import parameter_panel
from hapkit_studio.gui.panel.parameter_panel import ParameterPanel
from hapkit_studio.gui.status_bar import StatusBar
from hapkit_studio.gui.stop_filter import StopFilter
from hapkit_studio.gui.studio import Studio
from hapkit_studio.gui.views import Views
from hapkit_studio.gui.widgets.style import dress
from hapkit_studio.gui.widgets.theme import theme

_SMALLEST = (800, 560)
_SHEET = """
#header, #status, #gallery, #galleryBody, #panel, #panelBody { background: @side; }
#header { border-bottom: 1px solid @line; }
#status { border-top: 1px solid @line; }
#gallery { border-right: 1px solid @line; }
#panel { border: none; }
#panelBody { border-left: 1px solid @line; }
#centre { background: @canvas; }
QFrame[rule="true"] { background: @line; border: none; }
QLabel[role="section"] { color: @ink2; font-size: 12px; font-weight: 600; }
QLabel[role="error"] { color: @danger; font-size: 12px; }
QPushButton[resume="true"] { background: @accentsoft; border-color: @accent; }
"""
_ROOM_FOR_GALLERY = 880
_ROOM_BESIDE_PANEL = 1100
_DRAWER_BELOW = (1280, 640)


class MainWindow(QMainWindow):
    """The studio's one window; ``studio`` is what it works on. ``closed``: it is about to go."""

    closed = Signal()
    studio: Studio
    live: Live
    own: OwnEnvironments
    files: Files
    desk: Desk
    views: Views
    single_keys: bool

    def __init__(self, studio: Studio):
        super().__init__()
        self.setWindowTitle("Hapkit Studio")
        self.setMinimumSize(*_SMALLEST)
        self.studio = studio
        studio.setParent(self)  # its signals hold what they are connected to for as long as it lives
        Collector(self)
        self.settings = QSettings("hapkit-studio", "hapkit-studio")
        studio.padding = PACKET if self.settings.value("padding", 0, int) == PACKET else 0
        dress(self, _SHEET)  # what comes into a styled window is styled once
        self.room = Room(self)
        self.live = Live(studio, self)
        self.own = OwnEnvironments(studio, self)
        self.header, self.gallery = Header(studio, self.room), Gallery(studio, self.own, self.room)
        self.centre = Centre(self.room)
        self.desk = Desk(studio, self.own, self)
        self.files, self.watch = Files(self.desk, self), Watch(studio, self.desk, self)
        self.panel = ParameterPanel(studio, self.room)
        self.loop, self.stability = self.panel.loop, self.panel.stability
        self.status, self.banners = StatusBar(self.room), BannerStack(self.room)
        self.pictures = Pictures(studio, self.live, self.centre, self.status, self.panel.warnings)
        self.notices = Notices(studio, self.live, self.banners, self.stability)
        self.passivity = Passivity(studio, self.live, self.banners)
        self.both = BothWays(studio, self.live, self.centre, self.loop.where)
        self.single_keys = bool(self.settings.value("single_keys", True, bool))
        self._arrange()
        self.views = Views(self)
        self.actions_by_key = ActionSet(self, table(studio.environments.values()))
        actions.build_menus(self.menuBar(), self.actions_by_key, studio, self.own)
        self._connect()
        self._guard_keys()

    # what the actions call

    @property
    def span(self) -> float:
        """Return the time window in s."""
        return self.centre.time.span

    @property
    def theme_mode(self) -> str:
        """Return the theme as chosen, which may be the system's."""
        return theme.mode

    @property
    def panel_open(self) -> bool:
        """Say whether the parameter panel is seen."""
        return self.room.panel_open

    def set_span(self, seconds: float) -> None:
        """Show the last seconds."""
        self.centre.time.set_span(seconds)

    def fit_axes(self) -> None:
        """Narrow the axes of every plot to what is shown."""
        self.centre.time.fit()
        self.centre.phase.fit()

    def set_theme(self, mode: str) -> None:
        """Choose the theme and remember it."""
        theme.set_mode(mode)
        self.settings.setValue("theme", mode)

    def toggle_panel(self) -> None:
        """Show or hide the parameter panel."""
        self.room.open_drawer(not self.panel_open)

    def toggle_single_keys(self) -> None:
        """Let keys without modifiers act, or not."""
        self.single_keys = not self.single_keys
        self.settings.setValue("single_keys", self.single_keys)
        self.actions_by_key.set_single_keys(self.single_keys)

    def clear_fault(self) -> None:
        """Unlatch the fault."""
        self.studio.clear_fault()

    def quit(self) -> None:
        """Close the window, or first ask what becomes of a law that is not saved."""
        if self.desk.ask_to_quit(self.close):
            self.close()

    def show_keys(self) -> None:
        """Open the sheet of keys."""
        keys_sheet(self.actions_by_key.entries, self).show()

    def show_priority(self) -> None:
        """Open the sheet on real-time priority."""
        if self.studio.engine is not None:
            priority_sheet(self.studio.engine.health().priority, self).show()

    def show_flash(self) -> None:
        """Open the sheet that writes the firmware to a board."""
        FlashSheet(self.studio, self).show()

    def show_export(self) -> None:
        """Open the sheet that writes the environment as an Arduino sketch."""
        from hapkit_studio.gui.export_dialog import ExportSheet  # off the first picture's way

        ExportSheet(self.studio, self).show()

    def show_about(self) -> None:
        """Open the sheet on the studio itself."""
        about_sheet(self).show()

    # room and life

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self.room.share()

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        self.live.set_hidden(False)

    def hideEvent(self, event: QHideEvent) -> None:
        super().hideEvent(event)
        self.live.set_hidden(True)

    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)
        if event.type() == QEvent.Type.WindowStateChange:
            self.live.set_hidden(self.isMinimized() or not self.isVisible())
        elif event.type() == QEvent.Type.ActivationChange and self.isActiveWindow():
            self.watch.look_at_files()

    def closeEvent(self, event: QCloseEvent) -> None:
        """End the loop with its zero command before the window goes; ask first for what is not saved."""
        if event.spontaneous() and not self.desk.ask_to_quit(self.close):
            event.ignore()
            return
        self.closed.emit()
        self.settings.setValue("geometry", self.saveGeometry())
        self.settings.setValue("padding", self.studio.padding)
        self.live.stop()
        self.desk.end()
        self.views.end()
        self.stability.close_worker()
        self.loop.where.close_worker()
        self.studio.close()
        super().closeEvent(event)

    # putting together

    def _arrange(self) -> None:
        self.room.arrange()
        self.setCentralWidget(self.room)
        self.gallery.order()
        self.panel.parameters.order()

    def _guard_keys(self) -> None:
        application = QApplication.instance()
        assert application is not None
        self.stop_filter = StopFilter(self.studio.stop, self)
        application.installEventFilter(self.stop_filter)

    def _connect(self) -> None:
        self.header.pause_pressed.connect(self.live.toggle_paused)
        self.live.paused_changed.connect(self.header.show_paused)
        self.live.paused_changed.connect(lambda _on: self.actions_by_key.refresh())
        self.header.panel_pressed.connect(self.toggle_panel)
        self.banners.changed.connect(self.room.share)
        self.notices.flash.connect(self.show_flash)
        self.gallery.new_pressed.connect(self.desk.begin_new)
        self.gallery.edit_pressed.connect(self.desk.edit)
        self.gallery.reveal_pressed.connect(self.files.reveal)
        self.gallery.delete_pressed.connect(self.files.delete)
        self.live.frame.connect(self.watch.look_at_row)
        self.desk.shown.connect(lambda _on: self.actions_by_key.refresh())
        self.centre.toolbar.span_chosen.connect(self.set_span)
        self.centre.toolbar.fit_pressed.connect(self.fit_axes)
        self.stability.judged.connect(self.status.show_margin)
        self.stability.ask()
        self.live.health.connect(self.stability.note_health)
        self.status.how_to_fix.connect(self.show_priority)
        for signal in (self.studio.environment_changed, self.studio.stop_changed, self.studio.link_changed):
            signal.connect(self.actions_by_key.refresh)
        self.centre.scene.setFocus(Qt.FocusReason.OtherFocusReason)


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
