"""Widgets in reference cycles are freed in the main thread even if another thread allocates objects."""

import gc
import threading
import weakref

import pytest
from PySide6.QtWidgets import QWidget

from hapkit_studio.gui.shell.window import Collector


def unreferenced_cycle(freed):
    """Return a weak reference to a widget in a reference cycle; ``freed`` receives the thread's name."""
    widget = QWidget()
    widget.itself = widget
    return weakref.ref(widget, lambda _: freed.append(threading.current_thread().name))


@pytest.fixture(autouse=True)
def enabled():
    yield
    gc.enable()


@pytest.mark.slow
def test_allocation_in_another_thread_frees_no_widget(qtbot):
    owner, freed = QWidget(), []
    qtbot.addWidget(owner)
    gc.collect()
    Collector(owner)
    kept = unreferenced_cycle(freed)
    allocated = []
    worker = threading.Thread(target=lambda: allocated.extend([] for _ in range(20_000)))
    worker.start()
    worker.join()
    assert kept() is not None
    qtbot.waitUntil(lambda: kept() is None, timeout=180_000)
    assert freed == ["MainThread"]
