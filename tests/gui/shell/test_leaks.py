"""What a person does again and again leaves no objects behind."""

import gc
from collections import Counter

import pytest
from PySide6.QtCore import QCoreApplication, QObject
from PySide6.QtGui import QDesktopServices
from PySide6.QtWidgets import QApplication, QDialog, QFileDialog, QInputDialog, QMenu, QMessageBox

from hapkit_studio.environments import discover
from hapkit_studio.gui.shell.actions import table
from hapkit_studio.gui.state.undo import MOST
from tests.gui.window_support import delete_deferred

FEW, MANY = 10, 30
KEYS = [action.key for action in table(discover().values()) if action.key != "session.quit"]


def close_what_opened(window):
    """Close every dialog and menu that came up, and delete what was given up."""
    for top in QApplication.topLevelWidgets():
        if isinstance(top, QDialog | QMenu) and top.isVisible():
            top.close()
    for dialog in window.findChildren(QDialog):
        dialog.close()
    QCoreApplication.processEvents()
    delete_deferred()


def census(window):
    """Return how many objects of each class the window and the top levels own."""
    close_what_opened(window)
    gc.collect()
    delete_deferred()
    owners = [window, *(top for top in QApplication.topLevelWidgets() if top is not window)]
    return Counter(type(one).__name__ for owner in owners for one in owner.findChildren(QObject))


def left_behind(window, act, few=FEW, many=MANY):
    """Return the classes of which there are more objects after many repetitions than after few.

    What grew must grow again in as many repetitions: an answer that arrives late builds its widgets once.
    """
    counts = [repeated(window, act, few), repeated(window, act, many - few)]
    if grown := counts[1] - counts[0]:
        counts.append(repeated(window, act, many - few))
        grown &= counts[2] - counts[1]
    return {name: [count[name] for count in counts] for name in grown}


def repeated(window, act, times):
    """Do something so many times, and return the census."""
    for _ in range(times):
        act()
        close_what_opened(window)
    return census(window)


@pytest.mark.slow
@pytest.mark.parametrize("counts", [(2, 6), pytest.param((FEW, MANY), marks=pytest.mark.slow)])
def test_changing_environment_and_view_leaves_nothing_behind(kept_idle_window, counts):
    window = kept_idle_window

    def act():
        for key, view in (("wall", "stability"), ("spring", "bode"), ("friction", "live")):
            window.studio.choose(key)
            number = next(p for p in window.studio.environment.parameters if not p.discrete)
            window.studio.set_value(number.key, 0.5 * (number.low + number.high))
            window.views.show(view)
            QCoreApplication.processEvents()

    assert left_behind(window, act, *counts) == {}


def test_the_undo_history_is_bounded(kept_idle_window):
    window = kept_idle_window
    window.studio.choose("spring")
    for step in range(MOST + 20):
        window.history.gesture += 1
        window.studio.set_value("stiffness", 100.0 + step)
    assert window.history.stack.count() <= MOST


@pytest.fixture
def cancelled_dialogs(monkeypatch):
    """Answer the system's own dialogs with Cancel; start neither file manager nor browser."""
    for name in ("getOpenFileName", "getSaveFileName"):
        monkeypatch.setattr(QFileDialog, name, lambda *_a, **_k: ("", ""))
    monkeypatch.setattr(QFileDialog, "getExistingDirectory", lambda *_a, **_k: "")
    monkeypatch.setattr(QInputDialog, "getText", lambda *_a, **_k: ("", False))
    monkeypatch.setattr(QDesktopServices, "openUrl", lambda *_a: True)
    for name in ("question", "warning", "information"):
        monkeypatch.setattr(QMessageBox, name, lambda *_a, **_k: QMessageBox.StandardButton.Cancel)


@pytest.mark.slow
@pytest.mark.parametrize("key", KEYS)
def test_an_action_leaves_no_objects_behind(kept_window, cancelled_dialogs, key):
    window = kept_window

    def act():
        if key.startswith("view.tab."):
            window.actions_by_key.run("view.tab.live")
        window.actions_by_key.run(key)
        QCoreApplication.processEvents()

    assert left_behind(window, act) == {}
