"""The current theme: colours by token, fonts by role, and the scale. It can follow the system's theme."""

from collections.abc import Iterator
from contextlib import contextmanager

from PySide6.QtCore import QObject, Qt, Signal
from PySide6.QtGui import QColor, QFont, QFontDatabase, QPalette
from PySide6.QtWidgets import QApplication

from hapkit_studio.formatting import MINUS, number
from hapkit_studio.palette import table

__all__ = ["MINUS", "MODES", "ROLES", "Theme", "number", "theme"]

MODES = ("system", "light", "dark", "contrast")
# size in pixels and weight for each role
ROLES = {
    "tick": (12, 400),
    "hint": (12, 400),
    "label": (12, 600),
    "body": (13, 400),
    "strong": (13, 600),
    "banner": (14, 650),
    "readout": (17, 650),
    "title": (18, 650),
    "verdict": (30, 700),
    "formula": (14, 400),
}


class Theme(QObject):
    """The current mode and its ``tokens`` as "#RRGGBB"; ``changed`` is emitted after the theme has changed.

    ``scale`` is the size factor. ``frame`` is the width of thin lines in px. ``grid`` is True if plots show a
    grid.
    """

    changed = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.mode = "system"
        self.name = "light"
        self.scale, self.frame, self.grid = 1.0, 1, True
        self.refreshing = False
        """True while Qt restyles all widgets; no widget may be deleted meanwhile."""
        self._together = self._pending = False
        self.tokens = table("light")
        self._fonts: dict[str, QFont] = {}
        self._app: QApplication | None = None

    def color(self, token: str, alpha: float = 1.0) -> QColor:
        """Return a token's colour with an opacity ``alpha`` from 0 to 1."""
        color = QColor(self.tokens[token])
        if alpha < 1.0:
            color.setAlphaF(alpha)
        return color

    def paler(self, token: str, ground: str, share: float) -> QColor:
        """Return an opaque mixture of two tokens' colours; ``share`` is the fraction of the first one."""
        over, under = self.color(token), self.color(ground)
        parts = (over.redF(), under.redF()), (over.greenF(), under.greenF()), (over.blueF(), under.blueF())
        return QColor.fromRgbF(*(share * a + (1.0 - share) * b for a, b in parts))

    def apply(self, app: QApplication) -> None:
        """Apply this theme to the application, and follow changes of the system's theme from now on."""
        if self._app is None:
            self._app = app
            app.setStyle("Fusion")
            app.styleHints().colorSchemeChanged.connect(self._follow)
            self.name = ""  # an empty name forces the first change of theme
        self.set_mode(self.mode)

    def set_mode(self, mode: str) -> None:
        """Choose one of MODES; raise ValueError for any other mode."""
        if mode not in MODES:
            raise ValueError(f"The theme must be one of {', '.join(MODES)}, not {mode!r}.")
        self.mode = mode
        self._switch(self._system() if mode == "system" else mode)

    def set_scale(self, scale: float, frame: int = 1) -> None:
        """Set the size factor, and the width of thin lines in px."""
        if (scale, frame) != (self.scale, self.frame):
            self.scale, self.frame = scale, frame
            self._refresh()

    def px(self, size: float) -> int:
        """Return a size in scaled px; it is rounded down so that texts fit."""
        return int(self.scale * size + 1e-6)

    def _system(self) -> str:
        app = self._app or QApplication.instance()
        dark = app is not None and app.styleHints().colorScheme() == Qt.ColorScheme.Dark  # type: ignore[attr-defined]
        return "dark" if dark else "light"

    def _follow(self) -> None:
        if self.mode == "system":
            self._switch(self._system())

    def _switch(self, name: str) -> None:
        if name == self.name:
            return
        self.name = name
        self.tokens = table(name)
        self._refresh()

    @contextmanager
    def together(self) -> Iterator[None]:
        """Restyle the widgets only once for all changes made in the block, because restyling takes 0.4 s."""
        self._together, self._pending = True, False
        try:
            yield
        finally:
            self._together = False
            if self._pending:
                self._refresh()

    def _refresh(self) -> None:
        self._fonts.clear()
        self._pending = True
        if self._together:
            return
        if self._app is not None:
            self._app.setPalette(self.palette())
            self._app.setFont(self.font("body"))
        self.refreshing = True
        self.changed.emit()
        self.refreshing = False

    def palette(self) -> QPalette:
        """Return the palette for elements that the style sheet does not style."""
        palette = QPalette()
        role = QPalette.ColorRole
        pairs = {
            role.Window: "side", role.WindowText: "ink", role.Base: "surface", role.AlternateBase: "side",
            role.Text: "ink", role.Button: "surface", role.ButtonText: "ink", role.Highlight: "accent",
            role.HighlightedText: "onaccent", role.ToolTipBase: "surface", role.ToolTipText: "ink",
            role.PlaceholderText: "ink3", role.Link: "accent", role.Mid: "line", role.Dark: "edge",
        }  # fmt: skip
        for key, token in pairs.items():
            palette.setColor(key, self.color(token))
        for key in (role.WindowText, role.Text, role.ButtonText):
            palette.setColor(QPalette.ColorGroup.Disabled, key, self.color("off"))
        return palette

    def font(self, role: str) -> QFont:
        """Return the font of a role in ROLES, with digits of equal width if the font has them."""
        if role not in self._fonts:
            pixels, weight = ROLES[role]
            font = QFont(_family())
            if role == "formula":
                font = QFont("DejaVu Serif")
                font.setStyleHint(QFont.StyleHint.Serif)
                font.setItalic(True)
            font.setPixelSize(self.px(pixels))
            font.setWeight(QFont.Weight(weight))
            font.setFeature(QFont.Tag("tnum"), 1)
            self._fonts[role] = font
        return QFont(self._fonts[role])


def _family() -> str:
    """Return Inter if it is installed, otherwise the system's font."""
    installed = QFontDatabase.families() if QApplication.instance() else []
    if "Inter" in installed:
        return "Inter"
    return QFontDatabase.systemFont(QFontDatabase.SystemFont.GeneralFont).family() if installed else ""


theme = Theme()
