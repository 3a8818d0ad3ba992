"""Speed and accuracy: what is set moves with the panel at once; the recommended way is used and undone."""

from dataclasses import replace

import pytest
from matplotlib.figure import Figure

from hapkit_studio.analysis import chain
from hapkit_studio.charts.chain import draw, shown
from hapkit_studio.charts.style import colors
from hapkit_studio.haptics.engine import BOARD, COMPUTER

_FOUND: dict = {}


def computed(question):
    """Return all ways of a question, computed once for all tests."""
    key = question.environment.key, tuple(question.values.items()), question.estimator
    if key not in _FOUND:
        _FOUND[key] = chain.compute(question)
    return replace(_FOUND[key], question=question)


@pytest.fixture
def page(shared_window, monkeypatch, qtbot):
    """Return the page in sight with the friction scene, on the board and on the computer, computed here."""
    window = shared_window
    shown = window.views.page("chain")
    monkeypatch.setattr(shown.job, "_needs", "")
    shown.begun.add("scene")
    monkeypatch.setattr(shown, "press", lambda: None)
    window.studio.adopt(window.studio.environments["friction"])
    window.studio.reset_values()
    window.views.show("chain")
    shown.show_result(computed(shown.question()))
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
    best = page.found.recommendation(COMPUTER).best
    assert page.better is best
    shared_window.history.gesture += 1  # another press
    page.use_button.click()
    assert page.found.in_force(COMPUTER).options == best.options
    assert studio.loop.estimator == best.estimator
    shared_window.history.undo()
    assert studio.values["model"] == 0.0
    assert studio.loop.estimator == "kalman"


def test_the_place_in_use_is_answered_with_its_reason_and_both_are_listed(page):
    first, why = page.found.sentences(COMPUTER)
    assert (page.answer.words.text(), page.reason.text()) == (first, why)
    assert first.startswith("On the computer, Projection at 1,000 Hz: ")
    listed = {tuple(row[0].split("\n")) for row in page.table.texts()[1:]}
    assert listed == {
        (word, place) for word in page.found.question.choices[0].words for place in (COMPUTER, BOARD)
    }


@pytest.mark.parametrize("height", [420, 760])
def test_words_of_the_chart_do_not_overlap(page, height):
    """Names, cells, totals and legend; the small chart only where there is room."""
    figure = Figure(figsize=(10.0, height / 72.0), dpi=72, layout="constrained")
    draw(figure, colors(), page.found)
    figure.draw_without_rendering()
    bars = figure.axes[0]
    written = [one for one in (*bars.texts, *bars.get_yticklabels(), *bars.get_legend().texts)]
    boxes = [one.get_window_extent() for one in written if one.get_text()]
    assert not [box for n, box in enumerate(boxes) if box.count_overlaps(boxes[:n])]
    assert all(figure.bbox.padded(1.0).containsx(box.x1) and box.x0 >= 0.0 for box in boxes)
    assert len(figure.axes) == 1 + (height > 620)


def test_a_long_bar_ends_at_the_scale_and_says_its_number(page):
    """A low chart still has the recommended one, the default and the one in use."""
    best = page.found.recommendation(COMPUTER).best
    far = [
        replace(one, error=65.0, parts={"method": 70.0, "delay": -5.0}) if one.method == "Coulomb" else one
        for one in page.found.candidates
    ]
    found = replace(page.found, candidates=tuple(far))
    figure = Figure(figsize=(10.0, 10.0), dpi=72, layout="constrained")
    draw(figure, colors(), found)
    bars = figure.axes[0]
    arrows = [text.get_text() for text in bars.texts if "→" in text.get_text()]
    assert arrows == ["→ 65 JND"] * 2  # in both places, and no bar that is drawn whole
    assert max(bar.get_x() + bar.get_width() for bar in bars.patches) <= 20.0
    coulomb = replace(found.question, values={**found.question.values, "model": 0.0})
    least = [one.method for one in shown(replace(found, question=coulomb), COMPUTER, 1)]
    assert least == [best.method, "Coulomb"]
