"""Repeated operations leave no objects behind."""

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


def close_dialogs(window):
    """Close all dialogs and menus and delete the objects marked for deletion."""
    for top in QApplication.topLevelWidgets():
        if isinstance(top, QDialog | QMenu) and top.isVisible():
            top.close()
    for dialog in window.findChildren(QDialog):
        dialog.close()
    QCoreApplication.processEvents()
    delete_deferred()


def count_objects(window):
    """Return the number of objects of each class that belong to the window and the top-level widgets."""
    close_dialogs(window)
    gc.collect()
    delete_deferred()
    owners = [window, *(top for top in QApplication.topLevelWidgets() if top is not window)]
    return Counter(type(one).__name__ for owner in owners for one in owner.findChildren(QObject))


def growing_classes(window, act, few=FEW, many=MANY):
    """Return the classes with more objects after many repetitions than after few.

    A class is returned only if it also grows in a second series: a late result adds its widgets only once.
    """
    counts = [repeated(window, act, few), repeated(window, act, many - few)]
    if grown := counts[1] - counts[0]:
        counts.append(repeated(window, act, many - few))
        grown &= counts[2] - counts[1]
    return {name: [count[name] for count in counts] for name in grown}


def repeated(window, act, times):
    """Repeat an action and return the object counts."""
    for _ in range(times):
        act()
        close_dialogs(window)
    return count_objects(window)


@pytest.mark.slow
@pytest.mark.parametrize("counts", [(2, 6), pytest.param((FEW, MANY), marks=pytest.mark.slow)])
def test_changing_environment_and_view_leaves_no_objects(reset_idle_window, counts):
    window = reset_idle_window

    def act():
        for key, view in (("wall", "stability"), ("spring", "bode"), ("friction", "live")):
            window.studio.choose(key)
            number = next(p for p in window.studio.environment.parameters if not p.discrete)
            window.studio.set_value(number.key, 0.5 * (number.low + number.high))
            window.views.show(view)
            QCoreApplication.processEvents()

    assert growing_classes(window, act, *counts) == {}


def test_the_undo_history_is_limited(reset_idle_window):
    window = reset_idle_window
    window.studio.choose("spring")
    for step in range(MOST + 20):
        window.history.gesture += 1
        window.studio.set_value("stiffness", 100.0 + step)
    assert window.history.stack.count() <= MOST


@pytest.fixture
def cancelled_dialogs(monkeypatch):
    """Answer the system's dialogs with Cancel and start neither a file manager nor a browser."""
    for name in ("getOpenFileName", "getSaveFileName"):
        monkeypatch.setattr(QFileDialog, name, lambda *_a, **_k: ("", ""))
    monkeypatch.setattr(QFileDialog, "getExistingDirectory", lambda *_a, **_k: "")
    monkeypatch.setattr(QInputDialog, "getText", lambda *_a, **_k: ("", False))
    monkeypatch.setattr(QDesktopServices, "openUrl", lambda *_a: True)
    for name in ("question", "warning", "information"):
        monkeypatch.setattr(QMessageBox, name, lambda *_a, **_k: QMessageBox.StandardButton.Cancel)


@pytest.mark.slow
@pytest.mark.parametrize("key", KEYS)
def test_an_action_leaves_no_objects(reset_window, cancelled_dialogs, key):
    window = reset_window

    def act():
        if key.startswith("view.tab."):
            window.actions_by_key.run("view.tab.live")
        window.actions_by_key.run(key)
        QCoreApplication.processEvents()

    assert growing_classes(window, act) == {}
