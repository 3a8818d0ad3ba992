"""A pulled cable or a restarted board sets the force to zero, and reconnecting restores all settings."""

import time

import numpy as np
import pytest

from hapkit_studio.devices import hapkit
from hapkit_studio.devices.virtual_board import VirtualBoard, built
from hapkit_studio.gui.live.time_plots import LEAST
from hapkit_studio.gui.state import device_link
from hapkit_studio.haptics import rows
from tests.devices.fake_ports import FT232, info, list_ports
from tests.gui.window_support import SIMULATED
from tests.lateness import clear_lateness

pytestmark = pytest.mark.skipif(not built(), reason="the virtual board is not built")
SERIAL = "AB0LB3DQ"
EITHER = pytest.mark.parametrize("where", ["computer", pytest.param("board", marks=pytest.mark.alone)])


class Kit:
    """A virtual board on a cable: while it is plugged in, it is listed as an FT232."""

    def __init__(self, monkeypatch, mode):
        self.monkeypatch, self.program = monkeypatch, VirtualBoard(mode)
        self.program.start()
        self.list(self.program.port)
        (self.entry,) = hapkit.entries()

    def list(self, *paths):
        list_ports(self.monkeypatch, *(info(path, FT232, SERIAL, "1-2") for path in paths))

    def unplug(self):
        self.list()
        self.program.unplug()

    def plug(self):
        """Plug the board in again, usually with another port name because the pseudo-terminal is new."""
        self.program.plug()
        self.list(self.program.port)


@pytest.fixture
def where():
    return "computer"


@pytest.fixture
def kit(monkeypatch, where):
    """Return a kit in lockstep with the computer; a board that renders itself runs in real time instead."""
    monkeypatch.setattr(device_link, "RETRY_MS", 50)
    kit = Kit(monkeypatch, "lockstep" if where == "computer" else "paced")
    yield kit
    kit.program.end()


@pytest.fixture
def running(make_window, qtbot, kit):
    """Return a window that runs the kit with a wall of 300 N/m and has received a few hundred rows."""
    window = make_window((SIMULATED, kit.entry))
    window.studio.set_value("stiffness", 300.0)
    window.studio.set_loop(estimator="kalman")
    window.studio.device.open(kit.entry)
    until_link(window, qtbot, "running")
    rows_since(window, qtbot, 300)
    return window


def rows_since(window, qtbot, least, before=0):
    """Update the window until at least ``least`` new rows have arrived; return the history's length."""

    def enough():
        window.live.tick()
        return len(window.live.history) >= before + least

    qtbot.waitUntil(enough)
    return len(window.live.history)


def until_link(window, qtbot, state):
    def reached():
        window.live.refresh()
        if window.studio.link.state == "failed":
            window.studio.device.reconnect()  # the handshake exceeded its limit of 4 s
        return window.studio.link.state == state

    qtbot.waitUntil(reached)


def render(window, qtbot, where):
    """Select where the force is computed and wait for the change."""
    engine = window.studio.engine
    window.studio.set_loop(where=where)

    def so():
        clear_lateness(window.studio)
        return engine.rendering == where

    qtbot.waitUntil(so)


def until_pushed(window, kit, qtbot, target):
    """Move the hand and wait until the motor pushes back."""
    kit.program.move_hand(target)

    def pushed():
        clear_lateness(window.studio)
        return kit.program.status()["duty"] != 0

    qtbot.waitUntil(pushed)


