"""Engines: running ones on the simulated device, and those on either serial loop."""

import pytest

from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.haptics import drivers
from hapkit_studio.haptics.engine import Engine
from tests.haptics.serial_support import connector

PORTABLE = pytest.param(drivers.PortableDriver, marks=pytest.mark.slow)


@pytest.fixture(params=[drivers.SerialDriver, PORTABLE], ids=["compiled", "portable"])
def connect(request, monkeypatch):
    """Return a maker of engines on a board, not started, of either kind of loop; what answers is the same."""
    return connector(request.param, monkeypatch, request.addfinalizer)


@pytest.fixture
def started():
    """Return a maker of running engines that are closed in the end."""
    engines = []

    def make(device=None, **options):
        engines.append(Engine(device or SimulatedHapkit(), **{"realtime": False, **options}))
        engines[-1].start()
        return engines[-1]

    yield make
    for engine in engines:
        engine.close()
