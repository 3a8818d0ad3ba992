"""The menu Help: its pages, the tour that is offered once, and the pages that banners open."""

import re

import pytest
from PySide6.QtGui import QTextFormat
from PySide6.QtWidgets import QLabel, QWidget

from hapkit_studio import resources
from hapkit_studio.gui.shell import help as help_pages
from hapkit_studio.gui.shell import notices
from hapkit_studio.gui.shell.window import TOUR
from hapkit_studio.gui.widgets.glossary import WORDS
from hapkit_studio.gui.widgets.page_dialog import PageDialog
from hapkit_studio.haptics import arrays
from tests.gui.window_support import sheet_of

PAGES = {
    "help.law": "Law language",
    "help.glossary": "Glossary",
    "help.troubleshooting": "Troubleshooting",
    "help.write_lesson": "How to write lessons",
}
SECTIONS = ("No port", "No force", "Wrong direction", "Buzzing", "Drift", "Slow link or computer")


@pytest.mark.slow
@pytest.mark.parametrize(("action", "title"), PAGES.items())
def test_every_page_opens_with_its_title_and_text(reset_idle_window, action, title):
    reset_idle_window.actions_by_key.run(action)
    sheet = sheet_of(reset_idle_window, PageDialog)
    assert sheet.windowTitle() == title
    assert len(sheet.page.toPlainText()) > 1000
    assert title not in sheet.page.toPlainText().splitlines()[:2]


@pytest.mark.parametrize("key", help_pages.PAGES)
def test_no_line_of_code_is_wrapped_at_1280_by_720(qtbot, key):
    shown = QWidget()
    qtbot.addWidget(shown)
    shown.resize(1280, 720)
    dialog = help_pages.page_dialog(key, shown)
    dialog.show()
    block, wrapped = dialog.page.document().begin(), []
    while block.isValid():
        is_code = block.blockFormat().hasProperty(QTextFormat.Property.BlockCodeLanguage)
        wrapped += [block.text()] * (is_code and block.layout().lineCount() > 1)
        block = block.next()
    assert wrapped == []


def test_the_glossary_contains_every_term(reset_idle_window):
    reset_idle_window.actions_by_key.run("help.glossary")
    text = sheet_of(reset_idle_window, PageDialog).page.toPlainText()
    assert [word for word, meaning in WORDS.items() if f"{word}. {meaning}" not in text] == []


def test_troubleshooting_has_a_section_for_each_fault():
    text = resources.path("docs", "troubleshooting.md").read_text(encoding="utf-8")
    assert tuple(re.findall(r"^## (.+)$", text, re.MULTILINE)) == SECTIONS
    named = {notices._NO_PORT, notices._NO_FORCE, notices._BUZZING, notices._SLOW}
    assert named <= set(SECTIONS)


@pytest.mark.slow
def test_a_fault_banners_help_opens_its_section(reset_window):
    """A buzzing scene usually ends with the over-speed fault, so its help opens the section Buzzing."""
    window = reset_window
    control = window.studio.engine.arrays.control
    control.fault[0] = arrays.OVER_SPEED
    try:
        window.notices.show_fault()
        banner = next(b for b in window.banners.banners if b.notice.key == "fault")
        assert [button.text() for button in banner.buttons] == ["Clear fault", "Help"]
        banner.buttons[-1].click()
    finally:
        control.fault[0] = arrays.NO_FAULT
        window.notices.show_fault()
    page = sheet_of(window, PageDialog).page
    top = page.cursorForPosition(page.viewport().rect().topLeft()).block()
    lines = [top.text(), top.next().text()]
    assert "Buzzing" in lines


@pytest.mark.slow
def test_the_tour_is_offered_once_and_opens_its_lesson(start_window, home):
    window = start_window()
    banner = next(b for b in window.banners.banners if b.notice.key == "tour")
    assert [button.text() for button in banner.buttons] == ["Start the tour", "Not now"]
    banner.buttons[0].click()
    assert window.banners.get("tour") is None
    page = window.views.page("lessons")
    assert page.player.lesson.key == TOUR
    assert "First steps" in [part.text() for part in page.findChildren(QLabel)]
    page.player.leave()
    assert start_window().banners.get("tour") is None


@pytest.mark.slow
@pytest.mark.parametrize("option", [("--screenshot", "x.png"), ("--demo",)])
def test_the_tour_is_not_offered_when_an_option_shows_something_else(start_window, option):
    assert start_window(*option).banners.get("tour") is None
