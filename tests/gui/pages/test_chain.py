"""The chain's view: what is set moves with the panel at once, and a better choice is used and undone."""

import pytest

from hapkit_studio.analysis import chain
from hapkit_studio.haptics.engine import BOARD, COMPUTER


@pytest.fixture
def page(shared_window, monkeypatch, qtbot):
    """Return the page in sight with the puck's chain, the board's and the computer's, computed here."""
    window = shared_window
    shown = window.views.page("chain")
    monkeypatch.setattr(shown.job, "_needs", "")
    shown.begun.add("scene")
    monkeypatch.setattr(shown, "press", lambda: None)
    window.studio.adopt(window.studio.environments["friction"])
    window.studio.reset_values()
    window.views.show("chain")
    shown.show_result(chain.compute(shown.question()))
    yield shown
    shown._worker.wait()


def test_another_method_is_known_at_once_and_anything_else_is_asked(page, shared_window, qtbot):
    studio = shared_window.studio
    before = page.found
    studio.set_value("model", 0.0)
    assert page.found.candidates is before.candidates
    assert page.found.in_force(BOARD).method == "Coulomb"
    assert not page.chart.pale
    asked = page._worker
    with qtbot.waitSignal(asked.answered):
        studio.set_value("kinetic_force", 0.2)
    assert page.chart.pale
    assert not page.use_button.isEnabled()
    said = dict(page.now.pairs)["Set, computer"]
    assert said.startswith(chain.jnd(chain.in_force(page.question())[0].error))


def test_use_it_sets_what_is_chosen_and_undo_takes_it_back(page, shared_window):
    studio = shared_window.studio
    studio.set_value("model", 0.0)
    best = page.found.answer(COMPUTER).cheapest
    assert page.better is best
    shared_window.history.gesture += 1  # another press
    page.use_button.click()
    assert page.found.in_force(COMPUTER).options == best.options
    assert studio.loop.estimator == best.estimator
    shared_window.history.undo()
    assert studio.values["model"] == 0.0
    assert studio.loop.estimator == "kalman"


def test_both_places_are_answered_and_listed(page):
    lines = page.answer.words.text().split("\n")
    assert [line.split(":")[0] for line in lines] == ["Computer", "Board"]
    listed = {tuple(row[0].split("\n")) for row in page.table.texts()[1:]}
    assert listed == {
        (word, place) for word in page.found.question.choices[0].words for place in (COMPUTER, BOARD)
    }
