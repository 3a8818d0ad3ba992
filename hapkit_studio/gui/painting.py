"""Words as pictures: painted once with a rim of their ground, then only copied."""

import math
from functools import lru_cache

from PySide6.QtCore import QPointF, Qt
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QPainter, QPainterPath, QPen, QPixmap

from hapkit_studio.gui.theme import theme


def words(
    painter: QPainter,
    x: float,
    y: float,
    text: str,
    font: QFont,
    tokens: tuple[str, str],
    rim: float,
    ratio: float,
) -> None:
    """Write text from x on base line y; tokens are the text's and its ground's; rim is the halo in px."""
    room = math.ceil(rim + 1.0)
    colors = tuple(theme.color(token).name() for token in tokens)
    picture, ascent = _picture(text, font.key(), colors, rim, ratio, room)
    place = QPointF(round((x - room) * ratio) / ratio, round((y - ascent - room) * ratio) / ratio)
    painter.drawPixmap(place, picture)


@lru_cache(maxsize=256)
def _picture(
    text: str, font_key: str, colors: tuple[str, ...], rim: float, ratio: float, room: int
) -> tuple[QPixmap, int]:
    font = QFont()
    font.fromString(font_key)
    metrics = QFontMetricsF(font)
    ascent = math.ceil(metrics.ascent())
    width = math.ceil(metrics.horizontalAdvance(text)) + 2 * room
    height = ascent + math.ceil(metrics.descent()) + 2 * room
    picture = QPixmap(math.ceil(width * ratio), math.ceil(height * ratio))
    picture.setDevicePixelRatio(ratio)
    picture.fill(Qt.GlobalColor.transparent)
    painter = QPainter(picture)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    path = QPainterPath()
    path.addText(room, room + ascent, font, text)
    halo = QPen(QColor(colors[1]), rim)
    halo.setJoinStyle(Qt.PenJoinStyle.RoundJoin)
    painter.strokePath(path, halo)
    painter.fillPath(path, QColor(colors[0]))
    painter.end()
    return picture, ascent
