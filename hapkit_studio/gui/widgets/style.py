"""The application's style sheet, and the properties its rules select by; both follow the theme."""

import re

from PySide6.QtCore import QObject, Qt
from PySide6.QtWidgets import QApplication, QWidget

from hapkit_studio import resources
from hapkit_studio.gui.widgets import icons
from hapkit_studio.gui.widgets.theme import theme


def apply(app: QApplication) -> None:
    """Give the application the theme and the style sheet, and keep both up to date."""
    if app.property("styled") is None:
        app.setProperty("styled", True)
        theme.changed.connect(lambda: app.setStyleSheet(stylesheet()))
    theme.apply(app)


def stylesheet() -> str:
    """Return assets/style.qss with the tokens (@name) and icons (%name%) of the theme in force filled in."""
    text = resources.path("style.qss").read_text(encoding="utf-8")
    text = re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL)
    text = _with_tokens(text)
    return re.sub(r"%(\w+)%", lambda match: icons.file(match[1], "ink2"), text)


def _with_tokens(sheet: str) -> str:
    return re.sub(r"@(\w+)", lambda match: theme.tokens[match[1]], sheet)


class _StyleSheet(QObject):
    """Keeps one widget's sheet in the theme's colours; lives and dies with the widget."""

    def __init__(self, widget: QWidget, sheet: str):
        super().__init__(widget)
        self.widget, self.sheet = widget, sheet
        theme.changed.connect(self.refresh)
        self.refresh()

    def refresh(self) -> None:
        sheet = _with_tokens(self.sheet)
        if sheet != self.widget.styleSheet():
            self.widget.setStyleSheet(sheet)


def set_style(widget: QWidget, sheet: str) -> None:
    """Give a widget a style sheet whose @tokens follow the theme; a second call replaces the first."""
    found = widget.findChildren(_StyleSheet, options=Qt.FindChildOption.FindDirectChildrenOnly)
    if found:
        found[0].sheet = sheet
        found[0].refresh()
    else:
        _StyleSheet(widget, sheet)


def mark(widget: QWidget, name: str, value: object) -> None:
    """Set a property that style sheets select by, and style the widget anew if it changed."""
    if widget.property(name) != value:
        widget.setProperty(name, value)
        widget.style().unpolish(widget)
        widget.style().polish(widget)
