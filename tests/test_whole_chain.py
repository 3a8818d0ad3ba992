"""The whole chain from encoder to motor to plot: window, loop, and firmware in the virtual board."""

import time

import numpy as np
import pytest
from pytestqt.qtbot import QtBot

from hapkit_studio.devices import DeviceEntry
from hapkit_studio.devices.virtual_board import VirtualBoard, truth
from hapkit_studio.gui.shell.actions import new_window
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.haptics import arrays, rows
from hapkit_studio.haptics.engine import Engine
from hapkit_studio.haptics.rows import RingReader
from hapkit_studio.protocol.framing import Decoder
from hapkit_studio.protocol.messages import Force
from tests.firmware.vb import FULL_FORCE, QUANTUM, needs_board
from tests.gui.window_support import PATIENCE_MS, build_engine
from tests.lateness import clear_lateness
from tests.waiting import wait_until

# a board in real time next to a window needs a machine without other tests
pytestmark = [needs_board, pytest.mark.alone]

STIFFNESS = 220.0
SURFACE = 0.005
# the hand moves into and out of the wall repeatedly; pushes disturbed by a busy machine are ignored
PUSHES = [
    f"{start + at} hand {to} 400 8 0.1 {within}"
    for start in range(0, 120, 3)
    for at, to, within in ((0.9, 0.016, 0.4), (2.2, -0.002, 0.3))
]
SAMPLES = 2600
DEEP = 500
ALL = 10**6


@pytest.fixture(scope="module")
def session(tmp_path_factory, request, qapp):
    """Return (telemetry rows, truth, history) of pushes into the wall, with enough undisturbed samples."""
    folder = tmp_path_factory.mktemp("pushes")
    log, script = folder / "truth.f64", folder / "push.txt"
    script.write_text("\n".join(PUSHES) + "\n")
    board = VirtualBoard("lockstep", log=log, script=script)
    entry = DeviceEntry("virtual-board", "Virtual board", lambda: board)
    window = new_window(Studio(lambda: [entry], build_engine))
    window.show()
    window.studio.choose("wall")
    window.studio.set_value("stiffness", STIFFNESS)
    readers, seen = [], []
    window.studio.engine_changed.connect(lambda: readers.append(from_the_first_row(window.studio.engine)))
    window.live.start()
    window.studio.device.open(entry)

    def enough() -> bool:
        if not readers:
            return False
        clear_lateness(window.studio.engine)
        seen.append(readers[0].read())
        return sum(map(len, seen)) >= SAMPLES and sum(map(deep, seen)) > 1.2 * DEEP

    QtBot(request).waitUntil(enough, timeout=PATIENCE_MS)
    window.live.stop()
    window.live.tick()
    seen.append(readers[0].read())
    assert readers[0].lost == window.live.lost == 0
    history = window.live.history.copy()
    window.close()
    qapp.removeEventFilter(window.stop_filter)
    return np.concatenate(seen), truth(log), history


def deep(table: np.ndarray) -> int:
    """Return the number of rows deep in the wall with full force."""
    return np.count_nonzero((table[:, rows.FLAGS] == 0) & (table[:, rows.POSITION] > SURFACE + 0.001))


def from_the_first_row(engine: Engine) -> RingReader:
    """Return a reader of all rows, as a board in lockstep may be several hundred rows ahead of the window."""
    reader = engine.reader()
    reader.rewind(ALL)
    return reader


def last_command(engine: Engine) -> float:
    """Return the force of the last frame written."""
    first = Decoder().bodies(engine.driver.conn.frame.tobytes())[0]
    return Force.unpack(first).force


