"""The cat's own colours, by the theme's name; everything else in its picture has the studio's."""

from functools import cache

from PySide6.QtCore import Qt
from PySide6.QtGui import QColor, QPen

from hapkit_studio.gui.theme import theme
from hapkit_studio.palette import MODES

# part: light, dark, high contrast
COAT: dict[str, tuple[str, str, str]] = {
    "fur": ("#E7A75F", "#D98F48", "#E7A75F"),
    "stripe": ("#C57F3C", "#AD6A2E", "#B56E2C"),
    "hair": ("#8C5321", "#9A5C22", "#5A2F0B"),
    "edge": ("#8C5321", "#5E3614", "#5A2F0B"),
    "cream": ("#FBEBD6", "#F2DCC0", "#FFF6EA"),
    "pink": ("#E9938C", "#E58F88", "#E9938C"),
    "iris": ("#D3DB6C", "#DDE377", "#D3DB6C"),
    "dark": ("#2B1A0C", "#2B1A0C", "#1B0D02"),
    "whisker": ("#8C5321", "#F2E6D6", "#5A2F0B"),
}


@cache
def _color(part: str, name: str, alpha: float) -> QColor:
    color = QColor(COAT[part][MODES.index(name)])
    color.setAlphaF(alpha)
    return color


def color(part: str, alpha: float = 1.0) -> QColor:
    """Return a part's colour in the theme in force."""
    return _color(part, theme.name, alpha)


def pen(part: str, width: float, alpha: float = 1.0) -> QPen:
    """Return a round pen, its width in the painter's units."""
    pen = QPen(color(part, alpha), width, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap)
    pen.setJoinStyle(Qt.PenJoinStyle.RoundJoin)
    return pen
