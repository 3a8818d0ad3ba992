"""The report on a handed-in lesson: figures, answers, settings and missing measurements on one page."""

import html
import math
import re
import tempfile
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

from hapkit_studio.charts.experiments import (
    pointing_columns,
    pointing_figure,
    threshold_figure,
    threshold_text,
)
from hapkit_studio.charts.run import run_figure
from hapkit_studio.formatting import printable, with_unit
from hapkit_studio.lessons.formulas import formula, rich_text
from hapkit_studio.lessons.grade import MISSING, graded
from hapkit_studio.lessons.hand_in import HandedIn
from hapkit_studio.lessons.lesson import Check, Formula, Lesson, Plot, Question, Step, Text
from hapkit_studio.lessons.page import page
from hapkit_studio.lessons.review import Review, Reviews, Row, hidden_names
from hapkit_studio.lessons.samples import Samples
from hapkit_studio.sessions.event_values import one_line

# maximum number of samples in a figure; more samples would enlarge the page without a visible difference
_FIGURE_SAMPLES = 2000
_SIZE = re.compile(r'\b(?:width|height)="[\d.]+pt"')
_WORDS = {"review": "for the reviewer", MISSING: "not measured", "waiting": "not passed"}


_NO_REVIEWS = Reviews({})


def report(handed: HandedIn, lesson: Lesson, reviews: Reviews = _NO_REVIEWS, hide_names: bool = False) -> str:
    """Return the page; all text from the file, the lesson and the reviews is escaped.

    If ``hide_names`` is True, the page does not contain the names of student, file and reviewers.
    """
    hidden = hide_names or lesson.hide_names
    handed = handed.of_lesson(lesson)
    body = [f"<h1>{_text(lesson.title)}</h1>", f'<p class="soft">{_text(lesson.aim)}</p>']
    body.append(_facts(handed, hidden))
    body += [
        f'<p class="task damaged"><span class="state">damaged</span> {_text(w)}</p>'
        for w in _damage(handed, hidden)
    ]
    missing: list[str] = []
    for number, step in enumerate(lesson.steps, 1):
        body.append(f"<h2>{number}. {_text(step.title)}</h2>")
        body += _step(step, handed, missing)
    body += _experiments(handed)
    if missing:
        rows = "".join(f"<li>{_text(text)}</li>" for text in missing)
        body.append(f"<h2>Not measured</h2><ul>{rows}</ul>")
    if reviews.found or reviews.errors:
        body += _reviews(hidden_names(reviews) if hidden else reviews, lesson)
    elif lesson.rubric:
        cells = "".join(f"<tr><td>{_text(c.text)}</td><td>{c.points}</td></tr>" for c in lesson.rubric)
        heads = "<thead><tr><th>Criterion</th><th>Points</th></tr></thead>"
        body.append(f"<h2>Rubric</h2><table>{heads}<tbody>{cells}</tbody></table>")
    forces = (
        "The forces are those sent to the motor; the force at the handle is not measured. The checks were "
        "evaluated again, from the samples in the file, when this page was written."
    )
    body.append(f'<p class="soft">{forces}</p>')
    return page(lesson.title if hidden else f"{lesson.title}: {handed.student}", "\n".join(body))


def _facts(handed: HandedIn, hidden: bool) -> str:
    named = {} if hidden else {"Student": handed.student, "File": handed.path.name}
    facts: dict[str, Any] = {**named, "Recorded": handed.samples.date}
    facts |= {name.capitalize(): value for name, value in handed.about.items() if name != "quantum_m"}
    if isinstance(step := handed.about.get("quantum_m"), int | float):
        facts["Sensor step"] = with_unit(1e6 * step, "µm")
    rows = "".join(f"<dt>{_text(name)}</dt><dd>{_text(value)}</dd>" for name, value in facts.items())
    return f"<dl>{rows}</dl>"


def _damage(handed: HandedIn, hidden: bool) -> list[str]:
    """Return the file's damage, without the file's name if it is hidden."""
    if not hidden:
        return list(handed.damage)
    return [words.replace(one_line(handed.path.name), "The file") for words in handed.damage]


def _experiments(handed: HandedIn) -> Iterator[str]:
    """Yield the results of the experiments in the file."""
    found = handed.experiments
    if found.trials:
        columns, lines = pointing_columns(), found.lines
        heads = "".join(f"<th>{_text(column.head)}</th>" for column in columns)
        rows = "".join(
            f"<tr>{''.join(f'<td>{_text(column.text(line))}</td>' for column in columns)}</tr>"
            for line in lines
        )
        yield "<h2>Pointing with friction</h2>"
        yield f'<div class="wide"><table><thead><tr>{heads}</tr></thead><tbody>{rows}</tbody></table></div>'
        yield _drawn(lambda path: pointing_figure(lines, path), "")
    for text in found.remarks:
        yield f'<p class="task edited"><span class="state">edited</span> {_text(text)}</p>'
    if found.comparisons:
        yield "<h2>Just-noticeable difference</h2>"
    for one in found.thresholds:
        yield _drawn(partial(threshold_figure, one), threshold_text(one))