def aligned(table: np.ndarray, log: np.recarray) -> np.recarray:
    """Return the true values at the samples of the telemetry; the chip's clock is less than 3 ms ahead."""
    starts = [np.searchsorted(log.time, table[0, rows.BOARD_TIME] + late) for late in (0.0, 1e-3, 2e-3)]
    index = np.rint((table[:, rows.BOARD_TIME] - table[0, rows.BOARD_TIME]) * 1e3).astype(int)
    found = [log[np.minimum(start + index, log.size - 1)] for start in starts]
    apart = [np.abs(row.position - row.position[0] - table[:, rows.POSITION]).max() for row in found]
    best = found[int(np.argmin(apart))]
    assert np.ptp(best.time - table[:, rows.BOARD_TIME]) < 1e-6
    return best


def test_force_at_the_pwm_registers_is_minus_k_d_and_the_plots_show_the_ring(session):
    table, log, history = session
    real = aligned(table, log)
    moved = real.position - real.position[0]
    seen = table[:, rows.POSITION]
    assert np.abs(seen - moved).max() <= QUANTUM * (1.0 + 1e-6)
    # the motor applies the reply to sample k at sample k + 1
    depth = np.maximum(moved[:-1] - SURFACE, 0.0)
    force = real.motor_force[1:]
    step = FULL_FORCE * (np.abs(real.duty[1:]) + 1.0) / 255.0**2
    # rows with flags are left out, because zero force replaces the reply if the loop was delayed
    steady = (table[:-1, rows.FLAGS] == 0) & (table[1:, rows.FLAGS] == 0)
    # rows before this time are left out, because the force is zero and then fades in
    steady &= table[:-1, rows.BOARD_TIME] > table[0, rows.BOARD_TIME] + 0.6
    assert np.count_nonzero(steady & (depth > 0.001)) > DEEP
    assert np.all(np.abs(force + STIFFNESS * depth)[steady] <= (step + STIFFNESS * QUANTUM)[steady])
    applied = table[:-1, rows.APPLIED_FORCE]
    assert np.all(np.abs(force - applied)[steady] <= step[steady])
    assert np.abs(applied).max() > 1.0

    shown = history.between(-np.inf, np.inf)
    # the window started later than the loop, which continued after the window's last frame
    at = table[:, rows.HOST_TIME]
    both = (at >= shown.x[0]) & (at <= shown.x[-1])
    assert np.count_nonzero(both) >= SAMPLES / 2
    assert np.array_equal(both, np.isin(at, shown.x))
    for name, column in (
        ("position", rows.POSITION),
        ("applied_force", rows.APPLIED_FORCE),
        ("force", rows.FORCE),
    ):
        plotted = shown.y[name][np.isin(shown.x, at)]
        assert np.array_equal(plotted, table[both, column])


def test_after_connecting_the_force_stays_zero_for_half_a_second(session):
    table, log, _ = session
    real = aligned(table, log)
    first = table[:, rows.BOARD_TIME] - table[0, rows.BOARD_TIME] < 0.499
    assert np.count_nonzero(first) > 490
    assert np.all(real.duty[first] == 0)
    assert np.all(table[first, rows.APPLIED_FORCE] == 0.0)


def test_unplugged_under_real_time_priority_the_loop_ends_with_a_zero_command(tmp_path):
    log = tmp_path / "truth.f64"
    board = VirtualBoard("paced", log=log)
    engine = Engine(board, "spring")
    reader = engine.reader()
    engine.start()
    try:
        engine.set_environment("spring", {"center": 0.01, "stiffness": 200.0})
        pushing = []
        wait_until(lambda: pushing.append(reader.read()) or np.any(pushing[-1][:, rows.APPLIED_FORCE] > 0.5))
        board.unplug()
        wait_until(lambda: engine.fault is not None)
        assert engine.fault.code == arrays.DEVICE_GONE
        wait_until(lambda: not engine.health().running)
        wait_until(lambda: engine.arrays.control.done[0] == 1)
        before, begin = time.process_time(), time.perf_counter()
        wait_until(lambda: time.perf_counter() - begin > 0.5)
        assert time.process_time() - before < 0.1
        assert last_command(engine) == 0.0
        wait_until(lambda: board.status()["duty"] == 0)
    finally:
        engine.close()
