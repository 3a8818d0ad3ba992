"""The pages of the menu Help: the law language, the glossary, troubleshooting, and how to write a lesson."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from PySide6.QtWidgets import QWidget

from hapkit_studio import resources
from hapkit_studio.gui.widgets.glossary import WORDS
from hapkit_studio.gui.widgets.page_dialog import PageDialog
from hapkit_studio.laws import reference


@dataclass(frozen=True)
class HelpPage:
    """The title of a help page, and a function that returns the page's Markdown text, including the title."""

    title: str
    text: Callable[[], str]


def _document(name: str) -> Callable[[], str]:
    return lambda: resources.path("docs", f"{name}.md").read_text(encoding="utf-8")


def _glossary() -> str:
    return "# Glossary\n\n" + "\n\n".join(f"**{word}.** {text}" for word, text in WORDS.items())


PAGES: Mapping[str, HelpPage] = {
    "law": HelpPage("Law language", reference.page),
    "glossary": HelpPage("Glossary", _glossary),
    "troubleshooting": HelpPage("Troubleshooting", _document("troubleshooting")),
    "lessons": HelpPage("How to write lessons", _document("lessons")),
}


def page_dialog(key: str, parent: QWidget, word: str = "", section: str = "") -> PageDialog:
    """Return the dialog of a page; it opens at a section or at the first occurrence of a word."""
    page = PAGES[key]
    text = page.text().split("\n", 2)[2]  # omit the page's title, because the dialog has its own
    return PageDialog(page.title, text, parent, word, section)
