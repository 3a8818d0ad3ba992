"""Renders a lesson's formulas with matplotlib's mathtext."""

import html
import io
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from hapkit_studio.formatting import printable
from hapkit_studio.lessons.lesson import Formula, Hint, Lesson, LessonError, Text
from hapkit_studio.lessons.parse import markdown

INLINE = "$"
"""Start and end of a code span that contains a formula: `$K d$`."""


_SIZE = 12.0  # points: font size, which determines only the resolution of the outline
_LONGEST = 1_000  # maximum number of characters; mathtext takes 3 s for 6,000


def is_formula(token: Any) -> bool:
    """Return True if a token of markdown-it is an inline formula."""
    text = token.content
    return token.type == "code_inline" and len(text) > 2 and text[0] == text[-1] == INLINE


@dataclass(frozen=True)
class Drawn:
    """A formula as an SVG element, with width, height and depth below the baseline in em."""

    svg: str
    wide: float
    high: float
    below: float


def svg(tex: str) -> str:
    """Return a formula as an SVG element with the baseline and the size of the surrounding text.

    Raise ValueError for TeX that mathtext does not know.
    """
    return drawn(tex).svg


@lru_cache(maxsize=512)
def drawn(tex: str, color: str = "currentColor") -> Drawn:
    """Render a formula in a colour; raise ValueError for TeX that mathtext cannot draw."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.path import Path
    from matplotlib.textpath import TextPath

    if len(tex) > _LONGEST:
        raise ValueError(f"it has {len(tex):,} characters; the limit is {_LONGEST:,}")
    font = FontProperties(size=_SIZE, math_fontfamily="dejavusans")
    try:
        path = TextPath((0.0, 0.0), f"${tex}$", prop=font)
    except RecursionError:
        raise ValueError("its braces are nested too deeply") from None
    except AttributeError:  # matplotlib's Path cannot be made from an empty list of codes
        raise ValueError("it has nothing visible") from None
    box = path.get_extents()
    pad = 0.08 * _SIZE
    left, bottom = box.x0 - pad, box.y0 - pad
    wide, high = box.width + 2.0 * pad, box.height + 2.0 * pad
    outline = io.StringIO()
    letters = {Path.MOVETO: "M", Path.LINETO: "L", Path.CURVE3: "Q", Path.CURVE4: "C", Path.CLOSEPOLY: "Z"}
    for points, code in path.iter_segments():
        places = " ".join(f"{value:.2f}" for value in points) if code != Path.CLOSEPOLY else ""
        outline.write(f"{letters[code]}{places}")
    view = f"{left:.2f} {-bottom - high:.2f} {wide:.2f} {high:.2f}"
    wide, high, below = wide / _SIZE, high / _SIZE, -bottom / _SIZE
    style = f"width:{wide:.3f}em;height:{high:.3f}em;vertical-align:{-below:.3f}em"
    filled = f'<path transform="scale(1,-1)" fill="{color}" d="{outline.getvalue()}"/>'
    element = f'<svg class="formula" viewBox="{view}" style="{style}" role="img">{filled}</svg>'
    return Drawn(element, wide, high, below)


def rich_text(tokens: Sequence[Any], draw: Callable[[str], str] = svg) -> str:
    """Return Markdown's tokens as HTML with escaped text; ``draw`` returns the HTML of a formula's TeX."""

    def code(renderer: Any, tokens: Sequence[Any], at: int, options: Any, env: Any) -> str:
        token = tokens[at]
        if not is_formula(token):
            return f"<code>{html.escape(printable(token.content))}</code>"
        return formula(token.content[1:-1], draw)

    parser = markdown()
    parser.add_render_rule("code_inline", code)
    return parser.renderer.render(list(tokens), parser.options, {})


def formula(tex: str, draw: Callable[[str], str] = svg) -> str:
    """Return a formula's HTML; if the formula is invalid, return its source."""
    try:
        return draw(tex)
    except ValueError:
        return f"<code>{html.escape(printable(tex))}</code>"


def check_formulas(lesson: Lesson) -> None:
    """Raise LessonError with the line number if a formula cannot be rendered."""
    for tex, line in _formulas(lesson):
        try:
            svg(tex)
        except ValueError as error:
            why = next((part.strip() for part in str(error).splitlines()[::-1] if part.strip()), "unknown")
            raise LessonError(f"{lesson.path.name}, line {line}: the formula cannot be read: {why}") from None


def _formulas(lesson: Lesson) -> Iterator[tuple[str, int]]:
    for block in [*lesson.intro, *(block for step in lesson.steps for block in step.blocks)]:
        if isinstance(block, Formula):
            yield block.tex, block.line
        elif isinstance(block, Text | Hint):
            yield from _inline(block.tokens)


def _inline(tokens: Sequence[Any]) -> Iterator[tuple[str, int]]:
    for token in tokens:
        for child in token.children or ():
            if is_formula(child):
                yield child.content[1:-1], token.map[0] + 1 if token.map else 0
