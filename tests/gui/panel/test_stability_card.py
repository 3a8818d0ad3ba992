"""The stability card: the limit of the loop in force, in words, on the map and in a banner."""

from dataclasses import replace

from hapkit_studio.analysis.setting import Setting
from hapkit_studio.analysis.stability.kb_plane import limit
from hapkit_studio.analysis.stability.margin import Margin
from hapkit_studio.gui.panel.limits import Answer, Question, answer
from hapkit_studio.gui.panel.stability_card import conditions, differs_by_noise_only, margin_notice, sign_of
from tests.gui.window_support import PATIENCE_MS

SETTING = Setting()


def judged(stiffness, bound, damping=0.0, setting=SETTING):
    question = Question(setting, stiffness, damping, 8.0)
    return Answer(question, Margin(stiffness, damping, bound), ())


def test_the_boundary_passes_through_the_limit_at_the_questions_damping():
    found = answer(Question(SETTING, 250.0, 4.0, 8.0))
    assert dict(found.boundary)[4.0] == found.margin.limit
    assert found.stable


def test_the_card_judges_the_loop_in_force(window, qtbot):
    window.studio.set_value("stiffness", 900.0)
    qtbot.waitUntil(lambda: "1.1 × below" in window.stability.headline.text(), timeout=PATIENCE_MS)
    assert "Stiffness limit 1,002 N/m." in window.stability.words.text()
    window.studio.set_loop(delay=0.002)

    def judged() -> bool:
        window.live.look()  # the loop takes the new delay at its next tick
        return "above the limit" in window.stability.headline.text()

    qtbot.waitUntil(judged, timeout=PATIENCE_MS)
    bound = limit(Setting(delay=0.002, estimator="iir"), 0.0)
    assert f"Lower stiffness below {bound:.0f} N/m." in window.stability.headline.text()
    assert window.status.margin.words.text() == f"{900.0 / bound:.1f} × above the limit"


def test_a_banner_gives_the_numbers_while_the_stiffness_is_above_the_limit(window, qtbot):
    window.studio.set_value("stiffness", 4000.0)
    qtbot.waitUntil(lambda: window.banners.get("limit") is not None, timeout=PATIENCE_MS)
    assert window.banners.get("limit").title == "Stiffness 4,000 N/m is above the limit of 1,002 N/m."
    window.studio.set_value("stiffness", 100.0)
    qtbot.waitUntil(lambda: window.banners.get("limit") is None, timeout=PATIENCE_MS)
    assert window.banners.banners == []


def test_no_limit_is_named_where_none_applies(window):
    window.studio.choose("free")
    window.stability.ask()
    assert window.stability.headline.text() == "No limit applies"
    assert window.banners.get("limit") is None


def test_an_estimator_that_is_not_linear_has_no_exact_limit(window, qtbot):
    window.studio.set_value("stiffness", 4000.0)
    qtbot.waitUntil(lambda: window.banners.get("limit") is not None, timeout=PATIENCE_MS)
    window.studio.set_loop(estimator="foaw", options=())
    qtbot.waitUntil(lambda: window.stability.headline.text() == "No exact limit", timeout=PATIENCE_MS)
    assert "not linear" in window.stability.words.text()
    assert window.banners.get("limit") is None
    window.studio.set_loop(estimator="kalman", options=())
    qtbot.waitUntil(lambda: "above the limit" in window.stability.headline.text(), timeout=PATIENCE_MS)


def test_the_notice_names_stiffness_limit_and_delay():
    title, text = margin_notice(judged(1127.0, 867.0))
    assert title == "Stiffness 1,127 N/m is above the limit of 867 N/m."
    assert text.startswith("At 1,000 Hz and the measured delay of 0.00 ms")
    assert "Stiffness limit" not in conditions(judged(10.0, 0.0))


def test_with_the_controller_no_growth_is_promised_and_the_limit_is_named_as_without_it():
    plain, controlled = SETTING, Setting(controller=True)
    for limit_there, stiffness in ((867.0, 1127.0), (0.0, 10.0)):
        title, text = margin_notice(judged(stiffness, limit_there, setting=controlled))
        assert "without the controller" in title
        assert "grows" not in text
        assert sign_of(judged(stiffness, limit_there, setting=controlled)) == ("triangle", "warn")
        assert sign_of(judged(stiffness, limit_there, setting=plain)) == ("cross", "danger")
        assert text.endswith("The passivity controller may hold contact all the same.")
        title, text = margin_notice(judged(stiffness, limit_there, setting=plain))
        assert "controller" not in title + text
        words = conditions(judged(stiffness, limit_there, setting=controlled))
        assert words.endswith("Without the passivity controller, which is on: with it, only a run can tell.")
        assert "controller" not in conditions(judged(stiffness, limit_there, setting=plain))


