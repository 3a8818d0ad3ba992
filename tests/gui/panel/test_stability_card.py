"""The stability card: verdict and limit in the card, on the map and in the status bar."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from hapkit_studio import environments
from hapkit_studio.analysis.stability.kb_plane import hands
from hapkit_studio.analysis.stability.verdict import VerdictInput
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.gui.panel.limits import CardRequest, answer
from hapkit_studio.gui.panel.stability_card import StabilityMap
from hapkit_studio.gui.widgets.theme import theme
from tests.gui.live.plot_support import colored
from tests.gui.window_support import PATIENCE_MS

SPRING, WALL = environments.named("spring"), environments.named("wall")


@pytest.fixture
def window(reset_window):
    """Return the window with the running simulated device."""
    return reset_window


def asked(stiffness, damping=0.0, setting=None, environment=SPRING):
    values = environment.values({"stiffness": stiffness, "damping": damping})
    return CardRequest(VerdictInput(environment, values, setting or LoopSettings()), 8.0)


def shown_texts(window):
    """Return the card's headline and text, and the status bar's text."""
    card, field = window.stability, window.status.margin
    sign = field.sign.name, field.sign.token
    return card.verdict.text, card.label.text(), field.label.text(), sign


def test_the_boundary_passes_through_the_limit_at_the_requested_damping():
    found = answer(asked(250.0, 4.0))
    assert dict(found.edge)[4.0] == found.verdict.margins["released"].limit
    assert dict(found.friction)[4.0] > dict(found.edge)[4.0]


@pytest.mark.slow
@pytest.mark.parametrize("scale", [1.0, 1.5])
def test_the_ring_of_a_dot_at_zero_damping_covers_no_number(window, scale):
    canvas = StabilityMap()
    theme.set_scale(scale)
    canvas.resize(round(240 * scale), canvas.height())
    canvas.show_answer(answer(asked(2000.0, setting=LoopSettings(delay=1e-3))))
    picture = canvas.grab().toImage()
    frame, drawn = canvas.measure(), colored(picture, "axis")
    numbers, ring = drawn[drawn[:, 1] < frame.bottom(), 0], colored(picture, "warn")[:, 0]
    assert numbers.min() > 2
    assert frame.left() - 11 * scale < ring.min() < frame.left() - 7 * scale
    assert numbers[numbers < frame.left()].max() + 1 < ring.min()


@pytest.mark.slow
def test_card_and_status_bar_state_the_verdict_without_a_banner(window, qtbot):
    studio = window.studio
    studio.choose("spring")
    studio.set_value("stiffness", 900.0)
    qtbot.waitUntil(
        lambda: "After you let go, the handle is stable, 1.1 × below the limit." in shown_texts(window)[0],
        timeout=PATIENCE_MS,
    )
    assert shown_texts(window)[0].startswith("In your hand, the handle is stable, ")
    assert "Limit without friction: 1,002 N/m after you let go." in shown_texts(window)[1]
    assert shown_texts(window)[2:] == ("Stable, 1.1 × below the limit", ("check", "ok"))
    studio.set_value("stiffness", 2000.0)
    qtbot.waitUntil(lambda: "and let go, it buzzes at " in shown_texts(window)[0], timeout=PATIENCE_MS)
    assert "Reason: 2,000 N/m is above the limit of 1,002 N/m after you let go." in shown_texts(window)[1]
    assert shown_texts(window)[2:] == ("Buzzes if you let go", ("triangle", "warn"))
    assert window.banners.banners == []
    studio.set_loop(hand="released")
    qtbot.waitUntil(lambda: "In your hand" not in shown_texts(window)[0], timeout=PATIENCE_MS)


def test_each_hand_has_its_own_sign(window):
    """At 1,800 N/m and 1 ms delay, a light grip is stable, but a released handle buzzes after a tiny push."""
    card = window.stability
    card.show_answer(answer(asked(1800.0, 0.0, LoopSettings(delay=1e-3, hand="light"))))
    seen = [(line.sign.token, line.label.property("ink")) for line in card.verdict.lines]
    assert card.verdict.text.startswith("In your hand, the handle is stable")
    assert seen == [("ok", "ink"), ("warn", "warn")]
    card.show_answer(answer(asked(250.0)))
    assert "In your hand" not in card.verdict.text, "nobody holds it"


@pytest.mark.slow
@pytest.mark.parametrize(("environment", "hand"), [(SPRING, "released"), (WALL, "medium")])
def test_the_map_belongs_to_the_hand_that_determines_the_verdict(window, environment, hand):
    """A released handle leaves a wall, so the wall's map belongs to a handle pressed into it."""
    card, setting = window.stability, LoopSettings(delay=1e-3, hand="medium")
    found = answer(asked(1800.0, 0.0, setting, environment))
    card.show_answer(found)
    limit = hands(setting, 0.0)[hand]
    assert dict(found.edge)[0.0] == limit
    assert ("while you hold the handle" if hand == "medium" else "after you let go") in card.caption.text()
    assert f"{limit:,.0f} N/m" in card.label.text()
    assert card.calm == (limit > 1800.0)


