"""The fidelity view: every cell in words, walked with keys; saved as a picture or as numbers."""

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from hapkit_studio.analysis.fidelity import Effect, Fidelity
from hapkit_studio.devices.simulated import TERMS
from hapkit_studio.environments import discover
from hapkit_studio.gui.pages.fidelity import Row
from hapkit_studio.gui.pages.measuring import write
from tests.gui.test_layout import resize


def made_up(scene: str) -> Fidelity:
    """Return a judgement in which each term is felt 0.3 JND less than the one before, the last not at all."""
    felt = [2.1 - 0.3 * k for k in range(len(TERMS) - 1)] + [0.0]
    effects = tuple(
        Effect(scene, key, jnd, "force", "press", 0.1 * jnd, "peak_force", 100.0, 50.0)
        for key, jnd in zip(TERMS, felt, strict=True)
    )
    return Fidelity(scene, effects, tuple(TERMS)[:4], effects[-1])


@pytest.fixture(scope="module")
def page(shared_window):
    """Return the page in sight with a judgement of every scene."""
    shown = shared_window.views.page("fidelity")
    shown.show_result([made_up(key) for key in discover()])
    shared_window.views.show("fidelity")
    return shown


def test_a_cell_is_told_in_words_by_keys_and_clicks(page):
    assert page.side.heading.text() == "Wall without mass"  # the scene in force
    assert page.side.words.text() == "The scene needs it."
    page.table.setFocus()
    for _ in range(20):
        QTest.keyClick(page.table, Qt.Key.Key_Right)
    QTest.keyClick(page.table, Qt.Key.Key_Up)
    assert page.side.heading.text() == "Spring without velocity filter"
    assert page.side.words.text() == "The scene does not need it."
    place = page.table.visualRect(page.table.model().index(0, 4)).center()
    QTest.mouseClick(page.table.viewport(), Qt.MouseButton.LeftButton, pos=place)
    assert page.side.heading.text() == "Free without sensor steps"
    told = dict(page.details.pairs)
    assert (told["Felt"], told["As a"], told["With the hand"]) == ("1.2 JND", "force", "press")
    assert (told["Largest change"], told["100 % is"]) == ("12 %", "largest force, at least 0.3 N")
    assert told["Computing time"] == "0.50 of that with it"


def test_every_word_fits_its_cell(page, shared_window, qapp):
    head, heads = page.table.horizontalHeader(), page.table.texts()[0]
    for size in ((960, 600), (1440, 900)):
        resize(qapp, shared_window, size)
        for column in range(len(TERMS) + 1):
            assert page.table.columnWidth(column) >= head.fontMetrics().size(0, heads[column]).width()
            for row in range(len(discover())):
                index = page.table.model().index(row, column)
                needed, room = page.table.sizeHintForIndex(index), page.table.visualRect(index)
                assert needed.height() <= room.height() + 1, (size, row, column)


def test_a_click_on_a_head_sorts_the_scenes_by_that_term(page):
    page.table.content.rows[3] = Row("texture", "Texture", None)
    page.table.sortByColumn(2, Qt.SortOrder.AscendingOrder)
    assert page.table.texts()[1][0] == "Texture"


@pytest.mark.slow
def test_picture_and_numbers_by_the_ending(page, tmp_path):
    for name, begin in (("a.png", b"\x89PNG"), ("a.json", b"{")):
        write(tmp_path / name, *page.exports())
        assert (tmp_path / name).read_bytes().startswith(begin)
    assert "wall" in (tmp_path / "a.json").read_text()
