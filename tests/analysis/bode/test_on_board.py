"""The impedance rendered by the computer, and by the firmware itself, is compared with theory."""

import numpy as np
import pytest

from hapkit_studio.analysis.bode import on_board, simulation
from hapkit_studio.dynamics.loop_settings import LoopSettings
from tests.analysis.bode.test_loops import SPRING, WALL, impedance, off
from tests.firmware.vb import needs_board

SHARE, DEGREES = 0.03, 2.0


@needs_board
@pytest.mark.slow
@pytest.mark.parametrize(("scene", "damping"), [(WALL, 0.0), (SPRING, 2.0)], ids=["wall", "damped spring"])
def test_computer_and_board_agree_with_theory(scene, damping):
    values = scene.values({"stiffness": 300.0, "damping": damping})
    found = on_board.measure(simulation.measure(scene, values, [LoopSettings()]))
    assert [curve.where for curve in found.curves] == ["computer", "board"]
    assert found.curves[1].setting.rate > found.curves[0].setting.rate == 1000.0
    for curve in found.curves:
        low = curve.measured.frequency <= 0.4 * 0.5 * curve.setting.rate
        setting, tones = curve.setting, curve.measured.frequency[low]
        expected = impedance(300.0, damping, setting.rate, setting.delay, ("difference", {}), tones)
        share, degrees = off(curve.measured.impedance[low], expected)
        assert share < SHARE
        assert degrees < DEGREES
        assert np.all(curve.coherence[low] > 0.99)
