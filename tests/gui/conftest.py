"""Fixtures of real windows, whose real engine runs the simulated Hapkit at normal priority."""

import gc
from contextlib import contextmanager
from functools import partial

import pytest
from PySide6.QtCore import QCoreApplication, QDeadlineTimer
from PySide6.QtTest import QTest

from hapkit_studio.arguments import window_parser
from hapkit_studio.gui.shell import app
from hapkit_studio.gui.shell.actions import new_window
from hapkit_studio.gui.shell.window import MainWindow
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.gui.widgets import style
from hapkit_studio.gui.widgets.theme import theme
from tests.gui.board_fixtures import board_window, held_board_window, scripted  # noqa: F401
from tests.gui.live.plot_fixtures import history, phase, plots  # noqa: F401
from tests.gui.window_support import PATIENCE_MS, SIMULATED, build_engine, delete_deferred, put_back


@pytest.fixture(autouse=True, scope="session")
def dressed(qapp):
    """Apply the style to the application."""
    style.apply(qapp)


@pytest.fixture(autouse=True)
def plain_start(dressed):
    """Start in the light theme at the usual size, after deleting widgets of earlier tests."""
    delete_deferred()
    with theme.together():
        theme.set_mode("light")
        theme.set_scale(1.0)


@pytest.fixture
def qtbot(qtbot, monkeypatch):
    """Return a qtbot with longer time-outs for a busy machine."""
    for wait in ("waitUntil", "waitSignal"):
        monkeypatch.setattr(qtbot, wait, partial(getattr(qtbot, wait), timeout=PATIENCE_MS))
    return qtbot


@pytest.fixture(autouse=True)
def home(tmp_path, monkeypatch):
    """Return a temporary folder that replaces the user's own."""
    monkeypatch.setenv("HAPKIT_STUDIO_FOLDER", str(tmp_path))
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    return tmp_path


@contextmanager
def open_windows():
    """Yield a factory of shown windows; afterwards, each window and its loop are closed."""
    with deleted_in_the_end() as windows:

        def make(entries=(SIMULATED,), build=build_engine, size=(1440, 900)) -> MainWindow:
            window = new_window(Studio(lambda: list(entries), build))
            windows.append(window)
            window.resize(*size)
            window.show()
            window.activateWindow()
            assert QTest.qWaitForWindowActive(window, PATIENCE_MS)
            return window

        yield make


@contextmanager
def deleted_in_the_end():
    """Yield a list for windows, which are closed and deleted afterwards."""
    windows: list[MainWindow] = []
    yield windows
    for window in windows:
        window.close()
        QCoreApplication.instance().removeEventFilter(window.stop_filter)
        window.deleteLater()
    delete_deferred()
    gc.enable()  # the window has disabled garbage collection


@pytest.fixture
def start_window(qapp):
    """Return a factory of windows that are created with command-line options and not shown."""

    def start(*options: str) -> MainWindow:
        windows.append(app.build(window_parser().parse_args(options)))
        return windows[-1]

    with deleted_in_the_end() as windows:
        yield start


@pytest.fixture
def make_window(qapp):
    """Return a factory of shown windows."""
    with open_windows() as make:
        yield make


@pytest.fixture
def idle_window(make_window) -> MainWindow:
    """Return a window without a device."""
    return make_window()


@pytest.fixture(scope="module")
def shared_window(dressed):
    """Return a window without a device for all tests of a file; each test restores its state."""
    theme.set_mode("light")
    with open_windows() as make:
        yield make()


@pytest.fixture
def reset_idle_window(shared_window) -> MainWindow:
    """Return the file's shared window without a device, in its initial state."""
    put_back(shared_window)
    return shared_window


@pytest.fixture
def window(make_window, qtbot) -> MainWindow:
    """Return a window with a running simulated Hapkit; a test updates the display by calling live.tick()."""
    shown = make_window()
    shown.studio.device.open(SIMULATED)
    qtbot.waitUntil(lambda: shown.studio.engine is not None, timeout=PATIENCE_MS)
    return shown


@pytest.fixture(scope="module")
def running_window(dressed):
    """Return a window with a running simulated Hapkit for all tests of a file."""
    theme.set_mode("light")
    with open_windows() as make:
        shown = make()
        shown.studio.device.open(SIMULATED)
        patience = QDeadlineTimer(PATIENCE_MS)
        while shown.studio.engine is None:
            assert not patience.hasExpired()
            QTest.qWait(5)
        yield shown


@pytest.fixture
def reset_window(running_window) -> MainWindow:
    """Return the file's shared running window, in its initial state."""
    put_back(running_window)
    return running_window
