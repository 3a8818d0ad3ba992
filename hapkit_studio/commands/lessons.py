"""The command for guided labs: list, new, check and play lessons; report on and grade what was handed in."""

import argparse
from collections.abc import Callable, Iterable
from pathlib import Path

from hapkit_studio import resources
from hapkit_studio.commands.base import Command, Result, option, progress_line, with_files
from hapkit_studio.errors import ParameterError
from hapkit_studio.files import replacing
from hapkit_studio.formatting import plain
from hapkit_studio.lessons import Lesson, library
from hapkit_studio.lessons.formulas import check_formulas
from hapkit_studio.lessons.grade import DAMAGED, EDITED, as_csv, as_html, grade, grade_file, summary
from hapkit_studio.lessons.hand_in import read, save_played
from hapkit_studio.lessons.library import lesson_named
from hapkit_studio.lessons.parse import SUFFIX
from hapkit_studio.lessons.play import play_lesson, results
from hapkit_studio.lessons.report import report

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
    _write(path, report(handed, lesson))
    rows = grade_file(handed.path, {lesson.key: lesson})
    return with_files(f"{handed.student}: {summary(rows)}", {"tasks": plain(rows)}, [str(path)])


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
    "grade": _grade,
}


def run(options: argparse.Namespace) -> Result:
    """Do one of ACTIONS; raise a StudioError."""
    return ACTIONS[options.action](options)


COMMAND = Command(
    "lessons",
    "guided labs: list, new, check, play, report, grade",
    run,
    (
        option("action", choices=ACTIONS),
        option(
            "path",
            nargs="?",
            help="a lesson's name or file; for report a session; for grade a folder of them",
        ),
        option(
            "--output", metavar="PATH", help="of play a new session, of report a page, of grade both tables"
        ),
        option("--student", default="Scripted student", metavar="NAME", help="of play with --output"),
        option("--folder", metavar="PATH", help="a folder with lessons of your own"),
    ),
    60,
)
