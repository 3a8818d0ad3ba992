"""A new device is one module: no other file changes, and the tests of every device include it."""

import pytest

from tests.project_copy import copy_with, run_tests

NEW = '''"""A heavy paddle with a coarse sensor and a clock of its own."""

from hapkit_studio.devices import DeviceEntry, DeviceKind
from hapkit_studio.devices.base import SIMULATED, Device
from hapkit_studio.devices.simulated import SimulatedHapkit


class HeavyPaddle(Device):
    title = "Heavy paddle"
    driver = SIMULATED
    motor = measures_delay = False
    simulated_hand = own_clock = True
    mass, viscous, coulomb_force, quantum, max_force = 0.15, 1.0, 0.2, 1e-4, 5.0
    rate = 2000.0

    @property
    def model(self):
        return SimulatedHapkit(
            self.mass, self.viscous, self.coulomb_force, self.quantum, self.max_force, end_stops=0.06
        )


DEVICE = DeviceKind(10, lambda: [DeviceEntry("heavy-paddle", HeavyPaddle.title, HeavyPaddle)])
'''


@pytest.mark.slow
def test_a_new_device_needs_one_module(tmp_path):
    copy = copy_with(tmp_path, "hapkit_studio/devices/heavy_paddle.py", NEW)
    files = "tests/devices/test_every_device.py", "tests/gui/shell/test_every_device.py"
    output = run_tests(copy, "-m", "not alone", "-k", "heavy or not slow", *files)
    assert "test_a_command_runs_it_with_a_hand[heavy-paddle] PASSED" in output
    assert "test_the_window_renders_records_judges_and_shows_all_pages[heavy-paddle] PASSED" in output
