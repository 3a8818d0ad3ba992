"""A cable pulled and put back, a board that begins anew: zero force, a gap, and everything as it was."""

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
    """A kit on a cable: the virtual board's program, listed as an FT232 while it is plugged in."""

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
        """Put it back: a new pseudo-terminal, so mostly another name."""
        self.program.plug()
        self.list(self.program.port)


@pytest.fixture
def where():
    return "computer"


@pytest.fixture
def kit(monkeypatch, where):
    """Return a kit that waits for every answer; a board that renders by itself follows the clock."""
    monkeypatch.setattr(device_link, "RETRY_MS", 50)
    kit = Kit(monkeypatch, "lockstep" if where == "computer" else "paced")
    yield kit
    kit.program.end()


@pytest.fixture
def running(make_window, qtbot, kit):
    """Return a window that runs the kit, a wall of 300 N/m and a few hundred rows in it."""
    window = make_window((SIMULATED, kit.entry))
    window.studio.set_value("stiffness", 300.0)
    window.studio.set_loop(estimator="kalman")
    window.studio.device.open(kit.entry)
    until_link(window, qtbot, "running")
    rows_since(window, qtbot, 300)
    return window


def rows_since(window, qtbot, least, before=0):
    """Take frames until so many rows have come since; return how many there are."""

    def enough():
        window.live.tick()
        return len(window.live.history) >= before + least

    qtbot.waitUntil(enough)
    return len(window.live.history)


def until_link(window, qtbot, state):
    def reached():
        window.live.refresh()
        if window.studio.link.state == "failed":
            window.studio.device.reconnect()  # it took more than the 4 s of a handshake
        return window.studio.link.state == state

    qtbot.waitUntil(reached)


def render(window, qtbot, where):
    """Choose who renders, and wait until it does."""
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
def test_replugged_under_another_name_everything_is_as_it_was(running, kit, qtbot):
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
    # long enough out to be marked
    qtbot.waitUntil(lambda: time.perf_counter() - window.live.history.now > 2 * LEAST)
    kit.plug()
    until_link(window, qtbot, "running")
    assert window.banners.get("device") is None
    assert studio.engine.device.port == kit.program.port
    assert studio.values["stiffness"] == studio.engine.values["stiffness"] == 300.0
    assert studio.engine.loop.estimator == "kalman"
    rows_since(window, qtbot, 300, before)
    # what was there before is there still, then a gap that is marked, then the new rows
    shown = window.live.history.between(-np.inf, np.inf)
    assert np.array_equal(shown.x[: len(kept.x)], kept.x, equal_nan=True)
    assert np.array_equal(shown.y["position"][: len(kept.x)], kept.y["position"], equal_nan=True)
    (broken,) = np.flatnonzero(np.isnan(shown.x[len(kept.x) - 1 :]))
    assert np.all(np.diff(shown.x[np.isfinite(shown.x)]) >= 0.0)
    assert broken > 0
    window.centre.time.take()
    longest = max(b - a for a, b in window.centre.time.shown.gaps)
    # its length is said to 0.1 s; a plot of more samples than columns knows the ends to a column
    assert longest == pytest.approx(np.nanmax(np.diff(shown.x[np.isfinite(shown.x)])), abs=0.05)


@pytest.mark.slow
@EITHER
def test_the_motor_is_off_while_the_cable_is_out_and_a_board_that_begins_anew_is_found_again(
    running, kit, qtbot, where
):
    window, studio = running, running.studio

    def push(target):
        render(window, qtbot, where)
        until_pushed(window, kit, qtbot, target)

    push(0.012)
    kit.unplug()
    begin = kit.program.status()["time"]
    # by the board's own clock: 25 ms, a tick, and what was on its way
    while (status := kit.program.status())["duty"] != 0:
        assert status["time"] - begin < 0.030
    until_link(window, qtbot, "gone")
    kit.plug()
    until_link(window, qtbot, "running")
    rows_since(window, qtbot, 100, len(window.live.history))
    push(0.030)  # without a stored zero it is where the handle was when the board came back
    kit.program.send("reset")
    until_link(window, qtbot, "gone")
    assert kit.program.status()["duty"] == 0
    notice, name = window.banners.get("device"), kit.program.port.removeprefix("/dev/")
    assert notice.title == f"Hapkit on {name} has sent nothing for 1 s: it restarted or hangs."
    assert notice.text == "The force is zero. Trying to reconnect every second."
    assert window.banners.get("fault") is None
    until_link(window, qtbot, "running")
    assert window.banners.get("device") is None
    assert studio.values["stiffness"] == studio.engine.values["stiffness"] == 300.0
    assert studio.engine.loop.estimator == "kalman"
    rows_since(window, qtbot, 100, len(window.live.history))
    push(0.050)


@EITHER
def test_the_emergency_stop_outlives_the_cable_and_a_board_that_begins_anew(running, kit, qtbot, where):
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
        before = rows_since(window, qtbot, 100, len(window.live.history))  # its zero is where it is found
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
        clear_lateness(window.studio)  # while the board renders, a fault stops it as well
        window.live.tick()
        return not int(window.live.last[rows.FLAGS]) & rows.STOPPED

    qtbot.waitUntil(released)
    if where == "computer":
        until_pushed(window, kit, qtbot, 0.040)
