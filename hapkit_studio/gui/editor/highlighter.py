"""Colours of a law's source: x and v wear the colours of their plots."""

import keyword
import re

from PySide6.QtGui import QFont, QSyntaxHighlighter, QTextCharFormat, QTextDocument

from hapkit_studio.gui.theme import theme

# kind: token, weight, italic
KINDS = {
    "keyword": ("asked", 600, False),
    "comment": ("ink3", 400, True),
    "string": ("energy", 400, False),
    "decorator": ("asked", 400, False),
    "defined": ("ink", 600, False),
    "position": ("position", 600, False),
    "velocity": ("velocity", 600, False),
    "owned": ("accent", 400, False),
}
_QUANTITIES = {"x": "position", "v": "velocity"}
_WORDS = re.compile(
    r"""
    (?P<comment>\#.*)
    | (?P<triple>[rRbBuUfF]{0,2}(?:\"{3}|'{3}))
    | (?P<string>[rRbBuUfF]{0,2}(?:"(?:\\.|[^"\\])*"?|'(?:\\.|[^'\\])*'?))
    | (?P<decorator>@[\w.]+)
    | (?P<defined>(?<=\bdef\s)\w+)
    | (?P<owned>(?<![\w.])[ps]\.\w+)
    | (?P<name>(?<![\w.])[A-Za-z_]\w*)
    """,
    re.VERBOSE,
)
_PLAIN, _QUOTES = -1, ('"""', "'''")


class Highlighter(QSyntaxHighlighter):
    """Colours one document, in the theme's tokens, following it."""

    def __init__(self, document: QTextDocument):
        super().__init__(document)
        self._formats: dict[str, QTextCharFormat] = {}
        theme.changed.connect(self._recolour)
        self._recolour()

    def highlightBlock(self, text: str) -> None:
        """Colour one line; the block's state says which triple quote is still open after it."""
        self.setCurrentBlockState(_PLAIN)
        at = 0
        if self.previousBlockState() in (0, 1):
            at = self._inside(text, 0, 0, self.previousBlockState())
        while match := _WORDS.search(text, at):
            at = match.end()
            if match.lastgroup == "triple":
                at = self._inside(text, match.start(), at, _QUOTES.index(match[0][-3:]))
            else:
                self._colour(match, text)

    def _inside(self, text: str, start: int, at: int, quote: int) -> int:
        """Colour a long string up to its closing quotes, or to the line's end; return where it stops."""
        end = text.find(_QUOTES[quote], at)
        if end < 0:
            self.setCurrentBlockState(quote)
        stop = len(text) if end < 0 else end + 3
        self.setFormat(start, stop - start, self._formats["string"])
        return stop

    def _colour(self, match: re.Match[str], text: str) -> None:
        kind = match.lastgroup or ""
        if kind == "name":
            word = match[0]
            named = re.match(r"\s*=(?!=)", text[match.end() :])  # an argument called x is not the position
            kind = "keyword" if keyword.iskeyword(word) else "" if named else _QUANTITIES.get(word, "")
        if kind:
            self.setFormat(match.start(), match.end() - match.start(), self._formats[kind])

    def _recolour(self) -> None:
        for kind, (token, weight, italic) in KINDS.items():
            form = self._formats[kind] = QTextCharFormat()
            form.setForeground(theme.color(token))
            form.setFontWeight(QFont.Weight(weight))
            form.setFontItalic(italic)
        self.rehighlight()
