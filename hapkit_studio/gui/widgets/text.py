"""Text for labels, tooltips and painters as plain text, restricted HTML, or cached pictures."""

import html
import math
import re
from collections.abc import Iterable
from functools import lru_cache

from PySide6.QtCore import QPointF, Qt
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QPainter, QPainterPath, QPen, QPixmap
from PySide6.QtGui import Qt as Rich
from PySide6.QtWidgets import QLabel

from hapkit_studio.formatting import printable, unbroken
from hapkit_studio.gui.widgets.theme import theme

_ALLOWED = re.compile(r"&lt;(/?(?:i|b|sub|sup))&gt;|&amp;(nbsp;)")


def rich(text: str) -> str:
    """Return text as HTML in which only <i>, <b>, <sub>, <sup> and &nbsp; are interpreted."""
    escaped = html.escape(printable(text), quote=False)
    return _ALLOWED.sub(lambda found: f"<{found[1]}>" if found[1] else f"&{found[2]}", escaped)


def show_formula(label: QLabel, formula: str) -> None:
    """Show a formula; only its parts in <i> are in italics."""
    upright = theme.font("formula")
    upright.setItalic(False)
    label.setFont(upright)
    label.setText(rich(formula))


def plain(label: QLabel) -> QLabel:
    """Make a label show plain text, and return it."""
    label.setTextFormat(Qt.TextFormat.PlainText)
    return label


def plain_tip(text: str) -> str:
    """Return text for a tooltip.

    It is escaped if Qt would take it for HTML, because tooltips have no plain format.
    """
    text = printable(text)
    return Rich.convertFromPlainText(text) if Rich.mightBeRichText(text) else text


def tip(sentences: Iterable[str], formula: str) -> str:
    """Return the non-empty sentences, each with its full stop, and the formula below them, as HTML."""
    text = unbroken(" ".join(sentence.rstrip(".") + "." for sentence in sentences if sentence))
    return "".join(f"<p>{rich(part)}</p>" for part in (text, formula) if part)


def paint_text(
    painter: QPainter,
    x: float,
    y: float,
    text: str,
    font: QFont,
    tokens: tuple[str, str],
    rim: float,
    ratio: float,
) -> None:
    """Draw text at x on the base line y.

    ``tokens`` are the colour tokens of text and background; ``rim`` is the width of the halo in px.
    """
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
