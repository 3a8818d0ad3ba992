"""*Feel this failure* applies a failure to the window; settings follow the knob; one click undoes them."""

import numpy as np
import pytest

from hapkit_studio.analysis.failures import failures
from hapkit_studio.gui.pages.break_it.feel import Feel
from hapkit_studio.haptics import rows
from tests.gui.pages.break_it_support import live, measured, settled


def state(studio):
    """Return all settings that a failure may change."""
    values = {key: studio.values_of(key) for key in studio.environments}
    return studio.environment.key, values, studio.loop, studio.grip


@pytest.fixture
def window(reset_window):
    """Return the window with the running simulated device."""
    return reset_window


@pytest.fixture
def felt(gate, window, qtbot):
    """Return the page on a running simulated Hapkit, with its first failure measured."""
    window.views.show("break_it")
    page = window.views.page("break_it")
    page.list.choose("grows")
    page.turn(0.99)
    measured(page, qtbot)
    settled(page, qtbot)
    yield page
    page.feel.take_back()


@pytest.mark.slow
def test_feel_it_applies_the_failure_and_take_back_restores_everything(felt, window, qtbot, monkeypatch):
    studio = window.studio
    studio.choose("spring")
    studio.set_values({"stiffness": 77.0, "damping": 1.5})
    studio.choose("wall")
    studio.set_value("stiffness", 321.0)
    studio.set_loop(rate=2000.0, delay=0.0005, estimator=("butterworth", {"cutoff": 40.0}))
    studio.set_loop(hand="light")
    before = state(studio)
    assert not felt.verdict.back.isVisible()
    felt.verdict.feel.setFocus()
    felt.verdict.feel.click()
    # if a number box had the focus, a digit key would change its number
    assert window.focusWidget() is felt.verdict.back
    assert studio.environment.key == "spring"
    assert studio.values["stiffness"] == pytest.approx(198.0)
    assert studio.values["damping"] == 2.0
    assert (studio.loop.rate, studio.loop.delay, studio.loop.estimator) == (500.0, 0.001, "difference")
    assert studio.engine.loop.rate == 500.0
    assert studio.grip == "medium"
    assert felt.felt == "A spring too stiff"
    assert felt.verdict.more.text() == "The scene shows this failure now. Pull the handle."
    assert not felt.verdict.feel.isVisible()
    felt.turn(1.2)
    settled(felt, qtbot)
    assert studio.values["stiffness"] == pytest.approx(240.0)
    felt.side.changed.emit("damping", 4.0)
    qtbot.waitUntil(lambda: studio.values["stiffness"] == pytest.approx(480.0))
    assert studio.values["damping"] == 4.0
    felt.verdict.back.click()
    assert window.focusWidget() is felt.verdict.feel
    assert felt.felt == ""
    assert state(studio) == before
    assert studio.engine.loop.rate == 2000.0
    assert not felt.verdict.back.isVisible()
    assert felt.verdict.feel.isVisible()
    felt.turn(1.3)
    settled(felt, qtbot)
    assert state(studio) == before
    # test every failure of the library, and one in an environment that is still being compiled
    before, feel, ready = state(studio), Feel(studio), []
    for key, failure in failures().items():
        if failure.live is not None:
            feel.put(key, failure.live(failure.knob.default, failure.case()))
            assert studio.environment.key == feel.live.environment
            feel.take_back()
            assert state(studio) == before, key
    monkeypatch.setattr(studio.readiness, "request", lambda key: key in ready)
    feel.put("grows", live(198.0, {"damping": 2.0}))
    assert studio.environment.key == before[0]
    assert studio.loop == before[2]
    ready += list(studio.environments)
    studio.choose("spring")
    assert studio.loop.rate == 500.0
    feel.take_back()
    assert state(studio) == before


@pytest.mark.slow
def test_changing_a_setting_removes_the_failure_and_a_refused_one_changes_nothing(
    felt, window, qtbot, monkeypatch
):
    studio, before = window.studio, state(window.studio)
    for change in (
        lambda: studio.set_value("stiffness", 50.0),
        lambda: studio.set_loop(delay=0.004),
        lambda: studio.reset_values(),
    ):
        felt.feel_it()
        assert felt.felt == "A spring too stiff"
        change()
        assert felt.felt == ""
        assert felt.verdict.more.text().startswith("The scene does not show this failure any more")
        by_hand = state(studio)
        felt.turn(1.2)
        settled(felt, qtbot)
        assert state(studio) == by_hand
        felt.verdict.feel.click()
        assert felt.felt == "A spring too stiff"
        felt.verdict.back.click()
        assert state(studio) == before
    felt.feel_it()
    heard = []
    felt.marked.connect(heard.append)
    studio.choose("puck")
    assert felt.felt == ""
    assert set(heard) == {""}
    assert felt.verdict.feel.isVisible()
    felt.list.choose("step")
    assert felt.verdict.back.isVisible()
    felt.verdict.back.click()
    assert state(studio) == ("puck", *before[1:])  # the newly selected scene is kept
    # test a loop that refuses its settings, and a device with a motor
    felt.list.choose("grows")
    before = state(studio)
    wrong = live(300.0, {"damping": 2.0})
    wrong.loop["rate"] = -1.0
    object.__setattr__(felt.record.here, "live", wrong)
    felt.feel_it()
    assert state(studio) == before
    assert not felt.feel.on
    assert "rate" in felt.bar.status.text().lower()
    monkeypatch.setattr(type(studio.opened), "motor", True)
    studio.engine_changed.emit()
    assert not felt.verdict.feel.isEnabled()
    assert "only with the simulated Hapkit" in felt.verdict.feel.toolTip()
    felt.feel_it()
    assert state(studio) == before


@pytest.mark.slow
@pytest.mark.parametrize(("share", "swings"), [(0.99, False), (1.9, True)])
def test_a_pulled_and_released_spring_behaves_as_the_advice_says(window, qtbot, share, swings):
    failure, studio = failures()["sampled_spring"], window.studio
    case = failure.case()
    live = failure.live(share * failure.limit(case), case)
    assert live.advice.startswith("Drag to 35 mm and let go")
    assert ("it buzzes" in live.advice) == swings
    Feel(studio).put("sampled_spring", live)
    reader, seen = studio.engine.reader(), []

    def places():
        seen.extend(reader.read()[:, rows.TRUE_POSITION])
        return seen

    studio.move_hand(0.035)
    # against the motor's 3 N, a hand with a medium grip is 15 mm behind its target
    qtbot.waitUntil(lambda: max(places(), default=0.0) > 0.0195)
    studio.move_hand(None)
    start = len(places())
    qtbot.waitUntil(lambda: len(places()) > start + 3000)
    assert (np.ptp(seen[-300:]) > 1e-3) == swings