def _reviews(reviews: Reviews, lesson: Lesson) -> Iterator[str]:
    """Yield all reviews in one table, then their comments and replies, and the unreadable files."""
    found = list(reviews.found.values())
    yield "<h2>Reviews</h2>"
    if math.isfinite(reviews.mean):
        yield f"<p>Mean of the complete reviews: {100.0 * reviews.mean:.0f} % of the points.</p>"
    if found:
        criteria = list(dict.fromkeys((row.criterion, row.most) for one in found for row in one.rows))
        heads = "".join(f"<th>{_text(one.reviewer)}</th>" for one in found)
        yield f'<div class="wide"><table><thead><tr><th>Criterion</th>{heads}</tr></thead><tbody>'
        for text, most in criteria:
            cells = "".join(f"<td>{_given(one, text, most)}</td>" for one in found)
            yield f"<tr><td>{_text(text)} ({most})</td>{cells}</tr>"
        sums = "".join(f"<td>{one.points} of {one.most}</td>" for one in found)
        yield f"<tr><th>Sum</th>{sums}</tr></tbody></table></div>"
    for one in found:
        titles = dict(enumerate((step.title for step in lesson.steps), 1))
        for comment in one.comments:
            step = f", {titles[comment.step]}" if comment.time is None and comment.step in titles else ""
            place = f", {comment.place}{step}" if comment.place else ""
            yield f'<p><span class="soft">{_text(one.reviewer + place)}:</span> {_text(comment.text)}</p>'
        for line in one.replies:
            to = f"Reply to {one.reviewer}:"
            yield f'<p class="task"><span class="soft">{_text(to)}</span> {_text(line)}</p>'
    for line in reviews.errors:
        yield f'<p class="task damaged"><span class="state">damaged</span> {_text(line)}</p>'


def _given(review: Review, criterion: str, most: int) -> str:
    rows = (row for row in review.rows if (row.criterion, row.most) == (criterion, most))
    row = next(rows, Row(criterion, most))
    points = "–" if row.points is None else str(row.points)
    return f"{points}<br>{_text(row.comment)}" if row.comment else points


def _step(step: Step, handed: HandedIn, missing: list[str]) -> Iterator[str]:
    """Yield a step's text, tasks and figures; append its missing measurements to ``missing``."""
    last: Samples | None = None
    drawn = any(isinstance(block, Plot) for block in step.blocks)
    for block in step.blocks:
        if isinstance(block, Text):
            yield rich_text(block.tokens)
        elif isinstance(block, Formula):
            yield f'<div class="math">{formula(block.tex)}</div>'
        elif isinstance(block, Check | Question):
            value, state, reason = graded(block, handed)
            title = block.title if isinstance(block, Check) else block.text
            if state == MISSING:
                missing.append(f"{block.key} {title}")
            yield _task(state, title, "" if isinstance(block, Check) else value, reason)
            answer = handed.answers.get(block.key)
            if isinstance(block, Check) and answer is not None and math.isfinite(answer.result.start):
                last = handed.samples.between(answer.result.start, answer.result.stop)
                if not drawn and len(last) > 1:
                    yield _figure(last, "", "")
                    drawn = True
    for block in step.blocks:
        if isinstance(block, Plot) and last is not None and len(last) > 1:
            yield _figure(last, block.over, block.caption)


def _task(state: str, title: str, given: str, reason: str) -> str:
    answer = f"<pre>{_text(given)}</pre>" if given else ""
    word = _WORDS.get(state, state)
    return (
        f'<div class="task {html.escape(state)}"><p>{_text(title)}</p>{answer}'
        f'<p><span class="state">{_text(word)}</span> {_text(reason)}</p></div>'
    )


def _figure(part: Samples, over: str, caption: str) -> str:
    """Return the interval's figure as inline SVG; its caption contains the settings."""
    thinned = part.cut(slice(None, None, max(len(part) // _FIGURE_SAMPLES, 1)))
    text = f"{caption} Evaluated from {part.time[0]:.2f} to {part.time[-1]:.2f} s.".strip()
    over = "" if over == "time" else over
    return _drawn(lambda path: run_figure(thinned, path, known=part.known, over=over), text)


def _drawn(draw: Callable[[Path], object], text: str) -> str:
    """Return a figure, which ``draw`` writes to a file, as inline SVG with a text below it."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "figure.svg"
        draw(path)
        drawn = path.read_text(encoding="utf-8")
    below = f"<figcaption>{_text(text)}</figcaption>" if text else ""
    return f"<figure>{inline_svg(drawn)}{below}</figure>"


def inline_svg(text: str) -> str:
    """Return the SVG element of a matplotlib file, without header and metadata, at the width of the page."""
    text = text[text.index("<svg") :]
    if "<metadata>" in text:
        text = text[: text.index("<metadata>")] + text[text.index("</metadata>") + len("</metadata>") :]
    return _SIZE.sub("", text, count=2).replace("<svg", '<svg role="img"', 1)


def _text(value: object) -> str:
    return html.escape(printable(str(value)))
