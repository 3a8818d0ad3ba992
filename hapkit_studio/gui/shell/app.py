"""Starts the application: theme, window and first frame, then the loop in the background."""

import argparse
import gc
import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from subprocess import Popen

from PySide6.QtCore import QObject, QRect, QSize, QTimer
from PySide6.QtWidgets import QApplication

from hapkit_studio import devices, interrupts, lab
from hapkit_studio.arguments import window_parser
from hapkit_studio.environments import named
from hapkit_studio.errors import ParameterError
from hapkit_studio.formatting import printable
from hapkit_studio.gui.shell.actions import new_window
from hapkit_studio.gui.shell.window import MainWindow
from hapkit_studio.gui.state import prepare
from hapkit_studio.gui.state.stored import LESSONS_FOLDER, StoredSettings
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.gui.teach import demos
from hapkit_studio.gui.widgets import style
from hapkit_studio.gui.widgets.dialogs import on_screen
from hapkit_studio.gui.widgets.theme import MODES, theme

FIRST_SIZE = 1440, 900
POLL_MS = 50
REST_MS = 1000  # ms: delay after the first sample before the remaining functions are compiled
_REJECTED = "Some stored settings cannot be used. Their default values are used instead."
_OFFERED = "tour_offered"  # key of the setting that is True once the tour was offered
SWITCH_SECONDS = 0.5e-3
"""Python's thread switch interval in s. While a thread translates a law for the board, drawing a picture
takes 0.09 s with this interval, but 0.7 s with Python's default of 5 ms."""


def run(argv: Sequence[str] | None = None, preparing: Popen | None = None) -> int:
    """Open the window and return the exit code; see ``window_parser`` for the options in ``argv``.

    ``preparing`` is a program that was started before Qt was imported and compiles the loop, or None.
    """
    options = window_parser().parse_args(list(sys.argv[1:] if argv is None else argv))
    application = QApplication.instance() or QApplication(["hapkit-studio"])
    assert isinstance(application, QApplication)
    application.setApplicationName("hapkit-studio")
    sys.setswitchinterval(SWITCH_SECONDS)
    application.setApplicationDisplayName("Hapkit Studio")
    style.apply(application)
    try:
        window = build(options)
    except ParameterError as error:
        print(printable(str(error)), file=sys.stderr)
        return 2
    window.show()
    came: list[int] = []

    def close(number: int, _frame: object) -> None:
        came.append(number)
        # close through the event loop, because a signal may arrive during a paint event
        QTimer.singleShot(0, window.close)

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, close)
    gc.freeze()  # modules and the window live until the end, so garbage collection can ignore them
    QTimer.singleShot(0, lambda: begin(window, options, preparing))
    code = application.exec()
    return interrupts.INTERRUPTED if signal.SIGINT in came else code


def _place(window: MainWindow, size: tuple[int, int] | None) -> None:
    """Set the window's size: the requested size, else the stored size, else a size that fits the screen."""
    if size is None and window.settings.geometry("geometry", window.restoreGeometry):
        # Qt reserves space for a frame, but this window manager does not draw one
        frameless = window.settings.value("frameless")
        if isinstance(frameless, QRect) and window.screen().availableGeometry().contains(frameless):
            window.setGeometry(frameless)
        return
    window.resize(QSize(*size) if size else on_screen(window, FIRST_SIZE))


def build(options: argparse.Namespace) -> MainWindow:
    """Return the window without opening a device; exit with a one-line message if an option is invalid.

    A banner names the stored settings that cannot be used.
    """
    settings = StoredSettings()
    theme.set_mode(options.theme or settings.choice("theme", "system", MODES))
    if options.lessons is not None:
        settings.setValue(LESSONS_FOLDER, str(options.lessons.absolute()))
    studio = Studio(devices.available)
    key = named(options.environment).key if options.environment is not None else None
    window = new_window(studio, settings)
    if key is None or studio.why_fixed("environment", key):
        window.state.restore()
    if key is not None:
        studio.choose(key)
    window.history.forget()
    if options.demo is not None:
        window.demos.play(demos.read(demos.named(options.demo), studio.environments))
    if not options.screenshot:
        window.closed.connect(window.state.save)
    _place(window, options.size)
    if not options.screenshot and (notice := window.settings.new_notice()):
        window.banners.warn("settings", _REJECTED, notice)
    shows_something = options.screenshot or options.demo is not None or options.replay is not None
    if not shows_something and not settings.contains(_OFFERED):
        settings.setValue(_OFFERED, True)
        window.offer_tour()
    return window


