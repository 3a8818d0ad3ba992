"""A device that comes back goes on in the same plots; another device starts clean ones."""

import numpy as np
import pytest

from hapkit_studio.devices import DeviceEntry
from hapkit_studio.devices.simulated import SimulatedHapkit
from tests.gui.window_support import PATIENCE_MS, SIMULATED

OTHER = DeviceEntry("other", "Another Hapkit", SimulatedHapkit)


def kept(window, qtbot, least: int) -> float:
    """Take frames until so many samples are kept; return the oldest one's time in s."""

    def enough() -> bool:
        window.live.tick()
        return len(window.live.history) >= least

    qtbot.waitUntil(enough, timeout=PATIENCE_MS)
    return window.live.history.start


@pytest.mark.parametrize(("entry", "same"), [(SIMULATED, True), (OTHER, False)])
def test_history_survives_a_reconnection_with_a_gap(window, qtbot, entry, same):
    start = kept(window, qtbot, 100)
    with qtbot.waitSignal(window.studio.engine_changed, timeout=PATIENCE_MS):
        window.studio.device.open(entry)
    qtbot.waitUntil(lambda: window.studio.engine is not None, timeout=PATIENCE_MS)
    before = len(window.live.history)
    assert (before >= 100) == same
    assert (kept(window, qtbot, before + 100) == start) == same
    shown = window.live.history.between(-np.inf, np.inf)
    assert np.isnan(shown.x).any() == same
