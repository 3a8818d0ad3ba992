"""Widgets in reference cycles are freed in the window's thread, whoever allocates meanwhile."""

import gc
import threading
import weakref

import pytest
from PySide6.QtWidgets import QWidget

from hapkit_studio.gui.shell.window import Collector


def circle(freed):
    """Return a reference to a widget that only a cycle holds; its thread's name is noted when it is freed."""
    widget = QWidget()
    widget.itself = widget
    return weakref.ref(widget, lambda _: freed.append(threading.current_thread().name))


@pytest.fixture(autouse=True)
def enabled():
    yield
    gc.enable()


@pytest.mark.slow
def test_what_allocates_in_the_background_frees_no_widget(qtbot):
    owner, freed = QWidget(), []
    qtbot.addWidget(owner)
    gc.collect()
    Collector(owner)
    kept = circle(freed)
    allocated = []
    worker = threading.Thread(target=lambda: allocated.extend([] for _ in range(20_000)))
    worker.start()
    worker.join()
    assert kept() is not None
    qtbot.waitUntil(lambda: kept() is None, timeout=180_000)
    assert freed == ["MainThread"]
