"""A board in the window: the firmware in an emulated chip renders each law soon after its selection."""

import time

import numpy as np
import pytest

from hapkit_studio.devices import DeviceEntry
from hapkit_studio.devices.virtual_board import VirtualBoard, built
from hapkit_studio.haptics import rows
from hapkit_studio.haptics.block_content import FADE_SECONDS
from hapkit_studio.laws.board import compile as compile_for_board
from hapkit_studio.parameters import Parameter
from tests.gui.own_support import put, spring, wait_for_verdict
from tests.gui.window_support import SIMULATED
from tests.lateness import ATTEMPTS, clear_lateness, slowdown

pytestmark = pytest.mark.skipif(not built(), reason="the virtual board is not built")
HAND, ROWS = 0.014, 50
CHOICE_SECONDS, SLIDER_SECONDS = 1.0, 0.3
COMPILATIONS = 8
"""Smallest time limit as a multiple of a law's compile time.

A law is compiled at several rates, while the window draws.
"""


@pytest.fixture
def board_window(make_window, qtbot):
    """Return a window with a running board."""
    entry = DeviceEntry("virtual-board", "Virtual board", VirtualBoard)
    window = make_window((SIMULATED, entry))
    window.studio.device.open(entry)
    qtbot.waitUntil(lambda: window.studio.engine is not None)
    return window


def at_rest(window, qtbot, place):
    """Wait until the handle rests beyond a position in m for a number of rows; return the last row."""

    def rests():
        clear_lateness(window.studio)
        window.live.tick()
        last = window.live.last
        if last is None or last[rows.POSITION] < place or last[rows.FLAGS]:
            return False
        # count rows instead of seconds, because the emulated board is not in real time
        kept = window.live.history.between(-np.inf, np.inf).y
        pushed = np.abs(kept["applied_force"][-ROWS:]).min() > 0.2
        still = np.ptp(kept["position"][-ROWS:]) <= 2.1 * window.studio.engine.device.quantum
        return len(kept["position"]) > ROWS and pushed and still

    qtbot.waitUntil(rests)
    return window.live.last


def test_the_delay_is_measured_and_the_rate_comes_from_the_board(board_window, qtbot):
    window = board_window

    def measured():
        window.live.refresh()
        return 0.0 < (window.studio.engine.health().delay or 0.0) < 0.05

    qtbot.waitUntil(measured)
    assert not window.loop.rate.isEnabled()
    assert "own clock" in window.loop.rate.box.toolTip()
    assert window.loop.delay.isEnabled()
    assert window.loop.grip.isEnabled()


def has_active_law(window):
    """Return True if the board renders the active law with its current values."""
    clear_lateness(window.studio)
    engine = window.studio.engine
    state, offered = engine.driver.conn.state, engine.decision().plan
    announced = offered is not None and (state.code_id, state.program_id) == (
        offered.code_id,
        offered.program_id,
    )
    return announced and engine.rendering == "board" and state.tuning == 0


@pytest.mark.alone
@pytest.mark.parametrize("key", ["wall", "friction", "mass_spring_damper", "cat"])
def test_the_board_renders_a_selection_within_a_second_and_follows_a_slider(board_window, qtbot, key):
    window, studio = board_window, board_window.studio
    moved = next(p.key for p in studio.environments[key].parameters if isinstance(p, Parameter))
    studio.environments[key].force.compiled()

    def seconds(change):
        start = time.perf_counter()
        change()
        qtbot.waitUntil(lambda: has_active_law(window))
        return time.perf_counter() - start

    studio.set_loop(where="board")
    took = []
    for attempt in range(ATTEMPTS):
        seconds(lambda: studio.choose("spring"))
        chosen = seconds(lambda: studio.choose(key))
        value = studio.environments[key].values()[moved] * (1.0 + 0.02 * (attempt + 1))
        slid = seconds(lambda value=value: studio.set_value(moved, value))
        busy, compilation = slowdown(), compile_seconds(studio)
        took.append((chosen, slid, busy, compilation))
        least = max(SLIDER_SECONDS - FADE_SECONDS, COMPILATIONS * compilation)
        if chosen < CHOICE_SECONDS * busy and slid < least * busy:
            return
    pytest.fail(f"choice, slider, times that a computation took now, compilation of the law: {took}")


def compile_seconds(studio):
    """Return the time in s to compile the active law for the board once on this computer."""
    rate = studio.engine.decision().plan.rate
    start = time.perf_counter()
    compile_for_board(studio.environment.force, studio.values, 1.0 / rate)
    return time.perf_counter() - start


@pytest.mark.slow
def test_an_own_law_renders_on_the_board_as_soon_as_it_is_active(board_window, qtbot, home):
    window, studio = board_window, board_window.studio
    studio.set_loop(where="board")
    window.editor.edit(put(home, "test_spring.py", spring()))
    wait_for_verdict(window, qtbot, window.editor.save)
    assert studio.environment.key == "test_spring"
    qtbot.waitUntil(lambda: has_active_law(window))
    column = [label.text() for label in window.loop.where.facts.columns[1][1:]]
    assert column[1] == "4,000"
    assert 40 < int(column[4]) < 80
    studio.move_hand(HAND)
    row = at_rest(window, qtbot, 0.003)
    assert row[rows.FORCE] == pytest.approx(-100.0 * row[rows.POSITION], abs=1e-3)
