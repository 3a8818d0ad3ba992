"""The application's style sheet and the properties that its selectors use; both follow the theme."""

import importlib.util
import re
from pathlib import Path

from PySide6.QtGui import QFontDatabase, QFontInfo
from PySide6.QtWidgets import QApplication, QWidget

from hapkit_studio import resources
from hapkit_studio.gui.widgets import icons
from hapkit_studio.gui.widgets.theme import theme

_THIN = 3  # px: sizes up to this are line widths; they are multiplied by the theme's ``frame``


def apply(app: QApplication) -> None:
    """Apply theme and style sheet to the application, and update both after changes."""
    if app.property("styled") is None:
        app.setProperty("styled", True)
        if not QFontInfo(app.font()).family():
            add_fonts()
        theme.changed.connect(lambda: app.setStyleSheet(stylesheet()))
    theme.apply(app)


def add_fonts() -> None:
    """Use matplotlib's fonts if the computer has no fonts."""
    spec = importlib.util.find_spec("matplotlib")
    if spec is not None and spec.origin is not None:
        for file in sorted(Path(spec.origin).parent.glob("mpl-data/fonts/ttf/DejaVuSans*.ttf")):
            QFontDatabase.addApplicationFont(str(file))


def stylesheet() -> str:
    """Return assets/style.qss with the current theme's tokens (@name) and icons (%name%).

    Sizes in px follow the theme's scale; thin lines have the width of the theme's frame.
    """
    text = resources.path("style.qss").read_text(encoding="utf-8")
    text = re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL)
    text = re.sub(r"@(\w+)", lambda match: theme.tokens[match[1]], text)
    text = re.sub(r"\b(\d+)px", lambda match: f"{_grown(int(match[1]))}px", text)
    return re.sub(r"%(\w+)%", lambda match: icons.file(match[1], "ink2"), text)


def _grown(size: int) -> int:
    return theme.px(size) if size > _THIN else size * theme.frame


def mark(widget: QWidget, name: str, value: object) -> None:
    """Set a property that style-sheet selectors use, and restyle the widget if its value has changed."""
    if widget.property(name) != value:
        widget.setProperty(name, value)
        widget.style().unpolish(widget)
        widget.style().polish(widget)
