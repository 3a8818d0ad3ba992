"""Style for single widgets, beside the application's sheet: tokens by @name, following the theme."""

import re

from PySide6.QtCore import QObject, Qt
from PySide6.QtWidgets import QWidget

from hapkit_studio.gui.widgets.theme import theme


class _Dress(QObject):
    """Keeps one widget's sheet in the theme's colours; lives and dies with the widget."""

    def __init__(self, widget: QWidget, sheet: str):
        super().__init__(widget)
        self.widget, self.sheet = widget, sheet
        theme.changed.connect(self.refresh)
        self.refresh()

    def refresh(self) -> None:
        sheet = re.sub(r"@(\w+)", lambda match: theme.tokens[match[1]], self.sheet)
        if sheet != self.widget.styleSheet():
            self.widget.setStyleSheet(sheet)


def dress(widget: QWidget, sheet: str) -> None:
    """Give a widget a style sheet whose @tokens follow the theme; a second call replaces the first."""
    found = widget.findChildren(_Dress, options=Qt.FindChildOption.FindDirectChildrenOnly)
    if found:
        found[0].sheet = sheet
        found[0].refresh()
    else:
        _Dress(widget, sheet)


def mark(widget: QWidget, name: str, value: object) -> None:
    """Set a property that style sheets select by, and style the widget anew if it changed."""
    if widget.property(name) != value:
        widget.setProperty(name, value)
        widget.style().unpolish(widget)
        widget.style().polish(widget)
