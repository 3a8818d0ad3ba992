"""The switch between rendering by computer and by board, and the table that compares them."""

import re

import pytest
from PySide6.QtWidgets import QScrollArea

from hapkit_studio.analysis import board_alternative
from hapkit_studio.dynamics.estimators import ESTIMATORS
from hapkit_studio.dynamics.integrators import INTEGRATORS
from hapkit_studio.dynamics.loop_settings import RENDERERS
from hapkit_studio.gui.live.comparison import movement
from hapkit_studio.gui.panel import rendering
from hapkit_studio.haptics import link
from hapkit_studio.haptics.board_plan import BackgroundPlanner
from tests.gui.board_fixtures import answered
from tests.gui.window_support import PATIENCE_MS


def column(window, index):
    return [label.text() for label in window.loop.where.facts.columns[index][1:]]


def test_the_simulated_hapkit_has_no_switch(reset_window):
    assert reset_window.loop.where.isHidden()
    assert "no board" in reset_window.studio.engine.decision().refusal


def test_a_board_has_a_switch_and_the_engine_follows_it(board_window):
    switch, engine = board_window.loop.where, board_window.studio.engine
    assert switch.isVisibleTo(board_window)
    assert engine.where == "computer"
    switch.switch.button(1).click()
    assert engine.where == board_window.studio.loop.where == "board"
    assert engine.decision().in_force.rate == rendering.renderers(board_window.studio)[1].rate
    switch.switch.button(0).click()
    assert engine.where == "computer"


def test_the_board_rate_is_chosen_beside_it(board_window, qtbot):
    switch, studio = board_window.loop.where, board_window.studio
    studio.set_loop(where="board")
    switch.rate.changed.emit("board_rate", 8.0)
    answered(board_window, qtbot)
    assert studio.engine.decision().in_force.rate == 500
    assert column(board_window, 1)[1] == "500"
    assert board_window.loop.summary().startswith("Board 500 Hz")


def test_the_panel_shows_the_board_rate_for_each_law_and_method(board_window, qtbot):
    studio, loop = board_window.studio, board_window.loop
    studio.set_loop(where="board")
    rates = []
    for key, values in (
        ("wall", {}),
        ("puck", {"integrator": "semi_implicit"}),
        ("puck", {"integrator": "verlet"}),
    ):
        studio.choose(key)
        studio.set_values(values)
        answered(board_window, qtbot)
        rates.append(studio.engine.decision().in_force.rate)
        rate = f"{rates[-1]:,.0f}"
        assert loop.fold.accessibleName() == f"Loop: Board {rate} Hz · Kalman"
        assert loop.rate.box.text() == rate
        assert column(board_window, 1)[1] == rate
        share = round(100.0 * studio.engine.decision().in_force.share)
        assert 40 <= share <= 80
        assert column(board_window, 1)[4] == f"{share}"
        assert column(board_window, 0)[4] == rendering.UNKNOWN
    assert rates[0] > rates[1] > rates[2]


@pytest.mark.slow
def test_a_law_too_large_for_the_board_states_the_excess_and_an_alternative(board_window, qtbot):
    switch, studio = board_window.loop.where, board_window.studio
    studio.set_loop(where="board")
    studio.choose("mass_spring_damper")
    studio.set_value("integrator", INTEGRATORS.index("exact"))
    answered(board_window, qtbot)
    assert switch.switch.index == 0
    assert not switch.switch.button(1).isEnabled()
    assert re.match(
        r"Mass–spring–damper needs [\d,]+ bytes of memory, but the board has 760\.", switch.note.text()
    )
    qtbot.waitUntil(switch.instead.isVisible, timeout=PATIENCE_MS)
    found = re.search(
        r"feels like your choice: the forces differ by at most (0\.\d\d) N \(largest force: (\d\.\d) N\)\.",
        switch.note.text(),
    )
    assert 0.0 <= float(found[1]) <= board_alternative.FELT * float(found[2])
    switch.instead.click()
    assert INTEGRATORS[int(studio.values["integrator"])] in ("semi_implicit", "verlet")
    answered(board_window, qtbot)
    assert switch.switch.index == 1
    assert switch.instead.isHidden()
    assert "needs" not in switch.note.text()


def test_known_facts_stay_visible_until_the_board_has_answered(board_window, qtbot, monkeypatch):
    switch, studio = board_window.loop.where, board_window.studio
    before = column(board_window, 1)
    monkeypatch.setattr(BackgroundPlanner, "plan", lambda self, planner, request: planner.known(request))
    studio.choose("hard_surface")
    board_window.live.refresh()
    assert column(board_window, 1)[1] == before[1]
    assert switch.switch.button(1).isEnabled()
    assert not switch.note.text()
    monkeypatch.undo()
    answered(board_window, qtbot)
    assert column(board_window, 1)[1] == "3,300"


