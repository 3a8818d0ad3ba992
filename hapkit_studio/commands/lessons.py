"""The command for guided labs: it lists, creates, checks and plays lessons, and grades and reviews them."""

import argparse
import re
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path

from hapkit_studio import resources
from hapkit_studio.commands.base import Command, Result, option, progress_line, with_files
from hapkit_studio.errors import ParameterError
from hapkit_studio.files import replacing
from hapkit_studio.formatting import plain, quoted
from hapkit_studio.lessons import Lesson, library, review
from hapkit_studio.lessons.formulas import check_formulas
from hapkit_studio.lessons.grade import DAMAGED, EDITED, as_csv, as_html, grade, grade_file, summary
from hapkit_studio.lessons.hand_in import HandedIn, read, save_played
from hapkit_studio.lessons.library import lesson_named
from hapkit_studio.lessons.parse import SUFFIX
from hapkit_studio.lessons.play import play_lesson, results
from hapkit_studio.lessons.report import report
from hapkit_studio.lessons.review import Comment

FAILED = 2
"""Exit code if a check of a played lesson fails, or a graded file is modified or damaged."""
TEMPLATE = "lesson.md"


def _list(options: argparse.Namespace) -> Result:
    found = library(options.folder)
    lines = [f"{key:<22} {lesson.title}: {lesson.summary}" for key, lesson in found.lessons.items()]
    return Result(
        "\n".join([*lines, *found.errors]),
        {"lessons": _facts(found.lessons.values()), "errors": found.errors},
    )


def _facts(lessons: Iterable[Lesson]) -> list[dict]:
    return [
        {"key": lesson.key, "title": lesson.title, "aim": lesson.aim, "minutes": lesson.minutes}
        | {"environments": lesson.environments, "steps": len(lesson.steps), "path": str(lesson.path)}
        for lesson in lessons
    ]


def _new(options: argparse.Namespace) -> Result:
    path = Path(_target(options, "the name of a new file, as my_lesson.md"))
    path = path if path.suffix == SUFFIX else path.with_name(f"{path.name}{SUFFIX}")
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(resources.path("templates", TEMPLATE).read_text(encoding="utf-8"))
    except FileExistsError:
        raise ParameterError(f"{path} exists already: choose another name.") from None
    text = f"A lesson to change: hapkit-studio lessons check {path}"
    return with_files(text, {}, [str(path)])


def _check(options: argparse.Namespace) -> Result:
    lesson = lesson_named(_target(options, "a lesson's name or its file"), options.folder)
    check_formulas(lesson)
    return Result(f"{lesson.path.name}: {lesson.summary}. No mistake found.", {"lessons": _facts([lesson])})


def _play(options: argparse.Namespace) -> Result:
    lesson = lesson_named(_target(options, "a lesson's name or its file"), options.folder)
    played = play_lesson(lesson)
    if options.output:
        found = save_played(options.output, lesson, played, options.student)
    else:
        found = results(played)
    lines = [f"{lesson.title}: {lesson.summary}"]
    lines += [f"{task.key:>5} {result.state:<8} {result.text}" for task, result in found]
    failed = [task.key for task, result in found if result.state in ("wrong", "waiting")]
    lines.append(f"Not passed: {', '.join(failed)}." if failed else "Every check and question passes.")
    as_json = {"lesson": lesson.key, "results": [{"key": t.key, **plain(r)} for t, r in found]}
    code = FAILED if failed else 0
    return with_files("\n".join(lines), as_json, [options.output] if options.output else [], code)


def _report(options: argparse.Namespace) -> Result:
    handed = read(_target(options, "a handed-in session"))
    lesson = library(options.folder).named(handed.lesson)
    path = Path(options.output or handed.path.with_suffix(".html"))
    _write(path, report(handed, lesson, review.reviews_of(handed), options.hide_names))
    rows = grade_file(handed.path, {lesson.key: lesson})
    hidden = options.hide_names or lesson.hide_names
    who = "" if hidden else f"{handed.student}: "
    return with_files(f"{who}{summary(rows)}", {"tasks": plain(rows)}, [str(path)])


def _review(options: argparse.Namespace) -> Result:
    """Show the reviews in a session or a review file; with --reviewer write a review."""
    path = Path(_target(options, "a handed-in session, or a review"))
    if path.suffix == review.SUFFIX:
        one = review.read(path)
        if options.hide_names:
            (one,) = review.hidden_names(review.Reviews({path: one})).found.values()
        return Result("\n".join(review.lines(one)), plain(one))
    handed = read(path)
    lesson = library(options.folder).named(handed.lesson)
    if options.reviewer is not None:
        return _write_review(options, handed, lesson)
    found = review.reviews_of(handed)
    if options.hide_names or lesson.hide_names:
        found = review.hidden_names(found)
    lines = [line for one in found.found.values() for line in review.lines(one)]
    text = "\n".join([*(lines or ["There is no review next to this file."]), *found.errors])
    return Result(text, {"reviews": plain(list(found.found.values())), "errors": list(found.errors)})