@pytest.mark.slow
def test_replugged_with_another_name_settings_and_history_are_restored(running, kit, qtbot):
    window, studio = running, running.studio
    first = studio.engine.device.port
    kept = window.live.history.between(-np.inf, np.inf)
    kit.unplug()
    until_link(window, qtbot, "gone")
    notice = window.banners.get("device")
    name = first.removeprefix("/dev/")
    assert notice.title == f"Hapkit on {name} is disconnected."
    assert notice.text == "The force is zero. Trying to reconnect every second."
    assert not window.header.devices.dot.filled
    assert window.centre.time.shown.stale
    before = len(window.live.history)
    # wait until the gap is long enough to be marked
    qtbot.waitUntil(lambda: time.perf_counter() - window.live.history.now > 2 * LEAST)
    kit.plug()
    until_link(window, qtbot, "running")
    assert window.banners.get("device") is None
    assert studio.engine.device.port == kit.program.port
    assert studio.values["stiffness"] == studio.engine.values["stiffness"] == 300.0
    assert studio.engine.loop.estimator == "kalman"
    rows_since(window, qtbot, 300, before)
    # the old rows are unchanged; a marked gap and the new rows follow
    shown = window.live.history.between(-np.inf, np.inf)
    assert np.array_equal(shown.x[: len(kept.x)], kept.x, equal_nan=True)
    assert np.array_equal(shown.y["position"][: len(kept.x)], kept.y["position"], equal_nan=True)
    (broken,) = np.flatnonzero(np.isnan(shown.x[len(kept.x) - 1 :]))
    assert np.all(np.diff(shown.x[np.isfinite(shown.x)]) >= 0.0)
    assert broken > 0
    window.centre.time.read_window()
    longest = max(b - a for a, b in window.centre.time.shown.gaps)
    # the gap is shown with a resolution of 0.1 s; a dense plot locates its ends to one column only
    assert longest == pytest.approx(np.nanmax(np.diff(shown.x[np.isfinite(shown.x)])), abs=0.05)


@pytest.mark.slow
@EITHER
def test_the_motor_is_off_while_unplugged_and_a_restarted_board_is_found(running, kit, qtbot, where):
    window, studio = running, running.studio

    def push(target):
        render(window, qtbot, where)
        until_pushed(window, kit, qtbot, target)

    push(0.012)
    kit.unplug()
    begin = kit.program.status()["time"]
    # by the board's clock, the motor is off after a time-out of 25 ms, a tick, and the commands already sent
    while (status := kit.program.status())["duty"] != 0:
        assert status["time"] - begin < 0.030
    until_link(window, qtbot, "gone")
    kit.plug()
    until_link(window, qtbot, "running")
    rows_since(window, qtbot, 100, len(window.live.history))
    push(0.030)  # without a stored zero, the zero is the handle's position at the restart
    kit.program.send("reset")
    until_link(window, qtbot, "gone")
    assert kit.program.status()["duty"] == 0
    notice, name = window.banners.get("device"), kit.program.port.removeprefix("/dev/")
    assert notice.title == f"Hapkit on {name} has sent nothing for 1 s: it restarted or froze."
    assert notice.text == "The force is zero. Trying to reconnect every second."
    assert window.banners.get("fault") is None
    until_link(window, qtbot, "running")
    assert window.banners.get("device") is None
    assert studio.values["stiffness"] == studio.engine.values["stiffness"] == 300.0
    assert studio.engine.loop.estimator == "kalman"
    rows_since(window, qtbot, 100, len(window.live.history))
    push(0.050)


@EITHER
def test_the_emergency_stop_survives_an_unplugged_cable_and_a_restart_of_the_board(
    running, kit, qtbot, where
):
    window = running
    render(window, qtbot, where)
    until_pushed(window, kit, qtbot, 0.012)
    window.studio.stop()
    qtbot.waitUntil(lambda: kit.program.status()["duty"] == 0)
    for leave, come_back in ((kit.unplug, kit.plug), (lambda: kit.program.send("reset"), lambda: None)):
        leave()
        until_link(window, qtbot, "gone")
        come_back()
        until_link(window, qtbot, "running")
        assert window.studio.stopped
        # the board's zero is now the handle's position at the restart
        before = rows_since(window, qtbot, 100, len(window.live.history))
        kit.program.move_hand(0.040)
        duties = []

        def many(duties=duties, before=before):
            duties.append(kit.program.status()["duty"])
            window.live.tick()
            return len(window.live.history) >= before + 500

        qtbot.waitUntil(many)
        assert set(duties) == {0}
        assert int(window.live.last[rows.FLAGS]) & rows.STOPPED
        assert window.live.last[rows.APPLIED_FORCE] == 0.0
        assert window.banners.banners[0].title.text() == "Stopped. Force is zero."
        kit.program.move_hand(0.012)
    window.studio.release_stop()

    def released():
        clear_lateness(window.studio)  # while the board renders, a fault sets the flag STOPPED, too
        window.live.tick()
        return not int(window.live.last[rows.FLAGS]) & rows.STOPPED

    qtbot.waitUntil(released)
    if where == "computer":
        until_pushed(window, kit, qtbot, 0.040)
