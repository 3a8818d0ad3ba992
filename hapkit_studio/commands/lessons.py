"""The command for guided labs: list, new, check, play."""

import argparse
from collections.abc import Callable, Iterable
from pathlib import Path

from hapkit_studio import resources
from hapkit_studio.commands.base import Command, Result, option, with_files
from hapkit_studio.errors import ParameterError
from hapkit_studio.formatting import plain
from hapkit_studio.lessons import Lesson, library
from hapkit_studio.lessons.formulas import check_formulas
from hapkit_studio.lessons.library import lesson_named
from hapkit_studio.lessons.parse import SUFFIX
from hapkit_studio.lessons.play import play_lesson, results

FAILED = 1
"""Exit code where a check of a played lesson does not pass."""
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
    found = [(task, result) for task, result in results(lesson, play_lesson(lesson))]
    lines = [f"{lesson.title}: {lesson.summary}"]
    lines += [f"{task.key:>5} {result.state:<8} {result.text}" for task, result in found]
    failed = [task.key for task, result in found if result.state in ("wrong", "waiting")]
    lines.append(f"Not passed: {', '.join(failed)}." if failed else "Every check and question passes.")
    as_json = {"lesson": lesson.key, "results": [{"key": t.key, **plain(r)} for t, r in found]}
    return Result("\n".join(lines), as_json, FAILED if failed else 0)


def _target(options: argparse.Namespace, what: str) -> str:
    if options.path is None:
        raise ParameterError(f"lessons {options.action} takes {what}.")
    return options.path


ACTIONS: dict[str, Callable[[argparse.Namespace], Result]] = {
    "list": _list,
    "new": _new,
    "check": _check,
    "play": _play,
}


def run(options: argparse.Namespace) -> Result:
    """List the lessons, begin a new one, look for mistakes in one, or play it headless."""
    return ACTIONS[options.action](options)


COMMAND = Command(
    "lessons",
    "guided labs: list, new, check, play",
    run,
    (
        option("action", choices=ACTIONS),
        option("path", nargs="?", help="a lesson's name or file"),
        option("--folder", metavar="PATH", help="a folder with lessons of your own"),
    ),
    60,
)