def begin(window: MainWindow, options: argparse.Namespace, preparing: Popen | None = None) -> None:
    """Compile the loop if necessary, then open the device; the user can use the window meanwhile.

    After that, the other environments' laws are compiled, then the functions that a board needs.
    """
    window.live.start()
    if options.replay is not None:
        window.replay.open(options.replay)
    if options.screenshot:
        window.studio.engine_changed.connect(lambda: _push_then_save(window, options))
    if lab.settings().mistake:
        _open_device(window, options.device)  # opening the device fails, and a banner shows the mistake
        return
    key = window.studio.environment.key
    prepare_all(window, key, preparing, lambda: _open_device(window, options.device))


def prepare_all(window: MainWindow, key: str, preparing: Popen | None, done: Callable[[], None]) -> None:
    """Compile the loop with its first environment, call ``done``, then compile all other functions.

    ``expect`` checks which other laws are compiled, which takes 0.1 s. This check precedes the first sample
    only if the loop must be compiled.
    """

    def expect() -> None:
        if prepare.possible():
            window.studio.readiness.expect(window.studio.environments, {*prepare.ALWAYS, key})

    def first() -> Iterator[Sequence[Popen | None]]:
        if preparing is not None:
            expect()
        yield [preparing]
        # the program that was started earlier may have compiled another environment
        program = prepare.begin("loop", key)
        if program is not None:
            expect()
        yield [program]
        done()
        QTimer.singleShot(REST_MS, Preparation(window, rest()).run)

    def rest() -> Iterator[Sequence[Popen | None]]:
        expect()
        laws = prepare.begin_laws(window.studio.readiness.waiting)
        window.studio.readiness.follow(laws)
        yield laws
        yield [prepare.begin("boards")]
        yield [prepare.begin("analysis")]

    Preparation(window, first()).run()


class Preparation(QObject):
    """Runs steps one after the other; each waits until the programs of the previous step have ended.

    The steps stop when the window closes.
    """

    def __init__(self, window: MainWindow, steps: Iterator[Sequence[Popen | None]]):
        super().__init__(window)
        self._steps = steps
        self._programs: list[Popen] = []
        self._watch = QTimer(self, interval=POLL_MS)
        self._watch.timeout.connect(self.run)
        window.closed.connect(self._cancel)

    def run(self) -> None:
        """Start the next step if all programs have ended; the timer calls this again."""
        while all(program.poll() is not None for program in self._programs):
            step = next(self._steps, None)
            if step is None:
                self._watch.stop()
                return
            self._programs = [program for program in step if program is not None]
        self._watch.start()

    def _cancel(self) -> None:
        self._steps = iter(())
        for program in self._programs:
            program.kill()
            program.wait()


def _open_device(window: MainWindow, key: str) -> None:
    if window.studio.link.state == "preparing":
        entries = {entry.key: entry for entry in window.studio.device.entries()}
        other = devices.DeviceEntry(key, key, lambda: devices.named(key))
        window.studio.device.open(entries.get(key, other))


def _push_then_save(window: MainWindow, options: argparse.Namespace) -> None:
    if window.studio.engine is not None:
        if options.push is not None:
            window.studio.move_hand(options.push * 1e-3)
        QTimer.singleShot(int(options.seconds * 1000), lambda: _save_screenshot(window, options.screenshot))


def _save_screenshot(window: MainWindow, path: str) -> None:
    window.grab().save(path)
    window.close()
