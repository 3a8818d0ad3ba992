"""The main window with its parts, their layout and their connections."""

import gc
from pathlib import Path
from typing import TYPE_CHECKING, cast

from PySide6.QtCore import QEvent, QObject, Qt, QTimer, Signal
from PySide6.QtGui import QCloseEvent, QHideEvent, QKeyEvent, QResizeEvent, QShowEvent
from PySide6.QtWidgets import QAbstractButton, QApplication, QMainWindow, QWidget
from shiboken6 import isValid

from hapkit_studio import lab
from hapkit_studio.devices.hapkit import PACKET
from hapkit_studio.errors import ParameterError
from hapkit_studio.gui.editor.controller import EditorController, FileActions, FileWatcher
from hapkit_studio.gui.live.centre import Centre
from hapkit_studio.gui.live.comparison import RenderingComparison
from hapkit_studio.gui.live.dividers import Dividers
from hapkit_studio.gui.live.energy import EnergyWatch
from hapkit_studio.gui.live.export import LiveExport
from hapkit_studio.gui.live.live import Live
from hapkit_studio.gui.live.replay import Replay
from hapkit_studio.gui.live.replay_bar import ReplayBar
from hapkit_studio.gui.live.trigger_dialog import TriggerDialog
from hapkit_studio.gui.pages.measuring import MeasuringPage
from hapkit_studio.gui.pages.open_recording import RecordingOpener
from hapkit_studio.gui.pages.views import LIVE, Views
from hapkit_studio.gui.panel.parameter_panel import ParameterPanel
from hapkit_studio.gui.panel.preset_row import Presets
from hapkit_studio.gui.panel.two_settings import TwoSettings
from hapkit_studio.gui.shell.action_set import Action, ActionSet
from hapkit_studio.gui.shell.banners import BannerStack, Notice
from hapkit_studio.gui.shell.command_palette import CommandPalette, FindButton
from hapkit_studio.gui.shell.gallery import Gallery
from hapkit_studio.gui.shell.header import Header
from hapkit_studio.gui.shell.live_display import LiveDisplay
from hapkit_studio.gui.shell.menus import build_menus
from hapkit_studio.gui.shell.notices import Notices
from hapkit_studio.gui.shell.projector_view import Projector
from hapkit_studio.gui.shell.rail_names import RailNames
from hapkit_studio.gui.shell.recording_display import RecordingDisplay
from hapkit_studio.gui.shell.status_bar import StatusBar
from hapkit_studio.gui.shell.window_dialogs import KeysDialog, MarkerDialog, about_dialog, priority_dialog
from hapkit_studio.gui.shell.window_layout import WindowLayout
from hapkit_studio.gui.shell.window_state import WindowState
from hapkit_studio.gui.state.background import end_all
from hapkit_studio.gui.state.lock import ENTRY, Lock
from hapkit_studio.gui.state.own_environments import OwnEnvironments
from hapkit_studio.gui.state.stored import StoredSettings
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.gui.state.undo import UndoHistory
from hapkit_studio.gui.teach.blind import BlindComparison
from hapkit_studio.gui.teach.demo_player import CaptionBar, DemoPlayer
from hapkit_studio.gui.teach.demos import read as read_demo
from hapkit_studio.gui.teach.lock_dialog import LockDialog
from hapkit_studio.gui.teach.pointing import PointingExperiment
from hapkit_studio.gui.teach.quiz import Quiz
from hapkit_studio.gui.teach.threshold import ThresholdExperiment
from hapkit_studio.gui.widgets.canvas import Canvas
from hapkit_studio.gui.widgets.dialogs import text_dialog
from hapkit_studio.gui.widgets.numbers import NumberBox
from hapkit_studio.gui.widgets.parts import choose_file
from hapkit_studio.gui.widgets.theme import theme
from hapkit_studio.gui.wizard.flash_dialog import FlashDialog

if TYPE_CHECKING:
    from hapkit_studio.analysis.identify import Recording
    from hapkit_studio.gui.pages.lessons.page import LessonsPage

TOUR = "first_steps"
"""Key of the lesson that introduces the window in five minutes."""
_SMALLEST = (560, 350)
COLLECT_MS = 250
_MOUSE = (
    QEvent.Type.MouseButtonPress,
    QEvent.Type.MouseButtonRelease,
    QEvent.Type.MouseButtonDblClick,
    QEvent.Type.Wheel,
)
_PRESS, _OVERRIDE, _RELEASE = QEvent.Type.KeyPress, QEvent.Type.ShortcutOverride, QEvent.Type.KeyRelease