def test_without_stiffness_there_is_no_stiffness_limit(window):
    card, damping = window.stability, environments.named("damping")
    for strength, want in ((4.0, False), (50.0, True)):
        scene = VerdictInput(damping, damping.values({"damping": strength}), LoopSettings(delay=1e-3))
        card.show_answer(answer(CardRequest(scene, 8.0)))
        assert "N/m" not in card.label.text()
        assert ("the damping is too high" in card.label.text()) == want


def test_a_scene_without_a_limit_is_judged_by_simulation(window, qtbot):
    studio = window.studio
    studio.set_loop(controller=True)
    qtbot.waitUntil(
        lambda: "passivity controller is on. The limits do not include it" in shown_texts(window)[1],
        timeout=PATIENCE_MS,
    )
    assert shown_texts(window)[0].startswith("In your hand, the handle is stable.")
    studio.set_loop(controller=False, estimator="foaw")
    qtbot.waitUntil(lambda: "filter is not linear" in shown_texts(window)[1], timeout=PATIENCE_MS)
    assert not window.stability.map.isVisible()
    studio.choose("free")
    qtbot.waitUntil(lambda: "has no stiffness" in shown_texts(window)[1], timeout=PATIENCE_MS)
    assert (
        shown_texts(window)[0]
        == "In your hand, the handle is stable.\nAfter you let go, the handle is stable."
    )


@pytest.mark.slow
def test_the_limit_with_a_kalman_filter_uses_the_device_quantum(window, monkeypatch):
    """At 5 N·s/m, eigenvalues give limits of 3628 N/m for a quantum of 61 µm and 9553 N/m for 5 µm."""
    for quantum, want in ((61e-6, 3628.0), (5e-6, 9553.0)):
        setting = LoopSettings(quantum=quantum, estimator=("kalman", {"q": 1e-2}))
        found = answer(asked(300.0, 5.0, setting))
        assert abs(found.verdict.limit - want) < 1.0
        assert abs(dict(found.edge)[5.0] - want) < 1.0
    engine = window.studio.engine
    monkeypatch.setattr(engine, "device", replace(engine.device, quantum=61e-6))
    assert window.stability.facts.setting().quantum == 61e-6


def test_a_scene_is_judged_with_its_model(window, monkeypatch):
    facts, bare = window.panel.stability.facts, replace(SPRING, needs=("mass", "viscous"))
    window.studio.choose("spring")
    # friction and sensor step are those of the usual Hapkit
    for environment, friction, step in ((SPRING, 0.10, 20.7e-6), (bare, 0.0, 20.7e-6)):
        monkeypatch.setattr(type(window.studio.engine), "environment", environment)
        assert (facts.setting().coulomb, facts.setting().quantum) == (friction, step)


def test_an_old_verdict_is_cleared_if_the_next_is_late(window, qtbot):
    """For example, a student's law may be slow. No old text or hatching is shown beside the new values."""
    studio, card, page = window.studio, window.stability, window.views.page("stability")
    studio.choose("spring")
    card.show_answer(answer(asked(2000.0)))
    assert studio.unstable_ranges
    before = len(colored(card.map.viewport().grab().toImage(), "unstable"))
    card._worker.late.emit()
    page._worker.late.emit()
    assert shown_texts(window) == ("Judging the stability…", "", "Judging the stability…", ("", "ink2"))
    assert not card.map.isHidden()
    assert (studio.unstable_ranges, card.calm) == ({}, False)
    assert len(colored(card.map.viewport().grab().toImage(), "unstable")) < before
    assert page.verdict_column.heading.text() == "Judging the stability…"
    assert (page.chart.pale, page.verdict_column.answers.text) == (True, "")
    card.show_answer(answer(asked(250.0)))
    assert shown_texts(window)[2].startswith("Stable, ")


@pytest.mark.parametrize(("stiffness", "ring"), [(250.0, False), (2000.0, True)])
def test_the_dot_is_at_its_values_with_a_ring_beyond_the_limit(window, stiffness, ring):
    shown = window.stability.map
    window.stability.show_answer(answer(asked(stiffness, 0.0)))
    picture, place = shown.viewport().grab().toImage(), shown.pixel(0.0, stiffness)
    dot = colored(picture, "accent").mean(axis=0) + 0.5
    assert dot == pytest.approx([place.x(), place.y()], abs=1.5)
    assert bool(len(colored(picture.copy(int(place.x()) - 12, int(place.y()) - 12, 24, 24), "warn"))) == ring


@pytest.mark.slow
def test_a_fault_before_the_first_delay_is_not_shown_as_measuring(board_window, qtbot, monkeypatch):
    card, engine = board_window.stability, board_window.studio.engine
    fault = SimpleNamespace(text="Fault: no sensor reading arrived for 20 ms.", detail="", code=1)
    qtbot.waitUntil(lambda: card.verdict.text == "Measuring the delay", timeout=PATIENCE_MS)
    monkeypatch.setattr(type(engine), "fault", property(lambda _self: fault))
    board_window.live.refresh()
    qtbot.waitUntil(lambda: card.verdict.text == "Delay not measured", timeout=PATIENCE_MS)
