"""Repeated painting leaks no references; a leak would crash the program within half a minute."""

import gc
import math
import sys

import pytest

from hapkit_studio.gui.widgets.theme import theme
from tests.gui.window_support import PATIENCE_MS

FRAMES = 100


@pytest.mark.slow
def test_repeated_painting_leaks_no_reference(window, qapp, qtbot):
    def frame(number):
        window.studio.move_hand(0.02 * math.sin(0.1 * number))
        window.live.tick()
        window.update()
        qapp.processEvents()

    qtbot.waitUntil(lambda: len(window.live.history) > 0 or frame(0), timeout=PATIENCE_MS)
    for number in range(50):
        frame(number)
    gc.collect()  # objects of earlier tests refer to None, too
    before = sys.getrefcount(None)
    for number in range(FRAMES):
        frame(number)
        if number % 40 == 0:
            theme.set_mode("dark" if theme.name == "light" else "light")
    # PySide6 6.12.0 leaked a reference to None per call without result, and a frame has many such calls
    assert sys.getrefcount(None) > before - FRAMES
    assert window.isVisible()
