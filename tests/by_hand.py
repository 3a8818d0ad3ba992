"""A student's five minutes in the real window, with the X server's mouse and keys; prints the results.

``python -m tests.by_hand FOLDER`` needs a display and xdotool. All input goes through the X server; the
window is only queried for positions and contents.
"""

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from PySide6.QtCore import QPoint
from PySide6.QtWidgets import QApplication, QFileDialog, QWidget

from hapkit_studio.gui.shell.window import MainWindow
from hapkit_studio.haptics import rows
from tests.bench.window import open_window, process_until

PATIENCE = 120.0
STEPS, STEP_SECONDS = 25, 0.02
PLACED = 0.3  # time in s that two pixel columns show in a plot of a minute
PRESSED = 0.012  # the hand's target in m, which is inside the wall
FADED = 1.0  # time in s, longer than the fade-in of new settings


class Person:
    """A person who moves the pointer, presses buttons and types; the event loop runs in between."""

    def __init__(self, application: QApplication, window: MainWindow):
        self.application, self.window = application, window
        self.reader, self.pieces = window.studio.engine.reader(), []
        self.face(window)

    def wait(self, until: Callable[[], bool]) -> None:
        """Run the event loop until a condition holds; keep every row of the loop."""
        process_until(self.application, lambda: self._keep() and until(), PATIENCE)

    def pause(self, seconds: float) -> None:
        """Run the event loop for some seconds."""
        end = time.perf_counter() + seconds
        self.wait(lambda: time.perf_counter() > end)

    def face(self, window: QWidget) -> None:
        """Give a window the keyboard focus, as a window manager does."""
        self.wait(window.isVisible)
        self.do("windowfocus", "--sync", int(window.winId()))

    def do(self, *args: object) -> None:
        """Run one xdotool command."""
        subprocess.run(["xdotool", *map(str, args)], check=True, timeout=30)
        self.pause(STEP_SECONDS)

    def key(self, key: str) -> None:
        """Press a key."""
        self.do("key", key)

    def move_to(self, widget: QWidget, x: float, y: float) -> None:
        """Move the pointer to a position in a widget."""
        place = widget.mapToGlobal(QPoint(round(x), round(y)))
        self.do("mousemove", place.x(), place.y())

    def click(self, widget: QWidget) -> None:
        """Click into the middle of a widget."""
        self.move_to(widget, widget.width() / 2, widget.height() / 2)
        self.do("click", 1)

    def _keep(self) -> bool:
        if self.reader is not None:
            self.pieces.append(self.reader.read())
        return True


def push(person: Person) -> tuple[float, float]:
    """Take the handle, push it into the wall and back, and release it.

    Return start and end by the rows' clock.
    """
    scene = person.window.centre.scene
    columns = np.arange(scene.width())
    targets = np.array([scene.target_at(x) for x in columns])
    begin = time.perf_counter()
    places = np.concatenate([np.linspace(0.0, PRESSED, STEPS), np.linspace(PRESSED, 0.0, STEPS)])
    person.move_to(scene, columns[np.abs(targets).argmin()], scene.height() * 0.4)
    person.do("mousedown", 1)
    for place in places:
        person.move_to(scene, columns[np.abs(targets - place).argmin()], scene.height() * 0.4)
    person.do("mouseup", 1)
    end = time.perf_counter()
    person.pause(0.3)
    return begin, end


def slope(person: Person, begin: float, end: float) -> str:
    """Put the cursors A and B at the start and end of a push; return the slope shown on the card."""
    time_plots = person.window.centre.time
    canvas = time_plots.canvases[0]
    for key, moment in (("a", begin), ("b", end)):
        canvas.measure()
        person.move_to(canvas, canvas.pixel(moment - time_plots.view.zero, 0.0).x(), canvas.height() / 2)
        person.key(key)
    person.wait(lambda: np.allclose(time_plots.cursors.times or 0.0, (begin, end), rtol=0.0, atol=PLACED))
    card = person.window.centre.phase.cursors
    card.refresh()  # refresh at once, without waiting for the timer
    return card.slope.text()


def set_stiffness(person: Person, newtons_per_metre: str) -> None:
    """Type a stiffness and press Enter."""
    person.click(person.window.panel.parameters.rows["stiffness"].box)
    person.key("ctrl+a")
    person.do("type", newtons_per_metre)
    person.key("Return")
    studio = person.window.studio
    person.wait(lambda: studio.values["stiffness"] == float(newtons_per_metre))
    person.pause(FADED)


def feel(person: Person) -> dict[str, object]:
    """Record two pushes at two stiffnesses, with the first one frozen; return both cursor readings."""
    window = person.window
    person.key("r")
    person.wait(lambda: window.studio.recording.progress is not None)
    pushes = [push(person)]
    person.key("h")
    set_stiffness(person, "300")
    pushes.append(push(person))
    person.key("space")
    person.key("ctrl+k")
    person.do("type", "60 s")
    person.key("Return")
    slopes = [slope(person, *moments) for moments in pushes]
    person.key("space")
    person.key("r")
    person.wait(lambda: window.studio.recording.newest is not None)
    return {"slopes": slopes, "held": len(window.centre.kept_curves.curves)}


def export(person: Person, path: Path) -> None:
    """Find the newest session in the sessions view, and export it as a table."""
    window = person.window
    window.views.show("sessions")
    page = window.views.page("sessions")
    person.wait(lambda: page.export.isEnabled())
    person.click(page.export)
    person.wait(lambda: window.findChild(QFileDialog) is not None)
    person.face(window.findChild(QFileDialog))
    person.do("type", path)
    person.key("Return")
    person.wait(path.is_file)
    person.wait(lambda: "was saved" in page.status.text())


def main() -> None:
    """Push and record; restart and export; print the results, and keep the loop's own rows."""
    folder = Path(sys.argv[1])
    options = ("--environment", "wall", "--size", "1280x720", "--theme", "light")
    person = Person(*open_window(*options))
    seen = feel(person)
    np.save(
        folder / "ring.npy", np.concatenate(person.pieces)[:, [rows.TICK, rows.POSITION, rows.APPLIED_FORCE]]
    )
    person.reader = None
    person.key("ctrl+q")
    person.wait(lambda: not person.window.isVisible())
    person = Person(*open_window(*options))
    export(person, folder / "felt.csv")
    print(json.dumps(seen), flush=True)
    person.window.close()
    os._exit(0)


if __name__ == "__main__":
    main()
