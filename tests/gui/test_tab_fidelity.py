"""The fidelity view: every cell in words, walked with keys; saved as a picture or as numbers."""

import json

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from hapkit_studio.analysis.fidelity import Effect, Fidelity
from hapkit_studio.devices.terms import TERMS
from hapkit_studio.environments import discover
from hapkit_studio.gui.tabs.export import write


def made_up(scene: str) -> Fidelity:
    """Return a judgement in which each term changes a tenth more than the one before, the last nothing."""
    changes = [0.1 * (k + 1) for k in range(len(TERMS) - 1)] + [0.0]
    effects = tuple(
        Effect(scene, key, change, "peak_force", "press", 100.0, 50.0)
        for key, change in zip(TERMS, changes, strict=True)
    )
    return Fidelity(scene, effects, effects[-1])


@pytest.fixture
def page(idle_window):
    idle_window.views.show("fidelity")
    shown = idle_window.views.page("fidelity")
    shown.show_results([made_up(key) for key in discover()])
    return shown


def test_it_begins_with_the_scene_in_force(page):
    assert page.side.heading.text() == "Wall without mass"
    assert page.side.words.text() == "The scene needs it."


def test_arrow_keys_walk_and_stop_at_the_edge(page):
    page.table.setFocus()
    for _ in range(20):
        QTest.keyClick(page.table, Qt.Key.Key_Right)
    QTest.keyClick(page.table, Qt.Key.Key_Up)
    assert page.side.heading.text() == "Spring without velocity filter"
    assert page.side.words.text() == "The scene does not need it."


def test_a_click_tells_change_and_time(page):
    box = page.table.cell(0, 3)
    QTest.mouseClick(page.table, Qt.MouseButton.LeftButton, pos=box.center().toPoint())
    assert page.side.heading.text() == "Free without sensor steps"
    texts = [label.text() for pair in page.details._labels for label in pair]
    assert "40 %" in texts
    assert "0.50 of the time with" in texts


def test_picture_and_numbers_by_the_ending(page, tmp_path):
    result = made_up("wall")

    def figure(path):
        from hapkit_studio.charts.fidelity import fidelity_figure

        fidelity_figure([result], path)

    write(tmp_path / "a.png", figure, dict)
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    write(tmp_path / "a.json", figure, lambda: {"rows": 1})
    assert json.loads((tmp_path / "a.json").read_text()) == {"rows": 1}
