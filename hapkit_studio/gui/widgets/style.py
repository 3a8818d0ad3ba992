"""The application's style sheet, and the properties its rules select by; both follow the theme."""

import re

from PySide6.QtWidgets import QApplication, QWidget

from hapkit_studio import resources
from hapkit_studio.gui.widgets import icons
from hapkit_studio.gui.widgets.theme import theme

_THIN = 3  # px


def apply(app: QApplication) -> None:
    """Give the application the theme and the style sheet, and keep both up to date."""
    if app.property("styled") is None:
        app.setProperty("styled", True)
        theme.changed.connect(lambda: app.setStyleSheet(stylesheet()))
    theme.apply(app)


def stylesheet() -> str:
    """Return assets/style.qss with the tokens (@name) and icons (%name%) of the theme in force filled in.

    Sizes in px grow with the theme's scale, thin lines with its frame.
    """
    text = resources.path("style.qss").read_text(encoding="utf-8")
    text = re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL)
    text = re.sub(r"@(\w+)", lambda match: theme.tokens[match[1]], text)
    text = re.sub(r"\b(\d+)px", lambda match: f"{_grown(int(match[1]))}px", text)
    return re.sub(r"%(\w+)%", lambda match: icons.file(match[1], "ink2"), text)


def _grown(size: int) -> int:
    return theme.px(size) if size > _THIN else size * theme.frame


def mark(widget: QWidget, name: str, value: object) -> None:
    """Set a property that style sheets select by, and style the widget anew if it changed."""
    if widget.property(name) != value:
        widget.setProperty(name, value)
        widget.style().unpolish(widget)
        widget.style().polish(widget)
