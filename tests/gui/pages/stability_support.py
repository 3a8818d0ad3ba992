"""Support for tests of the stability page: the visible page, its newest lines, invented measurements."""

import numpy as np

from hapkit_studio.analysis.stability.kb_plane import Cells, Points
from hapkit_studio.gui.pages.stability.map_data import Measured
from tests.gui.window_support import PATIENCE_MS


def follow(page, qtbot):
    """Wait until the page shows the stability limits for the current settings; return their plane."""

    def there() -> bool:
        wanted, lines = page.question(), page.lines
        if lines is None or wanted is None or lines.question.every_hand != wanted.every_hand:
            return False
        margin = lines.plane.margin
        asked = (wanted.setting, wanted.stiffness, wanted.damping)
        return (lines.plane.setting, margin.stiffness, margin.damping) == asked

    qtbot.waitUntil(there, timeout=PATIENCE_MS)
    return page.lines.plane


def made_up(setting, real=False, axes=(12.0, 2000.0)) -> Measured:
    """Return an invented measurement of 4 × 3 cells, which rest, buzz or grow with increasing stiffness."""
    classes = np.array([[0, 0, 0], [0, 0, 1], [1, 2, 2], [2, 2, 2]], dtype=np.int8)
    damping = np.array([2.0, 6.0, 10.0])
    cells = Cells(damping, np.array([250.0, 750.0, 1250.0, 1750.0]), classes, real, setting.controller)
    points = Points(damping, np.array([800.0, 900.0, 1000.0]), real, setting.controller)
    return Measured(setting, real, axes, points, cells, 3.14)
