"""A lesson's text in the window.

It is the report's HTML, with formulas as pictures in the theme's colours.
"""

import base64
import html
from collections.abc import Callable, Sequence
from typing import Any

from PySide6.QtCore import QBuffer, QByteArray, QIODevice, QRectF, Qt
from PySide6.QtGui import QFont, QFontMetricsF, QGuiApplication, QImage, QImageWriter, QPainter
from PySide6.QtSvg import QSvgRenderer
from PySide6.QtWidgets import QLabel

from hapkit_studio.formatting import printable
from hapkit_studio.gui.widgets.theme import theme
from hapkit_studio.lessons.formulas import Drawn, drawn, formula, rich_text

_DISPLAYED = 1.2  # size of a formula on its own line, relative to the text
_STYLE = (
    "p, ul, ol {{ margin: 0 0 6px 0; }} li {{ margin: 0 0 3px 0; }} ul, ol {{ -qt-list-indent: 1; }} "
    "a {{ color: {accent}; }} code {{ color: {ink}; background-color: {grid}; }} "
    "h3, h4 {{ font-size: 13px; margin: 8px 0 4px 0; }} td, th {{ padding: 2px 6px; text-align: left; }}"
)


class RichLabel(QLabel):
    """Shows text with formulas in the theme's colours and size; web links open in the browser."""

    def __init__(self, body: Callable[[], str]):
        """``body`` returns the HTML for the current theme."""
        super().__init__(textFormat=Qt.TextFormat.RichText, wordWrap=True, openExternalLinks=True)
        flags = Qt.TextInteractionFlag
        self.setTextInteractionFlags(flags.TextSelectableByMouse | flags.LinksAccessibleByMouse)
        self._body = body
        theme.changed.connect(self.draw)
        self.draw()

    def draw(self) -> None:
        """Draw text and formulas again."""
        style = _STYLE.format(**{name: theme.tokens[name] for name in ("accent", "ink", "grid")})
        self.setText(f"<style>{style}</style>{self._body()}")


def text_label(tokens: Sequence[Any]) -> RichLabel:
    """Return a label that shows a text, given as the tokens of its parsed Markdown."""
    return RichLabel(lambda: rich_text(tokens, lambda tex: _picture(tex, theme.font("body"))))


def formula_label(tex: str) -> RichLabel:
    """Return a label with a formula on a line of its own."""

    def body() -> str:
        font = theme.font("body")
        font.setPixelSize(round(_DISPLAYED * font.pixelSize()))
        return formula(tex, lambda tex: _picture(tex, font))

    made = RichLabel(body)
    made.setAccessibleName(f"Formula: {tex}")
    made.setContentsMargins(theme.px(10), theme.px(4), 0, theme.px(4))
    return made


def _picture(tex: str, font: QFont) -> str:
    """Return a formula as an image aligned with the text's base line.

    Qt puts the middle of an image at half the height of the letter x above the base line. The formula's image
    therefore extends equally far above and below this level.
    """
    shape = drawn(tex, theme.tokens["ink"])
    em, half_x = font.pixelSize(), QFontMetricsF(font).xHeight() / 2.0
    wide, below, above = (em * part for part in (shape.wide, shape.below, shape.high - shape.below))
    high = max(2.0 * below + half_x, 2.0 * above - half_x)
    data = base64.b64encode(_png(shape, wide, high, (high + half_x) / 2.0 - above, em)).decode()
    size = f'width="{round(wide)}" height="{round(high)}"'
    text = html.escape(printable(tex))
    return f'<img src="data:image/png;base64,{data}" alt="{text}" {size} style="vertical-align: middle">'


def _png(shape: Drawn, wide: float, high: float, top: float, em: float) -> bytes:
    """Return the PNG of a formula placed ``top`` px below the top of a picture of wide × high px."""
    ratio = 2.0 * max(screen.devicePixelRatio() for screen in QGuiApplication.screens())
    image = QImage(
        max(round(ratio * round(wide)), 1), max(round(ratio * round(high)), 1), QImage.Format.Format_ARGB32
    )
    image.fill(Qt.GlobalColor.transparent)
    painter = QPainter(image)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    text = shape.svg.replace("<svg ", '<svg xmlns="http://www.w3.org/2000/svg" ', 1)
    place = QRectF(0.0, ratio * top, image.width(), ratio * em * shape.high)
    QSvgRenderer(QByteArray(text.encode())).render(painter, place)
    painter.end()
    data = QByteArray()
    buffer = QBuffer(data)
    buffer.open(QIODevice.OpenModeFlag.WriteOnly)
    QImageWriter(buffer, QByteArray(b"png")).write(image)
    return bytes(data.data())