@pytest.mark.slow
def test_settings_that_the_board_ignores_are_stated(board_window, qtbot):
    studio, note = board_window.studio, board_window.loop.where.note
    studio.set_loop(estimator="butterworth", delay=0.002, controller=True, where="board")
    answered(board_window, qtbot)
    for text in ("uses the Kalman filter", "added delay", "passivity controller"):
        assert text in note.text()
    beside = board_window.loop.controller_hint
    assert "not active while the board computes" in beside.text()
    assert not beside.isHidden()
    assert re.match(r"The law uses \d\d % of the board's processor\.", note.text())
    studio.set_loop(where="computer")
    assert not note.text()
    assert "computer's loop" not in beside.text()


@pytest.mark.slow
def test_delay_and_limit_of_both_renderers_are_shown_side_by_side(board_window, qtbot):
    studio = board_window.studio
    delays = studio.engine.driver.conn.delays
    for which, delay in ((0, 1.0e-3), (1, 0.2e-3)):
        delays.values[which, :500] = delay
        delays.counts[which] = 500
    board_window.live.refresh()
    assert column(board_window, 0)[0] == "1.00 ± 0.00"
    assert column(board_window, 1)[0] == "0.20 ± 0.00"
    qtbot.waitUntil(lambda: column(board_window, 1)[2] != rendering.UNKNOWN, timeout=PATIENCE_MS)
    here, there = (int(column(board_window, i)[2].replace(",", "")) for i in (0, 1))
    assert there > here > 0
    facts, loop = board_window.loop.where.facts, board_window.loop
    for folded, rows in ((True, 3), (False, 6)):
        loop.set_folded(folded)
        seen = [label for label in facts.columns[1] if label.isVisibleTo(board_window)]
        assert len(seen) == rows


@pytest.mark.slow
@pytest.mark.parametrize("where", ["computer", "board"])
def test_table_and_card_show_the_same_delay(board_window, qtbot, where):
    studio, card = board_window.studio, board_window.stability
    conn, index = studio.engine.driver.conn, RENDERERS.index(where)
    studio.set_loop(where=where)
    conn.state.handover = link.ON_BOARD if where == "board" else link.ON_COMPUTER
    for delay in (0.140e-3, 0.1449e-3, 0.1495e-3, 0.157e-3, 0.934e-3, 0.949e-3, 0.966e-3):
        conn.delays.values[index, :500], conn.delays.counts[index] = delay, 500
        board_window.live.refresh()
        shown = column(board_window, index)[0].split()[0]
        assert 1e-3 * float(shown) == pytest.approx(delay, abs=8e-6 if delay < 0.5e-3 else 16e-6)
        qtbot.waitUntil(
            lambda shown=shown: f"The delay is {shown} ms" in card.label.text(), timeout=PATIENCE_MS
        )
    engine = studio.engine
    rate = 1000.0 if where == "computer" else engine.decision().in_force.rate
    assert (card.facts.setting().rate, card.facts.setting().delay) == (
        rate,
        pytest.approx(0.966e-3, abs=16e-6),
    )


@pytest.mark.slow
@pytest.mark.parametrize("where", RENDERERS)
def test_every_loop_fits_a_small_window(board_window, qtbot, where):
    window, studio = board_window, board_window.studio
    window.resize(1280, 720)
    window.show()
    area = next(a for a in window.findChildren(QScrollArea) if a.isAncestorOf(window.loop))
    for estimator in ESTIMATORS:
        studio.set_loop(where=where, estimator=estimator, delay=0.1)
        for folded in (True, False):
            window.loop.set_folded(folded)
            qtbot.wait(20)
            assert area.widget().minimumSizeHint().width() <= area.viewport().width(), window.loop.summary()
    used = "Kalman" if where == "board" else "FOAW"  # the board has no FOAW filter and uses Kalman
    studio.set_loop(estimator="foaw")
    assert used in window.loop.summary()


@pytest.mark.parametrize(
    ("hands", "name"), [(("released", "press"), "press"), (("sweep", "released"), "sweep"), ((), "press")]
)
def test_the_comparison_uses_a_movement_of_the_scene(hands, name):
    from hapkit_studio.dynamics.hand import hand_named

    assert movement(hands) is hand_named(name)
