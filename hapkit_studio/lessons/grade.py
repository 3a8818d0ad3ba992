"""Grading: every answer of handed-in files is evaluated again from the file's own samples.

The result is a table.
"""

import csv
import html
import io
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from hapkit_studio.errors import StudioError
from hapkit_studio.formatting import printable
from hapkit_studio.lessons.evaluate import CORRECT, WRONG, Result, evaluate_interval
from hapkit_studio.lessons.hand_in import Answer, HandedIn, read
from hapkit_studio.lessons.lesson import Check, Lesson, Question
from hapkit_studio.lessons.measurements import MEASUREMENTS
from hapkit_studio.sessions.file import SUFFIX

EDITED, DAMAGED, MISSING = "edited", "damaged", "missing"
"""States that a check does not have: the file contradicts its samples, is unreadable, or has no answer."""
COLUMNS = ("student", "file", "lesson", "step", "task", "value", "state", "reason")
# maximum relative difference between values that different computers compute from the same samples
_SAME = 1e-6


@dataclass(frozen=True)
class Row:
    """The grade of one task of one student."""

    student: str
    file: str
    lesson: str
    step: str
    task: str
    value: str
    state: str
    reason: str

    def cells(self) -> tuple[str, ...]:
        """Return the cells in the order of COLUMNS, each as one printable line."""
        return tuple(printable(getattr(self, name)).replace("\n", " ") for name in COLUMNS)


def grade(
    folder: str | Path,
    lessons: Mapping[str, Lesson],
    progress: Callable[[int, int], None] = lambda done, of: None,
) -> list[Row]:
    """Return the rows of all sessions in a folder, ordered by file name."""
    paths = sorted(path for path in Path(folder).glob("*") if path.suffix.lower() == SUFFIX)
    found: list[Row] = []
    for at, path in enumerate(paths):
        progress(at, len(paths))
        found += grade_file(path, lessons)
    progress(len(paths), len(paths))
    return found


def grade_file(path: Path, lessons: Mapping[str, Lesson]) -> list[Row]:
    """Return a row for each task of a handed-in file, and for each fault of the file."""
    try:
        handed = read(path)
    except StudioError as error:
        return [Row("", path.name, "", "", "", "", DAMAGED, str(error))]
    lesson = lessons.get(handed.lesson)
    head = (handed.student, path.name, handed.lesson)
    if lesson is None:
        reason = f"There is no lesson {handed.lesson}. Name the folder that holds it with --folder."
        return [Row(*head, "", "", "", DAMAGED, reason)]
    found = [Row(*head, "", "", "", DAMAGED, text) for text in handed.damage]
    found += [Row(*head, "", "", "", EDITED, text) for text in handed.experiments.remarks]
    handed = handed.of_lesson(lesson)
    for number, _, task in lesson.tasks():
        value, state, reason = graded(task, handed)
        if handed.stamp != lesson.stamp and state not in (CORRECT, "review"):
            reason += " The lesson was changed after the hand-in."
        title = task.title if isinstance(task, Check) else task.text
        found.append(Row(*head, str(number), f"{task.key} {title}", value, state, reason))
    return found


def graded(task: Check | Question, handed: HandedIn) -> tuple[str, str, str]:
    """Return the value, the state and the reason for a task."""
    answer = handed.answers.get(task.key)
    if answer is None:
        return "", MISSING, "This task is not answered."
    if isinstance(task, Question):
        state, text = task.judge(answer.given)
        value = f"{answer.given} {task.unit}".strip()
        if not answer.given.strip():
            return "", MISSING, text
        if state != answer.result.state:
            return value, EDITED, f"The file says {answer.result.state}, but the answer is {state}: {text}"
        return value, state, text
    if not math.isfinite(answer.result.start):
        if answer.result.state in (CORRECT, WRONG):
            return "", EDITED, f"The file says {answer.result.state}, but not which interval was evaluated."
        return "", MISSING, answer.result.text
    part = handed.samples.between(answer.result.start, answer.result.stop)
    return check_again(task, answer, evaluate_interval(task, part), part.stamp() if len(part) else "")


def check_again(check: Check, answer: Answer, again: Result, stamp: str) -> tuple[str, str, str]:
    """Compare an answer with the re-evaluated interval; return value, state and reason."""
    entry, stored = MEASUREMENTS[check.measure], answer.result
    value = entry.text(again.value) if math.isfinite(again.value) else ""
    if stamp != stored.stamp and stored.state in (CORRECT, WRONG):
        reason = "The samples or settings of this interval differ from those recorded with the answer."
        return value, EDITED, f"{reason} The samples give: {again.text}"
    if stored.state != again.state or not _alike(stored.value, again.value):
        stored_text = entry.text(stored.value) if math.isfinite(stored.value) else "no value"
        reason = f"The file says {stored_text} ({stored.state}), but its samples give: {again.text}"
        return value, EDITED, reason
    return value, again.state, again.text


def _alike(one: float, two: float) -> bool:
    if math.isnan(one) or math.isnan(two):
        return math.isnan(one) and math.isnan(two)
    return math.isclose(one, two, rel_tol=_SAME, abs_tol=1e-12)


def as_csv(rows: Iterable[Row]) -> str:
    """Return the rows as CSV; cells that a spreadsheet would compute are escaped."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    writer.writerows([_as_text(cell) for cell in row.cells()] for row in rows)
    return text.getvalue()


def _as_text(cell: str) -> str:
    """Escape a cell that a spreadsheet would run as a formula; students can enter any name and answer."""
    return f"'{cell}" if cell[:1] in ("=", "+", "-", "@") else cell


def as_html(rows: Sequence[Row]) -> str:
    """Return the rows as a complete HTML page in which all text is escaped."""
    from hapkit_studio.lessons.page import page

    heads = "".join(f"<th>{name}</th>" for name in COLUMNS)
    lines = [
        f'<tr class="{html.escape(row.state)}">'
        + "".join(f"<td>{html.escape(c)}</td>" for c in row.cells())
        + "</tr>"
        for row in rows
    ]
    body = (
        f'<h1>Results</h1><p>{html.escape(summary(rows))}</p><div class="wide"><table><thead><tr>{heads}</tr>'
    )
    return page("Results", f"{body}</thead><tbody>{''.join(lines)}</tbody></table></div>", wide=True)


def summary(rows: Sequence[Row]) -> str:
    """Return a text with the numbers of files and tasks, and the files that need attention."""
    files = {row.file for row in rows}
    tasks = [row for row in rows if row.task]
    right = sum(row.state == CORRECT for row in tasks)
    text = f"{len(files)} file{'s' * (len(files) != 1)}, {right:,} of {len(tasks):,} tasks correct."
    for state in (EDITED, DAMAGED):
        names = sorted({row.file for row in rows if row.state == state})
        if names:
            text += f" {state.capitalize()}: {', '.join(map(printable, names))}."
    return text
