"""The stability card: the limit of the loop in force, in words, on the map and in the status bar."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from hapkit_studio.analysis.setting import Setting
from hapkit_studio.analysis.stability.kb_plane import limit
from hapkit_studio.analysis.stability.margin import Margin
from hapkit_studio.gui.panel.limits import Answer, Question, answer
from hapkit_studio.gui.panel.stability_card import differs_by_noise_only, judge
from tests.gui.live.plot_support import colored
from tests.gui.window_support import PATIENCE_MS

SETTING = Setting()
LATER = replace(SETTING, delay=SETTING.delay + 20e-6)


@pytest.fixture
def window(kept_window):
    """Return the window whose simulated device runs."""
    return kept_window


def judged(stiffness, bound, damping=0.0, setting=SETTING):
    question = Question(setting, stiffness, damping, 8.0)
    return Answer(question, Margin(stiffness, damping, bound), ())


def said(window):
    """Return headline and words of the card, and what the status bar says."""
    card, field = window.stability, window.status.margin
    sign = field.sign.name, field.sign.token
    return card.verdict.words.text(), card.words.text(), field.words.text(), sign


def test_the_boundary_passes_through_the_limit_at_the_questions_damping():
    found = answer(Question(SETTING, 250.0, 4.0, 8.0))
    assert dict(found.boundary)[4.0] == found.margin.limit
    assert found.stable


def test_the_card_and_the_status_bar_judge_the_loop_in_force_without_a_banner(window, qtbot):
    studio = window.studio
    studio.set_value("stiffness", 900.0)
    qtbot.waitUntil(lambda: "1.1 × below" in said(window)[0], timeout=PATIENCE_MS)
    assert "Stiffness limit 1,002 N/m." in said(window)[1]
    studio.set_loop(delay=0.002)

    def beyond() -> bool:
        window.live.look()  # the loop takes the new delay at its next tick
        return "above the limit" in said(window)[0]

    qtbot.waitUntil(beyond, timeout=PATIENCE_MS)
    bound = limit(Setting(delay=0.002, estimator="iir"), 0.0)
    assert f"Lower stiffness below {bound:.0f} N/m." in said(window)[0]
    assert said(window)[2:] == (f"{900.0 / bound:.1f} × above the limit", ("cross", "danger"))
    assert window.banners.banners == []
    studio.set_loop(controller=True)
    qtbot.waitUntil(lambda: "Without the passivity controller" in said(window)[1], timeout=PATIENCE_MS)
    assert said(window)[0] == said(window)[2]
    assert said(window)[2].endswith("× above the limit, passivity controller on")
    assert said(window)[3] == ("triangle", "warn")
    studio.set_loop(controller=False, estimator="foaw", options=())
    qtbot.waitUntil(lambda: said(window)[0] == "No exact limit", timeout=PATIENCE_MS)
    assert "not linear" in said(window)[1]
    studio.choose("free")
    window.stability.ask()
    assert said(window)[0] == "No limit applies"
    assert not window.stability.map.isVisible()


def test_with_the_controller_the_limit_is_named_as_without_it():
    controlled = Setting(controller=True)
    for bound, stiffness in ((867.0, 1127.0), (0.0, 10.0)):
        assert judge(judged(stiffness, bound, setting=controlled)).sign == ("triangle", "warn")
        assert judge(judged(stiffness, bound)).sign == ("cross", "danger")
        words = judge(judged(stiffness, bound, setting=controlled)).words
        assert words.endswith("Without the passivity controller, which is on: with it, only a run can tell.")
        assert "controller" not in judge(judged(stiffness, bound)).words
    assert "Stiffness limit" not in judge(judged(10.0, 0.0)).words


def test_the_limit_with_a_kalman_filter_is_that_of_the_devices_own_sensor(window, monkeypatch):
    """61 µm and 5 N·s/m: 3628 N/m by eigenvalues, and 5 µm 9553 N/m; the card takes the device's quantum."""
    for quantum, want in ((61e-6, 3628.0), (5e-6, 9553.0)):
        setting = Setting(quantum=quantum, estimator=("kalman", {"q": 1e-2}))
        found = answer(Question(setting, 300.0, 5.0, 8.0))
        assert abs(found.margin.limit - want) < 1.0
        assert abs(dict(found.boundary)[5.0] - want) < 1.0
    engine = window.studio.engine
    monkeypatch.setattr(engine, "device", replace(engine.device, quantum=61e-6))
    assert window.stability.facts.setting().quantum == 61e-6


def test_a_delay_that_wanders_turns_no_verdict_round_but_a_person_does():
    below, slower = judged(400.0, 410.0), replace(SETTING, rate=0.9 * SETTING.rate)
    assert differs_by_noise_only(below, judged(400.0, 395.0, setting=LATER))
    for other, why in (
        (judged(400.0, 405.0, setting=LATER), "the same verdict is shown with its numbers"),
        (judged(400.0, 380.0, setting=LATER), "7 % are no wandering"),
        (judged(412.0, 410.0), "a person asked for more"),
        (judged(400.0, 395.0, setting=slower), "another rate is another loop"),
    ):
        assert not differs_by_noise_only(below, other), why


def test_a_verdict_that_wanders_has_the_figures_of_now_and_one_that_drifts_away_turns_round(window):
    card = window.stability
    card.show_answer(judged(401.0, 410.0))
    card.show_answer(judged(401.0, 395.0, setting=LATER))
    assert "Stiffness limit 395 N/m." in card.words.text()
    assert "0.02 ms from sensor to motor" in card.words.text()
    assert said(window)[0] == said(window)[2] == "At the limit"
    for step, bound in enumerate((410.0, 398.0, 392.0, 380.0)):
        card.show_answer(judged(400.0, bound, setting=replace(SETTING, delay=SETTING.delay + step * 20e-6)))
    assert "above the limit" in card.verdict.words.text()


@pytest.mark.parametrize(("stiffness", "ring"), [(250.0, False), (6000.0, True)])
def test_the_dot_stands_at_its_values_ringed_beyond_the_limit(window, stiffness, ring):
    shown = window.stability.map
    window.stability.show_answer(answer(Question(SETTING, stiffness, 2.0, 8.0)))
    picture, place = shown.viewport().grab().toImage(), shown.pixel(2.0, stiffness)
    dot = colored(picture, "accent").mean(axis=0) + 0.5
    assert dot == pytest.approx([place.x(), place.y()], abs=1.5)
    assert (
        bool(len(colored(picture.copy(int(place.x()) - 12, int(place.y()) - 12, 24, 24), "danger"))) == ring
    )


def test_a_fault_before_the_first_delay_is_no_measuring(board_window, qtbot, monkeypatch):
    card, engine = board_window.stability, board_window.studio.engine
    fault = SimpleNamespace(text="Fault: no sensor frame for 20 ms.", detail="", code=1)
    qtbot.waitUntil(lambda: card.verdict.words.text() == "Measuring the delay", timeout=PATIENCE_MS)
    monkeypatch.setattr(type(engine), "fault", property(lambda _self: fault))
    board_window.live.look()
    qtbot.waitUntil(lambda: card.verdict.words.text() == "Not measured while stopped", timeout=PATIENCE_MS)
