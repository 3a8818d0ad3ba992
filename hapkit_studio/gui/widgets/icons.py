"""Icons: assets/icons/*.svg on a grid of 24 px, drawn in a token's colour at the screen's resolution."""

import tempfile
from functools import cache, lru_cache
from pathlib import Path

from PySide6.QtCore import QByteArray, QObject, QRectF, QSize, Qt
from PySide6.QtGui import QGuiApplication, QIcon, QPainter, QPixmap
from PySide6.QtSvg import QSvgRenderer
from PySide6.QtWidgets import QAbstractButton

from hapkit_studio import resources
from hapkit_studio.gui.widgets.theme import theme


@cache
def names() -> tuple[str, ...]:
    """Return every icon's name."""
    return tuple(sorted(p.stem for p in resources.path("icons").glob("*.svg")))


def svg(name: str, token: str) -> str:
    """Return an icon's SVG text in a token's colour; raise FileNotFoundError for an unknown name."""
    return _source(name).replace("currentColor", theme.color(token).name())


@cache
def _source(name: str) -> str:
    return resources.path("icons", f"{name}.svg").read_text(encoding="utf-8")


def pixmap(name: str, size: int = 24, color: str = "ink", ratio: float = 1.0) -> QPixmap:
    """Return an icon as a square pixmap; ``size`` is in device-independent pixels."""
    return QPixmap(_drawn(svg(name, color), size, ratio))


@lru_cache(maxsize=512)
def _drawn(text: str, size: int, ratio: float) -> QPixmap:
    picture = QPixmap(QSize(round(size * ratio), round(size * ratio)))
    picture.fill(Qt.GlobalColor.transparent)
    painter = QPainter(picture)
    renderer = QSvgRenderer(QByteArray(text.encode()))
    renderer.render(painter, QRectF(0, 0, picture.width(), picture.height()))
    painter.end()
    picture.setDevicePixelRatio(ratio)
    return picture


def icon(name: str, color: str = "ink", size: int = 20) -> QIcon:
    """Return an icon of ``size`` px in the theme's scale; it is sharp on every screen."""
    result, size = QIcon(), theme.px(size)
    ratios = {1.0, 2.0} | {s.devicePixelRatio() for s in QGuiApplication.screens()}
    for ratio in sorted(ratios):
        result.addPixmap(pixmap(name, size, color, ratio), QIcon.Mode.Normal)
        result.addPixmap(pixmap(name, size, "off", ratio), QIcon.Mode.Disabled)
    return result


class _Binding(QObject):
    """Redraws a widget's icon in the theme's colours; it is deleted together with the widget."""

    def __init__(self, target: QAbstractButton, name: str, color: str, size: int):
        super().__init__(target)
        self.target, self.arguments = target, (name, color, size)
        theme.changed.connect(self.refresh)
        self.refresh()

    def refresh(self) -> None:
        self.target.setIcon(icon(*self.arguments))
        self.target.setIconSize(QSize(1, 1) * theme.px(self.arguments[2]))


def bind(target: QAbstractButton, name: str, color: str = "ink", size: int = 20) -> None:
    """Give a button an icon that follows the theme."""
    _Binding(target, name, color, size)


_folder = tempfile.TemporaryDirectory(prefix="hapkit-icons-")


def file(name: str, color: str) -> str:
    """Return the path of a coloured SVG file, because style sheets cannot use pictures in memory."""
    path = Path(_folder.name) / f"{name}-{theme.color(color).name()[1:]}.svg"
    path.write_text(svg(name, color), encoding="utf-8")
    return path.as_posix()
