"""Render a lesson's formulas with matplotlib's mathtext."""

import io
from collections.abc import Iterator, Sequence
from typing import Any

from hapkit_studio.lessons.lesson import Formula, Hint, Lesson, LessonError, Text

INLINE = "$"
"""Start and end of a code span that contains a formula: `$K d$`."""


def is_formula(token: Any) -> bool:
    """Return True if a token of markdown-it is an inline formula."""
    text = token.content
    return token.type == "code_inline" and len(text) > 2 and text[0] == text[-1] == INLINE


def svg(tex: str, size: float = 12.0, color: str = "currentColor") -> str:
    """Return a formula as an SVG element, aligned with the baseline and size of the surrounding text.

    size in points only determines the resolution of the outline. Raise ValueError for TeX unknown to
    mathtext.
    """
    from matplotlib.font_manager import FontProperties
    from matplotlib.path import Path
    from matplotlib.textpath import TextPath

    font = FontProperties(size=size, math_fontfamily="dejavusans")
    path = TextPath((0.0, 0.0), f"${tex}$", prop=font)
    box = path.get_extents()
    pad = 0.08 * size
    left, bottom = box.x0 - pad, box.y0 - pad
    wide, high = box.width + 2.0 * pad, box.height + 2.0 * pad
    drawn = io.StringIO()
    letters = {Path.MOVETO: "M", Path.LINETO: "L", Path.CURVE3: "Q", Path.CURVE4: "C", Path.CLOSEPOLY: "Z"}
    for points, code in path.iter_segments():
        places = " ".join(f"{value:.2f}" for value in points) if code != Path.CLOSEPOLY else ""
        drawn.write(f"{letters[code]}{places}")
    view = f"{left:.2f} {-bottom - high:.2f} {wide:.2f} {high:.2f}"
    style = f"width:{wide / size:.3f}em;height:{high / size:.3f}em;vertical-align:{bottom / size:.3f}em"
    outline = f'<path transform="scale(1,-1)" fill="{color}" d="{drawn.getvalue()}"/>'
    return f'<svg class="formula" viewBox="{view}" style="{style}" role="img">{outline}</svg>'


def check_formulas(lesson: Lesson) -> None:
    """Raise LessonError, with the line, for a formula that cannot be rendered."""
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
