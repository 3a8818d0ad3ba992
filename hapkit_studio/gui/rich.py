"""An environment's words on their way to Qt, which reads whatever looks like HTML as HTML."""

import html
import re
from collections.abc import Iterable

from PySide6.QtCore import Qt
from PySide6.QtGui import Qt as Rich
from PySide6.QtWidgets import QLabel

_ALLOWED = re.compile(r"&lt;(/?(?:i|b|sub|sup))&gt;|&amp;(nbsp;)")


def rich(words: str) -> str:
    """Return words as HTML in which nothing but <i>, <b>, <sub>, <sup> and &nbsp; means anything."""
    escaped = html.escape(words, quote=False)
    return _ALLOWED.sub(lambda found: f"<{found[1]}>" if found[1] else f"&{found[2]}", escaped)


def plain(label: QLabel) -> QLabel:
    """Return a label that shows every letter as it stands."""
    label.setTextFormat(Qt.TextFormat.PlainText)
    return label


def plain_tip(words: str) -> str:
    """Return words for a tooltip, whose format cannot be chosen: escaped where Qt sees HTML in them."""
    return Rich.convertFromPlainText(words) if Rich.mightBeRichText(words) else words


def tip(sentences: Iterable[str], formula: str) -> str:
    """Return the sentences that are not empty, each with its full stop, and the formula below, as HTML."""
    words = " ".join(sentence.rstrip(".") + "." for sentence in sentences if sentence)
    return "".join(f"<p>{rich(part)}</p>" for part in (words, formula) if part)