def _write_review(options: argparse.Namespace, handed: HandedIn, lesson: Lesson) -> Result:
    blank = review.blank(handed, lesson, options.reviewer)
    points = [word.strip() for word in (options.points or "").split(",")]
    if len(points) != len(blank.rows):
        raise ParameterError(f"--points takes {len(blank.rows)} numbers, as 3,4,-; {len(points)} are given.")
    rows = []
    for row, given in zip(blank.rows, points, strict=True):
        if given != "-" and given not in map(str, range(row.most + 1)):
            raise ParameterError(f"{row.criterion}: points are 0 to {row.most} or -, not {quoted(given)}.")
        rows.append(replace(row, points=None if given == "-" else int(given)))
    comments = tuple(_checked(_comment(text), lesson) for text in options.comment)
    whole = replace(blank, rows=tuple(rows), comments=comments)
    path = Path(options.output or review.path_of(handed.path, whole.reviewer))
    review.write(path, whole)
    return with_files("\n".join(review.lines(whole)), plain(whole), [str(path)])


def _checked(comment: Comment, lesson: Lesson) -> Comment:
    """Return a comment; raise ParameterError if it is empty, or if the lesson does not have its step."""
    steps = len(lesson.steps)
    if not comment.text:
        raise ParameterError("A comment has no text. Write --comment TEXT or --comment 'step 2: TEXT'.")
    if comment.step is not None and not 1 <= comment.step <= steps:
        raise ParameterError(f"There is no step {comment.step}: the lesson has {steps} steps.")
    return comment


_PLACE = re.compile(r"(?:(?P<time>\d+(?:\.\d+)?) s|step (?P<step>\d+)): *(?P<text>.*)")


def _comment(text: str) -> Comment:
    """Return the comment in a text; a text may begin with its time or step: "12.5 s:" or "step 2:"."""
    found = _PLACE.fullmatch(text.strip())
    if found is None:
        return Comment(text.strip())
    time, step = found["time"], found["step"]
    return Comment(found["text"], float(time) if time else None, int(step) if step else None)


def _reply(options: argparse.Namespace) -> Result:
    path = Path(_target(options, "a review's file, and the reply with --comment"))
    if len(options.comment) != 1:
        raise ParameterError("lessons reply takes the reply with --comment.")
    return with_files("\n".join(review.lines(review.reply(path, options.comment[0]))), {}, [str(path)])


def _grade(options: argparse.Namespace) -> Result:
    folder = Path(_target(options, "a folder of handed-in sessions"))
    if not folder.is_dir():
        raise ParameterError(f"lessons grade takes a folder, not {folder}.")
    rows = grade(folder, library(options.folder).lessons, progress_line("grading"))
    stem = Path(options.output or folder / "grades")
    written = [stem.with_suffix(".csv"), stem.with_suffix(".html")]
    for path, text in zip(written, (as_csv(rows), as_html(rows)), strict=True):
        _write(path, text)
    failed = any(row.state in (EDITED, DAMAGED) for row in rows)
    return with_files(summary(rows), {"rows": plain(rows)}, list(map(str, written)), FAILED if failed else 0)


def _write(path: Path, text: str) -> None:
    with replacing(path) as part:
        part.write_text(text, encoding="utf-8")


def _target(options: argparse.Namespace, what: str) -> str:
    if options.path is None:
        raise ParameterError(f"lessons {options.action} takes {what}.")
    return options.path


ACTIONS: dict[str, Callable[[argparse.Namespace], Result]] = {
    "list": _list,
    "new": _new,
    "check": _check,
    "play": _play,
    "report": _report,
    "review": _review,
    "reply": _reply,
    "grade": _grade,
}


def run(options: argparse.Namespace) -> Result:
    """Run one of ACTIONS; raise StudioError if it fails."""
    return ACTIONS[options.action](options)


COMMAND = Command(
    "lessons",
    "guided labs: list, new, check, play, report, review, reply, grade",
    run,
    (
        option("action", choices=ACTIONS),
        option(
            "path",
            nargs="?",
            help="a lesson's name or file; for report and review a session; for grade a folder of them",
        ),
        option(
            "--output",
            metavar="PATH",
            help="for play a new session, for report a page, for grade both tables",
        ),
        option("--student", default="Scripted student", metavar="NAME", help="for play with --output"),
        option("--folder", metavar="PATH", help="a folder with lessons of your own"),
        option("--reviewer", metavar="NAME", help="for review: write your own review, with --points"),
        option("--points", metavar="3,4,-", help="for review: the points of each row, - for no points"),
        option(
            "--comment",
            action="append",
            default=[],
            metavar="TEXT",
            help="for review or reply; about a time as '12.5 s: …', about a step as 'step 2: …'",
        ),
        option("--hide-names", action="store_true", help="for report and review: without names"),
    ),
    60,
)
