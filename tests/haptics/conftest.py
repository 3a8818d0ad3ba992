"""Fixtures of engines that run on the simulated device, or on a board controlled by the test."""

import pytest

from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.haptics.engine import Engine
from tests.haptics.board_support import BoardSetup, RendersItself
from tests.haptics.serial_support import SteppedBoard, stepped_engine


@pytest.fixture
def stepped(monkeypatch, request):
    """Return a factory of (board, engine) that handles each message of the board at once."""

    def make(answer=None, **options):
        board = SteppedBoard(answer)
        return board, stepped_engine(monkeypatch, request.addfinalizer, board, **options)

    return make


@pytest.fixture
def rendering(stepped):
    """Return a factory of boards that render, each of which has an engine."""

    def make(environment="spring", values=None, **options):
        kit = RendersItself(**options)
        return BoardSetup(kit, *stepped(kit, environment=environment, values=values))

    return make


@pytest.fixture
def started():
    """Return a factory of running engines, which are closed at the end."""
    engines = []

    def make(device=None, **options):
        engines.append(Engine(device or SimulatedHapkit(), **{"realtime": False, **options}))
        engines[-1].start()
        return engines[-1]

    yield make
    for engine in engines:
        engine.close()