class MainWindow(QMainWindow):
    """The main window; its menus offer the given actions. ``closed`` is emitted before it closes."""

    closed = Signal()
    studio: Studio
    history: UndoHistory
    live: Live
    replay: Replay
    centre: Centre
    own: OwnEnvironments
    presets: Presets
    two: TwoSettings
    blind: BlindComparison
    quiz: Quiz
    pointing: PointingExperiment
    threshold: ThresholdExperiment
    display: LiveDisplay
    demos: DemoPlayer
    projector: Projector
    file_actions: FileActions
    editor: EditorController
    views: Views
    export: LiveExport
    opener: RecordingOpener
    single_keys: bool

    def __init__(
        self,
        studio: Studio,
        actions: tuple[Action["MainWindow"], ...],
        settings: StoredSettings | None = None,
    ):
        super().__init__()
        self.setWindowTitle("Hapkit Studio")
        self.setMinimumSize(*_SMALLEST)
        self.studio = studio
        studio.setParent(self)  # the studio's connections must end with the window
        Collector(self)
        self.settings = settings or StoredSettings()
        studio.device.padding = self.settings.choice("padding", 0, (0, PACKET))
        studio.permissions.lab = Lock(lab.settings().locked)
        studio.permissions.set_lock(self.settings.read(ENTRY, Lock(), Lock.read))
        self.body = WindowLayout(self, self.settings)
        self.history = UndoHistory(studio, self)
        self.live = Live(studio, self)
        self.replay = Replay(studio, self.live)
        Dividers(studio, self.live, self.history)
        self.own = OwnEnvironments(studio, self)
        self.header, self.gallery = Header(studio, self.body), Gallery(studio, self.own, self.body.inner)
        self.centre = Centre(self.settings, self.body.inner)
        self.editor = EditorController(studio, self.own, self)
        self.file_actions, self.file_watcher = (
            FileActions(self.editor, self),
            FileWatcher(studio, self.editor, self),
        )
        self.presets = Presets(studio, self.history, self)
        self.two = TwoSettings(studio, self.history, self)
        self.demos = DemoPlayer(studio, self)
        self.caption = CaptionBar(self.demos, self.body)
        self.panel = ParameterPanel(studio, self.presets, self.two, self.settings, self.body.side)
        self.loop, self.stability = self.panel.loop, self.panel.stability
        self.status, self.banners = StatusBar(self.body), BannerStack(self.body)
        self.replay_bar = ReplayBar(self.replay, self.live, self.body)
        self.display = LiveDisplay(
            studio, self.live, self.replay, self.centre, self.status, self.panel.warnings
        )
        self.notices = Notices(studio, self.live, self.banners)
        self.energy = EnergyWatch(studio, self.live, lambda: self.stability.calm, self.status.show_energy)
        self.status.energy.link.clicked.connect(lambda: studio.set_loop(controller=True))
        self.comparison = RenderingComparison(studio, self.live, self.centre, self.loop.where)
        self.single_keys = self.settings.flag("single_keys", True)
        theme.grid = self.settings.flag("grid", True)
        self.body.arrange(
            self.header, self.gallery, self.centre, self.panel, self.replay_bar, self.caption, self.status,
            self.banners,
        )  # fmt: skip
        self.setCentralWidget(self.body)
        self.gallery.order()
        self.panel.parameters.order()
        self.views = Views(
            studio, self.live, self.header.tabs, self.centre, self.editor, self.body.show_side,
            self.body.show_beside,
        )  # fmt: skip
        self.rail_names = RailNames(self.gallery, self.views, studio, self.settings, self)
        self.centre.scene.grabbed.connect(self.rail_names.dismiss)
        self.record_display = RecordingDisplay(
            studio.recording, self.live, self.header, self.status, self.banners,
            lambda: self.views.show("sessions"),
        )  # fmt: skip
        self.blind = BlindComparison(studio, self.two, self.views, self)
        self.quiz = Quiz(studio, self.stability, self.views, self)
        self.threshold = ThresholdExperiment(studio, self.views, self)
        self.pointing = PointingExperiment(studio, self.live, self.views, self.centre.scene, self)
        self.projector = Projector(
            self, self.body, studio, self.settings, self.header, self.centre, self.views
        )
        self.state = WindowState(studio, self.settings, self.views, self.presets, self.centre.trigger)
        self.export = LiveExport(studio, self.centre)
        self.export.succeeded.connect(self.record_display.show_message)
        self.export.failed.connect(lambda why: self.record_display.show_failure("No file was written.", why))
        self.opener = RecordingOpener(self)
        self.opener.opened.connect(self._hold_recording)
        self.opener.failed.connect(lambda why: self.record_display.show_failure("No curve was kept.", why))
        self.actions_by_key = ActionSet(self, actions, self.single_keys)
        build_menus(self.menuBar(), self.actions_by_key, studio, self.own)
        self.menuBar().setCornerWidget(FindButton(self.show_commands, self.menuBar()))
        self._in_lesson = False
        self._connect()
        self._keep_actions_fresh()

    # methods that the actions call

    @property
    def panel_open(self) -> bool:
        """Return whether the side panel is visible."""
        return not self.body.side.isHidden()

    def fit_axes(self) -> None:
        """Fit the axes of every plot to the shown data."""
        self.centre.time.fit()
        self.centre.phase.fit()

    def set_theme(self, mode: str) -> None:
        """Choose the theme and store it."""
        theme.set_mode(mode)
        self.settings.setValue("theme", mode)

    def toggle_panel(self) -> None:
        """Show or hide the parameter panel."""
        self.body.open_drawer(not self.panel_open)

    def toggle_single_keys(self) -> None:
        """Enable or disable the shortcuts without modifiers."""
        self.single_keys = not self.single_keys
        self.settings.setValue("single_keys", self.single_keys)
        self.actions_by_key.set_single_keys(self.single_keys)

    def toggle_grid(self) -> None:
        """Show or hide the grid of the plots."""
        theme.grid = not theme.grid
        self.settings.setValue("grid", theme.grid)
        for canvas in self.findChildren(Canvas):
            canvas.viewport().update()

    def quit(self) -> None:
        """Close the window; if a law is not saved, ask the user first."""
        if self.editor.ask_to_quit(self.close):
            self.close()

    def show_keys(self) -> None:
        """Open the dialog with the keys and the glossary."""
        KeysDialog(self.actions_by_key.entries, self).show()

    def show_law_language(self, word: str = "") -> None:
        """Open the reference of the law language at a word."""
        self.show_help("law", word=word)

    def show_help(self, page: str, word: str = "", section: str = "") -> None:
        """Open a page of the menu Help at a word or a section."""
        from hapkit_studio.gui.shell.help import page_dialog  # imported late because its layout takes time

        page_dialog(page, self, word, section).show()

    def show_lesson(self, key: str) -> None:
        """Open a lesson in the view of lessons."""
        self.views.show("lessons")
        page = cast("LessonsPage", self.views.page("lessons"))
        if self.views.key == "lessons":  # a quiz or an experiment may prevent the change of view
            page.open(key)

    def _forget_undo_of_lesson(self) -> None:
        """Clear the undo list when a lesson begins or ends, because the listed changes no longer apply."""
        page = self.views.built("lessons")
        if page is not None and page.stays != self._in_lesson:
            self._in_lesson = page.stays
            self.history.forget()

    def offer_tour(self) -> None:
        """Offer the tour in a banner; each of its buttons closes the banner."""

        def close(begin: bool) -> None:
            self.banners.set("tour", None)
            if begin:
                self.show_lesson(TOUR)

        buttons = ("Start the tour", lambda: close(True)), ("Not now", lambda: close(False))
        texts = (
            "A five-minute tour shows the window.",
            "The tour is also in the menu Help, under First steps.",
        )
        self.banners.set("tour", Notice("tour", 10, "accent", "info", *texts, buttons))

    def show_commands(self) -> None:
        """Open the command palette."""
        CommandPalette(self.actions_by_key, self).show()

    def show_priority(self) -> None:
        """Open the dialog on real-time priority."""
        if self.studio.engine is not None:
            priority_dialog(self.studio.engine.health().priority, self).show()

    def show_marker(self) -> None:
        """Open a dialog that adds a marker at the current time."""
        MarkerDialog(self.studio.recording, self.live, self).show()

    def show_lock(self) -> None:
        """Open the dialog that locks settings with a code, or unlocks them."""
        LockDialog(self.studio, self.settings, self).show()

    def show_trigger(self) -> None:
        """Open the dialog of the trigger's settings."""
        TriggerDialog(self.centre.trigger, self).show()

    def show_flash(self) -> None:
        """Open the dialog that writes the firmware to a board."""
        FlashDialog(self.studio, self).show()

    def show_export(self) -> None:
        """Open the dialog that writes the environment as an Arduino sketch."""
        from hapkit_studio.gui.shell.export_dialog import ExportDialog  # imported late to keep start-up fast

        ExportDialog(self.studio, self).show()

    def play_demo(self, path: str | Path) -> None:
        """Play a demo in the Live view, or show the error in its file."""
        try:
            self.demos.play(read_demo(path, self.studio.environments))
        except ParameterError as error:
            text_dialog(f"{Path(path).name}: no demo was played", str(error).splitlines(), self).show()
            return
        self.views.show(LIVE)
        self.live.set_paused(False)

    def open_demo(self) -> None:
        """Ask for a demo's file and play it."""
        choose_file(self, "Open demo", "Demos (*.toml)", self.play_demo)

    @property
    def has_picture(self) -> bool:
        """Return whether the visible view can be copied as a picture."""
        page = self.views.shown
        if isinstance(page, MeasuringPage):
            return page.bar.export.isEnabled()
        return (page is None or page.beside) and not self.centre.view.history.empty and not self.studio.hidden

    def copy_picture(self) -> None:
        """Copy the visible result or the live plots to the clipboard as a picture."""
        page = self.views.shown
        if isinstance(page, MeasuringPage):
            self.export.copy_picture(page.exports()[0])
        else:
            self.export.copy()

    def show_about(self) -> None:
        """Open the About dialog."""
        about_dialog(self).show()

    def _hold_recording(self, recording: "Recording", path: Path) -> None:
        """Show a recording from a file as kept curves in the Live view."""
        self.views.show(LIVE)
        self.display.hold_recording(recording, path)

    def _show_replay(self) -> None:
        """Show the Live view when a replay starts."""
        self.banners.set("replay", None)
        if self.replay.history is not None:
            self.views.show(LIVE)

    # events

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Move the focus from a number box to the view after Enter, unless the number was refused."""
        box = QApplication.focusWidget()
        accepted = isinstance(box, NumberBox) and not box.property("invalid")
        if accepted and event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            self.views.take_focus()
        else:
            super().keyPressEvent(event)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self.body.share()

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
            self.file_watcher.check_files()

    def closeEvent(self, event: QCloseEvent) -> None:
        """Ask about unsaved changes; then send a zero force and stop the loop before the window closes."""
        if event.spontaneous() and not self.editor.ask_to_quit(self.close):
            event.ignore()
            return
        self.replay.shut()
        self.views.end()  # first, because an open lesson restores settings that are saved below
        self.closed.emit()
        fills_screen = self.isMaximized() or self.isFullScreen()
        frameless = self.geometry() == self.frameGeometry() and not fills_screen
        self.settings.setValue("geometry", self.saveGeometry())
        self.settings.setValue("frameless", self.geometry() if frameless else None)
        self.settings.setValue("padding", self.studio.device.padding)
        self.live.stop()
        self.editor.end()
        end_all(self)
        self.studio.close()
        super().closeEvent(event)

    def _connect(self) -> None:
        self.header.pause_pressed.connect(self.live.toggle_paused)
        self.live.paused_changed.connect(self.header.show_paused)
        self.header.panel_pressed.connect(self.toggle_panel)
        self.views.changed.connect(self._forget_undo_of_lesson)
        self.notices.flash.connect(self.show_flash)
        self.notices.help_wanted.connect(lambda section: self.show_help("troubleshooting", section=section))
        self.gallery.new_pressed.connect(self.editor.begin_new)
        self.gallery.edit_pressed.connect(self.editor.edit)
        self.editor.page.help_pressed.connect(self.show_law_language)
        self.gallery.reveal_pressed.connect(self.file_actions.reveal)
        self.gallery.delete_pressed.connect(self.file_actions.delete)
        self.live.frame.connect(self.file_watcher.on_row)
        self.centre.toolbar.fit.clicked.connect(self.fit_axes)
        for canvas in self.findChildren(Canvas):
            canvas.addActions(self.actions_by_key.on_plots)
        self.stability.judged.connect(self.status.show_margin)
        self.stability.judged.connect(self.projector.card.show_verdict)
        self.stability.ask()
        self.live.health.connect(self.stability.note_health)
        self.status.how_to_fix.connect(self.show_priority)
        for signal in (self.history.changed, self.studio.hidden_changed):
            signal.connect(lambda: self.banners.set("undo", None))
        # the banner of a refused change is shown until a setting changes
        for signal in (self.history.refused, self.studio.refused):
            signal.connect(lambda why: self.banners.warn("undo", "Nothing was changed.", why))
        for taken in (self.centre.scene.grabbed, self.display.releasing):
            taken.connect(self.demos.end)
        for part in (self.demos, self.projector, self.quiz, self.pointing, self.threshold):
            self.closed.connect(part.end)
        self.replay.changed.connect(self._show_replay)
        self.replay.failed.connect(
            lambda why: self.banners.warn("replay", "The session cannot be replayed.", why)
        )
        for beginning in (self.replay.beginning, self.blind.beginning):
            beginning.connect(self.demos.end)
        self.centre.scene.setFocus(Qt.FocusReason.OtherFocusReason)
        application = QApplication.instance()
        assert application is not None
        self.stop_filter = StopFilter(self.studio, self.history, self)
        application.installEventFilter(self.stop_filter)

    def _keep_actions_fresh(self) -> None:
        """Refresh the actions whenever something changes that enables or disables them."""
        studio = self.studio
        for signal in (
            studio.environment_changed, studio.stop_changed, studio.link_changed, studio.hidden_changed,
            studio.lock_changed, self.live.paused_changed, self.editor.shown, self.centre.trigger.changed,
            self.two.changed, self.history.changed, self.demos.changed, self.replay.changed,
            self.views.changed,
        ):  # fmt: skip
            signal.connect(self.actions_by_key.refresh)


class StopFilter(QObject):
    """An event filter for the whole application.

    It is called for every event, so it ignores most events at once.

    Every Esc first stops the motor and then has its usual effect. With the simulated device, which has no
    motor, an Esc that closes a dialog or popup is no E-stop. Space on a button of the window is ignored,
    because Space is the pause key and must not press the focused button while the motor pushes. Every press
    and release starts a new gesture, whose changes become a separate undo step.
    """

    def __init__(self, studio: Studio, history: UndoHistory, window: QWidget):
        super().__init__(window)
        self._studio, self._history, self._window = studio, history, window

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        kind = event.type()
        if kind in _MOUSE:
            self._history.gesture += 1
        if kind not in (_PRESS, _OVERRIDE, _RELEASE) or not isinstance(event, QKeyEvent):
            return False
        self._history.gesture += kind != _RELEASE
        if event.key() == Qt.Key.Key_Escape and kind != _RELEASE:
            front = QApplication.activePopupWidget() or QApplication.activeWindow() or self._window
            moves = self._studio.opened is None or self._studio.opened.motor
            if not moves and front is not self._window and front.isVisible():
                QTimer.singleShot(0, self, lambda: self._stop_unless_closed(front))
            else:
                self._studio.stop()
        elif event.key() == Qt.Key.Key_Space and kind != _OVERRIDE and isinstance(watched, QAbstractButton):
            return watched.window() is self._window
        return False

    def _stop_unless_closed(self, front: QWidget) -> None:
        # stop if the dialog has refused to close, for example while it writes to a board
        if isValid(front) and front.isVisible():
            self._studio.stop()


class Collector(QObject):
    """Collects garbage by a timer in the window's thread; automatic collection is switched off.

    Automatic collection runs in whichever thread allocates: a thread that compiles a law would delete
    widgets, and Qt would crash. It stays off, because a collection during Qt's destructors causes a
    deadlock.
    """

    def __init__(self, parent: QObject):
        super().__init__(parent)
        gc.disable()
        timer = QTimer(self, interval=COLLECT_MS)
        timer.timeout.connect(collect)
        timer.start()


def collect() -> None:
    """Collect garbage of the oldest generation whose threshold is exceeded."""
    for generation in (2, 1, 0):
        if gc.get_count()[generation] > gc.get_threshold()[generation]:
            gc.collect(generation)
            return
