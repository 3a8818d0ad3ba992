"""Every view and dialog fits small and scaled screens: nothing is cut off, elided or outside the window."""

import os
import subprocess
import sys

import pytest
from PySide6.QtCore import QPoint, QRect
from PySide6.QtGui import QAction
from PySide6.QtWidgets import (
    QAbstractScrollArea,
    QApplication,
    QComboBox,
    QDialog,
    QFileDialog,
    QGraphicsView,
    QPlainTextEdit,
    QScrollArea,
    QStyle,
    QStyleOptionComboBox,
    QTabBar,
    QWidget,
)

from hapkit_studio.gui import pages
from hapkit_studio.gui.shell.actions import new_window
from hapkit_studio.gui.state.background import Job
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.gui.widgets import style
from tests.gui.shell.test_layout import cut_off, overlapping, resize
from tests.gui.window_support import SIMULATED, build_engine

SCREENS = {
    "1280 × 720": (1280, 720),
    "1280 × 800 with a frame of 40 px": (1280, 760),
    "1920 × 1080 at a scale of 2, with a frame of 40 px": (960, 500),
    "1280 × 800 at a scale of 1.5, with a frame of 40 px": (853, 493),
    "1280 × 800 at a scale of 2": (640, 400),
}

_OTHER_DIALOGS = "Keys and glossary", "Law language", "Real-time priority", "About"


def elided(top: QWidget) -> list[str]:
    """Return the lists and tabs whose text is elided."""
    found = []
    for box in top.findChildren(QComboBox):
        option = QStyleOptionComboBox()
        box.initStyleOption(option)
        field = box.style().subControlRect(
            QStyle.ComplexControl.CC_ComboBox, option, QStyle.SubControl.SC_ComboBoxEditField, box
        )
        if box.isVisibleTo(top) and box.fontMetrics().horizontalAdvance(box.currentText()) > field.width():
            found.append(f"list {box.currentText()!r} in {field.width()} px")
    for bar in top.findChildren(QTabBar):
        for index in range(bar.count()):
            wide = bar.fontMetrics().horizontalAdvance(bar.tabText(index))
            if bar.isVisibleTo(top) and bar.isTabVisible(index) and wide > bar.tabRect(index).width():
                found.append(f"tab {bar.tabText(index)!r}")
    return found


def outside(top: QWidget) -> list[str]:
    """Return visible widgets that extend beyond the window or their parent, except in scroll areas."""
    found = []
    for widget in top.findChildren(QWidget):
        above = widget.parentWidget()
        while above is not None and above is not top and not isinstance(above, QAbstractScrollArea):
            above = above.parentWidget()
        if above is top and widget.isVisibleTo(top) and not widget.isWindow():
            place = QRect(widget.mapTo(top, QPoint()), widget.size())
            parent = widget.parentWidget()
            if not (top.rect().contains(place) and parent.rect().contains(widget.geometry())):
                found.append(f"{type(widget).__name__} {widget.accessibleName()!r} at {place}")
    return found


def wider_than_its_view(top: QWidget) -> list[str]:
    """Return visible scroll areas whose content is wider than the area, except plots and code."""
    found = []
    for area in top.findChildren(QAbstractScrollArea):
        wide = area.horizontalScrollBar().maximum()
        if isinstance(area, QScrollArea) and area.widget() is not None:
            wide = area.widget().width() - area.viewport().width()
        if area.isVisibleTo(top) and wide > 0 and not isinstance(area, QPlainTextEdit | QGraphicsView):
            found.append(f"{type(area).__name__} {area.accessibleName()!r}: content {wide} px too wide")
    return found


def misfits(top: QWidget) -> list[str]:
    """Return everything in a window or dialog that does not fit."""
    return cut_off(top) + elided(top) + outside(top) + wider_than_its_view(top)


def misfits_of_views(window) -> list[str]:
    """Show every view and return what does not fit, each with its view."""
    found = []
    for key in ("live", *pages.discover()):
        window.views.show(key)
        resize(QApplication.instance(), window, window.size().toTuple())
        found += [f"{key}: {text}" for text in misfits(window) + overlapping(window)]
    window.views.show("live")
    return found


def misfits_of_dialogs(window) -> list[str]:
    """Open every dialog of the menus; return parts that do not fit, and dialogs larger than the window."""
    found = []
    for action in window.findChildren(QAction):
        if not (action.isEnabled() and (action.text().endswith("…") or action.text() in _OTHER_DIALOGS)):
            continue
        action.trigger()
        QApplication.processEvents()
        for dialog in window.findChildren(QDialog):
            if dialog.isVisible() and not isinstance(dialog, QFileDialog):
                found += [f"{action.text()}: {text}" for text in misfits(dialog)]
                if dialog.width() > window.width() or dialog.height() > window.height():
                    found.append(f"{action.text()}: {dialog.size()} in {window.size()}")
            dialog.close()
    return found


@pytest.fixture
def still(monkeypatch):
    """Prevent views from starting a measurement when they are first shown."""
    monkeypatch.setattr(Job, "start", lambda *_work: None)


@pytest.mark.parametrize("size", SCREENS.values(), ids=SCREENS)
def test_live_fits_the_screen(reset_window, qapp, size):
    resize(qapp, reset_window, size)
    assert misfits(reset_window) == []
    reset_window.loop.set_folded(False)
    reset_window.loop.set_more(True)
    resize(qapp, reset_window, size)
    assert misfits(reset_window) == []


@pytest.mark.slow
@pytest.mark.parametrize("size", SCREENS.values(), ids=SCREENS)
def test_every_view_and_dialog_fits_the_screen(still, make_window, qapp, size):
    window = make_window(size=size)
    resize(qapp, window, size)
    assert misfits_of_views(window) == []
    assert misfits_of_dialogs(window) == []


def main() -> int:
    """Print what does not fit a screen of 1920 × 1080 at the scale of this process."""
    app = QApplication([])
    style.apply(app)
    Job.start = lambda *_work: None
    window = new_window(Studio(lambda: [SIMULATED], build_engine))
    ratio = window.devicePixelRatioF()
    size = int(1920 / ratio), int(1080 / ratio) - 40
    window.resize(*size)
    window.show()
    resize(app, window, size)
    found = misfits_of_views(window) + misfits_of_dialogs(window)
    print(ratio, *found, sep="\n")
    window.close()
    return bool(found)


@pytest.mark.slow
@pytest.mark.parametrize("scale", ["1.5", "2"])
def test_every_view_and_dialog_fits_1920_by_1080_at_a_scale(scale):
    done = subprocess.run(
        [sys.executable, "-c", "import sys; from tests.gui.shell.test_fits import main; sys.exit(main())"],
        env=os.environ | {"QT_SCALE_FACTOR": scale, "QT_QPA_PLATFORM": "offscreen"},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.startswith(str(float(scale)))
