"""The page *Speed and accuracy*: each of its three parts has an answer, and using a method can be undone."""

import pytest
from matplotlib.figure import Figure
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from hapkit_studio.analysis import accuracy, pointing
from hapkit_studio.analysis.accuracy import Accuracy
from hapkit_studio.analysis.accuracy import scene as this_scene
from hapkit_studio.analysis.accuracy.contact import CONDITIONS
from hapkit_studio.analysis.accuracy.needs import Effect, Needs
from hapkit_studio.analysis.accuracy.scene import SceneRequest
from hapkit_studio.analysis.discrimination import Observer
from hapkit_studio.charts.accuracy import draw_scene
from hapkit_studio.charts.style import colors
from hapkit_studio.devices.simulated import TERMS
from hapkit_studio.environments import discover
from hapkit_studio.gui.live.export import write
from hapkit_studio.lessons import experiments
from tests.analysis.accuracy.test_plan import point, sheet
from tests.gui.pages.drawing_support import outside
from tests.gui.shell.test_layout import cut_off, resize


@pytest.fixture
def page(shared_window, monkeypatch):
    """Return the visible page; nothing is measured automatically."""
    shown = shared_window.views.page("accuracy")
    for part in shown.pages:
        monkeypatch.setattr(part.job, "_needs", "")
        monkeypatch.setattr(part, "press", lambda: None)
    shared_window.views.show("accuracy")
    return shown


def show(page, index):
    page.parts.button(index).click()
    return page.part


@pytest.mark.slow
def test_the_best_methods_for_computer_and_board_are_named_in_one_sentence(page, qapp, shared_window):
    part = show(page, 0)
    points = [point("verlet", 0.002, 4000.0, 1e-3, 5e6), point("verlet", 0.0005, 8000.0, 5e-4, 9e6)]
    points += [point("rk4", 2e-6, 12_000.0, 1e-3, 14e6), point("rk4", 0.0, 24_000.0, 5e-4, 28e6)]
    part.show_result(Accuracy(sheets=(sheet(points, "integrators", "damped", conditions=CONDITIONS),)))
    resize(qapp, shared_window, (1280, 720))
    text = "The cheapest method with an error within 2 % is Verlet, 1 ms step: 4.0 µs per simulated second."
    assert part.answer.label.text() == text
    assert [" ".join(row) for row in part.table.texts()[1:]] == [
        "Verlet, 1 ms step 10 %",
        "Verlet, 1 ms step 1 %",
        "Verlet, 0.5 ms step 0.1 %",
        "Rk4, 1 ms step 0.01 %",
    ]
    assert outside(part.chart) == cut_off(shared_window) == []
    part.where.button(1).click()
    assert "5.00 million processor cycles a second" in part.answer.label.text()
    part.where.button(0).click()


@pytest.mark.parametrize("index", [0, 1, 2])
def test_run_bar_and_answer_are_at_the_top_before_there_is_a_result(page, qapp, shared_window, index):
    part = show(page, index)
    if index == 0:
        part._found.clear()
        part.show_chart()
    resize(qapp, shared_window, (1280, 720))
    card = part.bar.parentWidget()
    assert part.bar.height() <= part.bar.sizeHint().height()
    assert part.answer.geometry().bottom() < card.height() / 3


@pytest.mark.slow
def test_total_errors_are_shown_before_their_parts(page, shared_window, qtbot):
    part, studio = show(page, 1), shared_window.studio
    studio.adopt(studio.environments["damping"])
    studio.reset_values()
    early = []
    part.totals.connect(early.append)
    with qtbot.waitSignal(part.job.finished):
        part.run()
    assert early[0].options[0].parts == ()
    assert sum(part.found.options[0].parts) == pytest.approx(part.found.options[0].error)
    assert part.answer.label.text() == part.found.sentence("computer")
    assert len(part.table.texts()) == 1 + 2
    assert part.use_button.isHidden()  # the damping has no choice of methods


@pytest.mark.slow
def test_another_method_is_known_at_once_and_using_it_can_be_undone(page, shared_window, qtbot):
    part, studio = show(page, 1), shared_window.studio
    studio.adopt(studio.environments["friction"])
    studio.reset_values()
    part.show_result(this_scene.compute(part.question()))
    before = part.found
    studio.set_value("model", 0.0)
    assert part.found.options is before.options
    assert part.found.in_force("board").method == "Coulomb"
    assert not part.chart.pale
    best = part.better
    shared_window.history.gesture += 1  # the next click belongs to a new gesture
    part.use_button.click()
    assert part.found.in_force("computer").options == best.options
    shared_window.history.undo()
    assert studio.values["model"] == 0.0
    with qtbot.waitSignal(part._worker.answered):
        studio.set_value("kinetic_force", 0.2)
    live = this_scene.in_force(part.question(), part.found)
    assert [text.split(" JND")[0] for _, text in part.now.pairs] == [
        this_scene.jnd(one.error).split(" JND")[0] for one in live
    ]
    assert part.chart.pale
    assert not part.use_button.isEnabled()


