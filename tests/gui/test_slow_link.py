"""A link that is slow, or whose delay nobody knows: said at once, with the way out beside it."""

import pytest

from hapkit_studio.gui import notices
from hapkit_studio.haptics import arrays
from hapkit_studio.haptics.clib import store_release
from hapkit_studio.haptics.link import latch
from tests.gui.board_fixtures import answered
from tests.gui.window_support import PATIENCE_MS

WAY_OUT = "Render on the board"


def ways_on(window, key):
    """Return the buttons of a banner by their words."""
    return dict(window.banners.get(key).buttons)


def measure(window, delay, which=0):
    """Let one way of rendering have had a delay in s for a while."""
    delays = window.studio.engine.driver.conn.delays
    delays.values[which, :500], delays.counts[which] = delay, 500
    window.live.look()


def test_a_link_too_slow_for_the_computer_offers_the_board(board_window):
    studio, engine = board_window.studio, board_window.studio.engine
    latch(engine.arrays, arrays.SLOW_LINK, 0.032, 0.025)
    board_window.live.look()
    notice = board_window.banners.get("fault")
    assert "32 ms from a sample to its force" in notice.title
    assert [words for words, _ in notice.buttons] == [WAY_OUT, "Clear fault"]
    ways_on(board_window, "fault")[WAY_OUT]()
    assert studio.loop.where == engine.where == "board"


def test_other_faults_do_not(board_window):
    latch(board_window.studio.engine.arrays, arrays.OVER_SPEED, 3.4, 0.0)
    board_window.live.look()
    assert list(ways_on(board_window, "fault")) == ["Clear fault"]


def test_a_long_delay_is_said_by_the_card_with_what_helps(board_window, qtbot):
    words = board_window.stability.words
    board_window.studio.set_value("stiffness", 1500.0)
    measure(board_window, 4e-3)
    qtbot.waitUntil(lambda: "4.00 ms from sensor to motor" in words.text(), timeout=PATIENCE_MS)
    assert "render on the board" in words.text()
    assert board_window.banners.banners == []


@pytest.mark.slow
def test_the_board_is_not_offered_where_it_cannot(board_window, qtbot):
    studio = board_window.studio
    studio.choose("mass_spring_damper")
    studio.set_values({"integrator": "exact", "stiffness": 2000.0, "contact_stiffness": 5000.0})
    answered(board_window, qtbot)
    latch(studio.engine.arrays, arrays.SLOW_LINK, 0.032, 0.025)
    board_window.live.look()
    assert list(ways_on(board_window, "fault")) == ["Clear fault"]


def test_a_delay_that_nobody_can_measure_is_said(board_window, qtbot, monkeypatch):
    monkeypatch.setattr(notices, "NO_DELAY_MS", -1)
    board_window.live.look()
    assert board_window.banners.get("delay") is None  # no sample has come, so no force has gone
    board_window.notices._heard = True
    board_window.live.look()
    notice = board_window.banners.get("delay")
    assert notice.title == "The delay of the link cannot be measured."
    assert list(ways_on(board_window, "delay")) == [WAY_OUT]
    measure(board_window, 1e-3)
    assert board_window.banners.get("delay") is None


@pytest.mark.parametrize("stopped", [True, False])
def test_a_delay_is_not_missed_while_no_force_goes_out(board_window, monkeypatch, stopped):
    monkeypatch.setattr(notices, "NO_DELAY_MS", -1)
    board_window.notices._heard = True
    if stopped:
        board_window.studio.stop()
    else:
        store_release(board_window.studio.engine.arrays.control, arrays.FAULT, arrays.OVER_SPEED)
    board_window.live.look()
    assert board_window.banners.get("delay") is None