def test_the_card_follows_the_controller(window, qtbot):
    window.studio.set_value("stiffness", 4000.0)
    qtbot.waitUntil(lambda: window.banners.get("limit") is not None, timeout=PATIENCE_MS)
    window.studio.set_loop(controller=True)
    qtbot.waitUntil(lambda: "controller" in window.banners.get("limit").title, timeout=PATIENCE_MS)
    assert "Without the passivity controller" in window.stability.words.text()
    for words in (window.status.margin.words, window.stability.headline):
        assert words.text().endswith("× above the limit, passivity controller on")
    assert (window.status.margin._sign_name, window.status.margin._token) == ("triangle", "warn")
    window.studio.set_loop(controller=False)
    qtbot.waitUntil(lambda: "controller" not in window.banners.get("limit").title, timeout=PATIENCE_MS)
    assert "grows instead of settling" in window.banners.get("limit").text
    assert window.status.margin.words.text().endswith("× above the limit")
    assert (window.status.margin._sign_name, window.status.margin._token) == ("cross", "danger")


def test_the_limit_with_a_kalman_filter_is_that_of_the_devices_own_sensor(window):
    """61 µm and 5 N·s/m: 3628 N/m by eigenvalues, and 5 µm 9553 N/m; the card takes the device's quantum."""
    for quantum, want in ((61e-6, 3628.0), (5e-6, 9553.0)):
        setting = Setting(quantum=quantum, estimator=("kalman", {"q": 1e-2}))
        found = answer(Question(setting, 300.0, 5.0, 8.0))
        assert abs(found.margin.limit - want) < 1.0
        assert abs(dict(found.boundary)[5.0] - want) < 1.0
    facts = window.stability.facts
    window.studio.engine.device = replace(window.studio.engine.device, quantum=61e-6)
    assert facts.setting().quantum == 61e-6


def test_a_delay_that_wanders_turns_no_verdict_round_but_a_person_does():
    below = judged(400.0, 410.0)
    later = replace(SETTING, delay=SETTING.delay + 20e-6)
    assert differs_by_noise_only(below, judged(400.0, 395.0, setting=later))
    assert not differs_by_noise_only(below, judged(400.0, 405.0, setting=later)), (
        "the same verdict is shown with its numbers"
    )
    assert not differs_by_noise_only(below, judged(400.0, 380.0, setting=later)), "7 % are no wandering"
    assert not differs_by_noise_only(below, judged(412.0, 410.0)), "a person asked for more"
    slower = replace(SETTING, rate=0.9 * SETTING.rate)
    assert not differs_by_noise_only(below, judged(400.0, 395.0, setting=slower)), (
        "another rate is another loop"
    )


def test_a_verdict_that_wanders_has_the_figures_of_now_and_moves_no_banner(window):
    """The delay and limit are those of the panel above; the words take neither side, the banner stays."""
    card = window.stability
    later = replace(SETTING, delay=SETTING.delay + 20e-6)
    for first, banner in ((410.0, False), (395.0, True)):
        other = 805.0 - first
        card.show_answer(judged(300.0, first))
        card.show_answer(judged(401.0, first))
        card.show_answer(judged(401.0, other, setting=later))
        assert f"Stiffness limit {other:.0f} N/m." in card.words.text()
        assert "0.02 ms from sensor to motor" in card.words.text()
        assert card.headline.text() == window.status.margin.words.text() == "At the limit"
        notice = window.banners.get("limit")
        assert (notice is not None) == banner
        if notice is not None:
            assert f"at the limit of {other:.0f} N/m" in notice.title
            assert "0.02 ms" in notice.text


def test_a_limit_that_drifts_away_in_small_steps_turns_the_verdict_round(window):
    card = window.stability
    for step, bound in enumerate((410.0, 398.0, 392.0, 380.0)):
        card.show_answer(judged(400.0, bound, setting=replace(SETTING, delay=SETTING.delay + step * 20e-6)))
    assert "above the limit" in card.headline.text()
    assert window.banners.get("limit") is not None