@pytest.mark.slow
def test_the_lower_chart_is_shown_if_it_fits_and_no_texts_overlap():
    friction = discover()["friction"]
    question = SceneRequest(friction, friction.values(), places=(this_scene.ON_BOARD,))
    found = this_scene.split(this_scene.compute(question))
    for height, charts in ((420.0, 3), (760.0, 5)):
        figure = Figure(figsize=(13.0, height / 72.0), dpi=72, layout="constrained")
        draw_scene(figure, colors(), found)
        figure.draw_without_rendering()
        panels = [axes for panel in figure.subfigs or [figure] for axes in panel.axes]
        assert len(panels) == charts
        written = [text for axes in panels for text in (*axes.texts, *axes.get_yticklabels())]
        written += panels[1].get_legend().texts
        boxes = [text.get_window_extent() for text in written if text.get_text()]
        assert not [box for n, box in enumerate(boxes) if box.count_overlaps(boxes[:n])]


@pytest.mark.slow
def test_a_chosen_row_is_used_and_the_recommended_one_is_the_default(page, shared_window):
    part, studio = show(page, 1), shared_window.studio
    studio.adopt(studio.environments["friction"])
    studio.reset_values()
    part.show_result(this_scene.compute(part.question()))
    assert "On the board, use Projection" in part.reason.text()
    assert (part.use_button.text(), part.use_button.isEnabled()) == ("Use recommended method", False)
    assert part.use_button.isVisible()
    row = next(n for n, cells in enumerate(part.table.texts()) if cells[0] == "LuGre, computer")
    part.table.setCurrentIndex(part.table.model().index(row - 1, 0))
    assert part.use_button.text() == "Use this method"
    part.use_button.click()
    assert part.found.in_force("computer").method == "LuGre"
    assert (part.use_button.text(), part.use_button.isEnabled()) == ("Use recommended method", True)
    shared_window.history.undo()
    assert dict(part.conditions.pairs)["Delay"] == this_scene.delay_text(part.found.options)


def made_up(scene: str) -> Needs:
    """Return a result in which each term's effect is 0.3 JND below the previous one; the last effect is 0."""
    felt = [2.1 - 0.3 * k for k in range(len(TERMS) - 1)] + [0.0]
    effects = tuple(
        Effect(scene, key, jnd, "force", "press", 4.0 / 3.0 * jnd)
        for key, jnd in zip(TERMS, felt, strict=True)
    )
    return Needs(scene, effects, tuple(TERMS)[:4], effects[-1], ())


def test_keys_and_clicks_select_a_cell_whose_effect_is_explained(page, qapp, shared_window, tmp_path):
    part = show(page, 2)
    assert part.table.texts()[1] == ("Free\nnot run yet", *[""] * len(TERMS))
    part.show_result(Accuracy(needs=tuple(made_up(key) for key in discover())))
    assert part.answer.label.text().endswith(
        "needs mass, damping, friction, sensor steps. Without the other properties, most people would "
        "feel no difference."
    )
    place = part.table.visualRect(part.table.model().index(0, 4)).center()
    QTest.mouseClick(part.table.viewport(), Qt.MouseButton.LeftButton, pos=place)
    assert part.side.heading.text() == "Free without sensor steps"
    details = dict(part.details.pairs)
    assert [details[key] for key in ("Most people feel", "Sense", "Hand motion")] == [
        "1.2 JND",
        "force",
        "press",
    ]
    QTest.keyClick(part.table, Qt.Key.Key_Right)  # only the most sensitive people feel an effect of 0.9 JND
    assert part.side.label.text() == "Only the most sensitive people notice if this property is missing."
    assert part.table.texts()[1][5].startswith("0.9 †")
    write(tmp_path / "a.json", *part.exports())
    assert "wall" in (tmp_path / "a.json").read_text()
    for size in ((960, 600), (1440, 900)):
        resize(qapp, shared_window, size)
        assert cut_off(shared_window) == []


def test_a_measured_threshold_replaces_the_published_one(page, qtbot, tmp_path, monkeypatch):
    """The page evaluates its results again with the Weber fraction from the session."""
    part, given = show(page, 2), []
    path = tmp_path / "mine.hapkit"
    experiments.save_comparisons(path, Observer(), seed=1)
    own = experiments.own_threshold(path)

    def of_needs(_wanted, _progress, share):
        given.append(share)
        return Accuracy()

    monkeypatch.setattr(accuracy, "of_needs", of_needs)
    part.show_result(Accuracy(needs=(made_up("wall"),)))
    part.open_own(str(path))
    qtbot.waitUntil(lambda: part.own is not None)
    assert part.result.needs == ()
    assert part.force.text().startswith(f"Force: you notice a difference of {100.0 * own.weber.value:.0f} %.")
    assert part.choose_own.text() == "Use published JND"
    part.run()
    qtbot.waitUntil(lambda: given == [own.weber.value])
    part.job.cancel()
    QTest.mouseClick(part.choose_own, Qt.MouseButton.LeftButton)
    assert part.own is None
    assert part.force.text().startswith("Force: most people notice a change of 6 %")
    part.run()
    qtbot.waitUntil(lambda: given == [own.weber.value, 0.06])
    part.job.cancel()


def test_a_session_without_comparisons_is_refused_in_one_line(page, qtbot, tmp_path):
    part = show(page, 2)
    path = tmp_path / "mine.hapkit"
    targets = pointing.plan(distances=(0.02,), widths=(0.004,), rounds=1, seed=0)
    experiments.save_pointing(path, pointing.Subject(), targets, seed=0)
    part.open_own(str(path))
    qtbot.waitUntil(lambda: "no just-noticeable difference" in part.bar.status.text())
    assert part.own is None
