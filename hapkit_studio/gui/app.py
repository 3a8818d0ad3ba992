"""Starts the window: application, theme, first picture, then the loop in the background."""

import argparse
import sys
from collections.abc import Sequence

from PySide6.QtCore import QProcess, QSettings, QTimer
from PySide6.QtWidgets import QApplication

from hapkit_studio import devices
from hapkit_studio.errors import ParameterError
from hapkit_studio.gui import prepare
from hapkit_studio.gui.studio import Studio
from hapkit_studio.gui.theme import theme
from hapkit_studio.gui.window import MainWindow


def run(argv: Sequence[str] | None = None) -> int:
    """Open the window and return the exit code; see ``arguments`` for what argv may hold."""
    options = arguments().parse_args(list(sys.argv[1:] if argv is None else argv))
    application = QApplication.instance() or QApplication(["hapkit-studio"])
    assert isinstance(application, QApplication)
    application.setApplicationName("hapkit-studio")
    application.setApplicationDisplayName("Hapkit Studio")
    theme.mode = options.theme or str(QSettings("hapkit-studio", "hapkit-studio").value("theme", "system"))
    theme.apply(application)
    try:
        window = build(options)
    except ParameterError as error:
        print(error, file=sys.stderr)
        return 2
    window.show()
    QTimer.singleShot(0, lambda: begin(window, options))
    return application.exec()


def arguments() -> argparse.ArgumentParser:
    """Return the options; those from --screenshot on are for pictures in documents and for developers."""
    parser = argparse.ArgumentParser(prog="hapkit-studio", description="The studio's window.")
    parser.add_argument("--environment", default="wall", help="environment to begin with")
    parser.add_argument("--device", default="simulated", help="device to begin with")
    parser.add_argument("--theme", choices=("system", "light", "dark", "contrast"), help="light or dark")
    parser.add_argument("--size", default="1440x900", help="window size in pixels")
    parser.add_argument("--screenshot", metavar="PATH", help="save a picture of the window, then leave")
    parser.add_argument("--seconds", type=float, default=5.0, help="how long to wait before the picture")
    parser.add_argument("--push", type=float, metavar="MM", help="for the picture: push the handle to MM")
    return parser


def build(options: argparse.Namespace) -> MainWindow:
    """Return the window, no device opened yet; leave with a line if an option names what is not there."""
    studio = Studio(devices.available)
    if options.environment not in studio.environments:
        known = ", ".join(studio.environments)
        raise ParameterError(f"There is no environment {options.environment!r}; there are: {known}.")
    studio.choose(options.environment)
    window = MainWindow(studio)
    width, _, height = options.size.partition("x")
    window.resize(int(width), int(height))
    return window


def begin(window: MainWindow, options: argparse.Namespace) -> None:
    """Prepare the loop if it never was, then open the device; the window is up and usable meanwhile."""
    window.live.start()
    if options.screenshot:
        QTimer.singleShot(int(options.seconds * 1000), lambda: _picture(window, options.screenshot))
        window.studio.engine_changed.connect(lambda: _push(window, options.push))
    if prepare.prepared() or getattr(sys, "frozen", False):
        _open(window, options.device)
        return
    process = QProcess(window)
    process.finished.connect(lambda *_: _open(window, options.device))
    process.errorOccurred.connect(lambda *_: _open(window, options.device))
    process.start(sys.executable, ["-m", "hapkit_studio.gui.prepare"])


def _open(window: MainWindow, key: str) -> None:
    if window.studio.link.state == "preparing":
        entries = {entry.key: entry for entry in window.studio.entries()}
        window.studio.open(entries.get(key, entries["simulated"]))


def _push(window: MainWindow, millimetres: float | None) -> None:
    if millimetres is not None and window.studio.engine is not None:
        window.studio.move_hand(millimetres * 1e-3)


def _picture(window: MainWindow, path: str) -> None:
    window.grab().save(path)
    window.close()
