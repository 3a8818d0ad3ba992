"""Every test is isolated: it has no display, none of the user's settings, and a fixed seed."""

import os
import signal
import sys
import tempfile

import hypothesis
import numpy as np
import pytest

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
os.environ.setdefault("MPLBACKEND", "Agg")
_settings = tempfile.TemporaryDirectory(prefix="hapkit-studio-tests-")
os.environ["XDG_CONFIG_HOME"] = _settings.name
os.environ["HAPKIT_STUDIO_FOLDER"] = f"{_settings.name}/own"
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # shells ignore SIGINT in background jobs
    signal.signal(signal.SIGINT, signal.default_int_handler)
# no deadline, as the first example compiles; derandomised, so that results are reproducible
hypothesis.settings.register_profile("studio", deadline=None, derandomize=True)
hypothesis.settings.load_profile("studio")


# the slowest file, which installs the studio and compiles everything; if started last, it would run alone
LONGEST = "test_packaging.py"


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Start the longest file first."""
    items.sort(key=lambda item: item.path.name != LONGEST)


@pytest.fixture
def rng() -> np.random.Generator:
    """Return a random generator with a fixed seed."""
    return np.random.default_rng(20240229)


@pytest.fixture
def fake_board():
    """Return a function that makes scripted boards, which are unplugged at the end."""
    from tests.devices.fake_board import FakeBoard

    boards = []

    def make(answer):
        boards.append(FakeBoard(answer))
        return boards[-1]

    yield make
    for board in boards:
        board.unplug()


@pytest.fixture(autouse=True)
def forget_settings():
    """Clear the window's stored settings after each test."""
    yield
    if "PySide6.QtCore" in sys.modules:
        from PySide6.QtCore import QSettings

        QSettings("hapkit-studio", "hapkit-studio").clear()
