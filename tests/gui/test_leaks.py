"""What a person does again and again leaves no objects behind."""

import gc
from collections import Counter

import pytest
from PySide6.QtCore import QCoreApplication, QObject
from PySide6.QtWidgets import QApplication, QDialog, QMenu

from hapkit_studio.gui.undo import MOST
from tests.gui.window_support import delete_the_given_up

FEW, MANY = 10, 30
# what ends the window, leaves it, or asks the system's own dialogs
NOT_TRIED = {"session.quit"}


def close_what_opened(window):
    """Close every dialog and menu that came up, and delete what was given up."""
    for top in QApplication.topLevelWidgets():
        if isinstance(top, QDialog | QMenu) and top.isVisible():
            top.close()
    for dialog in window.findChildren(QDialog):
        dialog.close()
    QCoreApplication.processEvents()
    delete_the_given_up()


def census(window):
    """Return how many objects of each class the window and the top levels own."""
    close_what_opened(window)
    gc.collect()
    delete_the_given_up()
    owners = [window, *(top for top in QApplication.topLevelWidgets() if top is not window)]
    return Counter(type(one).__name__ for owner in owners for one in owner.findChildren(QObject))


def left_behind(window, act):
    """Return the classes of which there are more after doing it MANY times than after FEW."""
    for _ in range(FEW):
        act()
        close_what_opened(window)
    few = census(window)
    for _ in range(MANY - FEW):
        act()
        close_what_opened(window)
    return {name: (few[name], count) for name, count in census(window).items() if count > few[name]}


def test_changing_environment_and_view_leaves_nothing_behind(kept_idle_window):
    window = kept_idle_window

    def act():
        for key, view in (("wall", "stability"), ("spring", "bode"), ("friction", "live")):
            window.studio.choose(key)
            number = next(p for p in window.studio.environment.parameters if not p.discrete)
            window.studio.set_value(number.key, 0.5 * (number.low + number.high))
            window.views.show(view)
            QCoreApplication.processEvents()

    assert left_behind(window, act) == {}


def test_the_undo_history_is_bounded(kept_idle_window):
    window = kept_idle_window
    window.studio.choose("spring")
    for step in range(MOST + 20):
        window.history.gesture += 1
        window.studio.set_value("stiffness", 100.0 + step)
    assert window.history.stack.count() <= MOST


@pytest.mark.slow
def test_no_action_leaves_objects_behind(kept_window, monkeypatch):
    """The system's own dialogs are answered with Cancel, the file manager and the browser are not called."""
    from PySide6.QtGui import QDesktopServices
    from PySide6.QtWidgets import QFileDialog, QInputDialog, QMessageBox

    for name in ("getOpenFileName", "getSaveFileName"):
        monkeypatch.setattr(QFileDialog, name, lambda *_a, **_k: ("", ""))
    monkeypatch.setattr(QFileDialog, "getExistingDirectory", lambda *_a, **_k: "")
    monkeypatch.setattr(QInputDialog, "getText", lambda *_a, **_k: ("", False))
    monkeypatch.setattr(QDesktopServices, "openUrl", lambda *_a: True)
    for name in ("question", "warning", "information"):
        monkeypatch.setattr(QMessageBox, name, lambda *_a, **_k: QMessageBox.StandardButton.Cancel)
    window, found = kept_window, {}
    for entry in window.actions_by_key.entries:
        if entry.key in NOT_TRIED:
            continue
        more = left_behind(window, lambda key=entry.key: _run(window, key))
        if more:
            found[entry.key] = more
    assert found == {}


def _run(window, key):
    window.actions_by_key.run(key)
    QCoreApplication.processEvents()
