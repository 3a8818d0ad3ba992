"""Saves screenshots of every environment: ``python -m hapkit_studio.gui.shell.portraits FOLDER``."""

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from PySide6.QtCore import QObject, QTimer
from PySide6.QtWidgets import QApplication

from hapkit_studio import devices
from hapkit_studio.arguments import LineParser, size
from hapkit_studio.dynamics.hand import SCRIPTS
from hapkit_studio.environments.base import Environment
from hapkit_studio.gui.shell.actions import new_window
from hapkit_studio.gui.shell.app import prepare_all
from hapkit_studio.gui.shell.window import MainWindow
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.gui.widgets import style
from hapkit_studio.gui.widgets.theme import theme

FRAME_MS = 16
RELEASED = "released"
# s: period of the hand's movement: six taps or two strokes, which fit in the plots
AGAIN_SECONDS = 4.8


def options(argv: Sequence[str] | None = None) -> argparse.Namespace:
    """Parse and check the command-line options."""
    parser = LineParser(prog="python -m hapkit_studio.gui.shell.portraits", description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument(
        "--seconds", type=float, default=11.0, help="how long each environment is used before its screenshot"
    )
    parser.add_argument("--size", type=size, default=(1280, 800), metavar="WxH")
    parser.add_argument("--theme", choices=("light", "dark", "contrast"), default="light")
    parser.add_argument("environments", nargs="*", metavar="ENVIRONMENT", help="default: all")
    return parser.parse_intermixed_args(argv)


def usual_hand(environment: Environment) -> str:
    """Return the first of the environment's declared hands that moves the handle."""
    return next((hand for hand in environment.hands if hand != RELEASED), "stroke")


class Portraits(QObject):
    """Moves the hand in each environment in turn and saves pictures of window and scene."""

    def __init__(self, window: MainWindow, keys: Sequence[str], folder: Path, seconds: float):
        super().__init__(window)
        self._window, self._keys = window, list(keys)
        self._folder, self._seconds = folder, seconds
        self._begun = 0.0
        self._frames = QTimer(self, interval=FRAME_MS)
        self._frames.timeout.connect(self._move)
        window.studio.engine_changed.connect(self._start)

    def _start(self) -> None:
        if self._window.studio.engine is not None:
            self._window.studio.choose(self._keys[0])
            self._frames.start()

    def _move(self) -> None:
        environment = self._window.studio.environment
        if environment.key != self._keys[0]:
            return  # the environment's law is still being compiled
        if not self._begun:
            self._window.live.history.clear()
            self._begun, self._hand = time.monotonic(), SCRIPTS[usual_hand(environment)]
        now = time.monotonic() - self._begun
        if now < self._seconds:
            self._window.studio.move_hand(float(self._hand.target(now % AGAIN_SECONDS)))
            return
        for part, suffix in ((self._window, ""), (self._window.centre.scene, "-scene")):
            part.grab().save(str(self._folder / f"{self._keys[0]}{suffix}.png"))
        del self._keys[0]
        self._begun = 0.0
        if self._keys:
            self._window.studio.choose(self._keys[0])
        else:
            self._frames.stop()
            self._window.close()


def main(argv: Sequence[str] | None = None) -> int:
    """Show the window, prepare the loop, save every screenshot, and quit."""
    chosen = options(argv)
    chosen.folder.mkdir(parents=True, exist_ok=True)
    application = QApplication.instance() or QApplication(["hapkit-studio"])
    assert isinstance(application, QApplication)
    theme.mode = chosen.theme
    style.apply(application)
    studio = Studio(devices.available)
    window = new_window(studio)
    window.resize(*chosen.size)
    window.show()
    window.live.start()
    keys = chosen.environments or list(studio.environments)
    studio.choose(keys[0])
    Portraits(window, keys, chosen.folder, chosen.seconds)
    prepare_all(window, keys[0], None, studio.device.open_simulated)
    return application.exec()


if __name__ == "__main__":
    sys.exit(main())
