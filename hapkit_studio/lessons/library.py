"""The available lessons: those that the studio contains, and those in an instructor's folder."""

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from hapkit_studio import discovery, lab, resources
from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import ParameterError
from hapkit_studio.lessons.lesson import Lesson, LessonError
from hapkit_studio.lessons.parse import SUFFIX, read

MOST_FILES = 500  # maximum number of files in a folder


@dataclass(frozen=True)
class Library:
    """Lessons by key, in order, and for each rejected file a line with the reason."""

    lessons: Mapping[str, Lesson]
    errors: tuple[str, ...] = ()

    def named(self, key: str) -> Lesson:
        """Return the lesson with a key; raise ParameterError for an unknown key."""
        return discovery.named(self.lessons, key, "lesson")


def library(folder: str | Path | None = None, known: Mapping[str, Environment] | None = None) -> Library:
    """Return the studio's lessons and those of a folder.

    A lesson of the folder replaces a studio lesson of the same name. If ``folder`` is None, the folder that
    the lab's settings name is used. If that folder is missing (for example on a share that is not mounted),
    the library's ``errors`` contain a message. ``known`` contains the environments by key; None means the
    environments of the library. Raise ParameterError if ``folder`` is missing.
    """
    found, errors = list[Lesson](), list[str]()
    if folder is None:
        folder = lab.settings().lessons
        if lab.settings().mistake:
            errors.append(lab.settings().mistake)
        if folder is not None and not os.path.isdir(folder):
            errors.append(f"{lab.FILE}: there is no folder {folder} with lessons.")
            folder = None
    paths = {path.stem: path for path in sorted(resources.path("lessons").glob(f"*{SUFFIX}"))}
    if folder is not None:
        if not os.path.isdir(folder):
            raise ParameterError(
                f"There is no folder {folder}. Choose the folder that contains your lessons."
            )
        own = sorted(Path(folder).glob(f"*{SUFFIX}"))[:MOST_FILES]
        paths |= {path.stem: path for path in own}
    for path in paths.values():
        try:
            found.append(read(path, known))
        except LessonError as error:
            errors.append(str(error))
    found.sort(key=lambda lesson: (lesson.order, lesson.key))
    return Library({lesson.key: lesson for lesson in found}, tuple(errors))


def lesson_named(name: str, folder: str | Path | None = None) -> Lesson:
    """Return a lesson by its key or its file.

    Raise ParameterError for an unknown key, and LessonError with the line number for an invalid file.
    """
    path = Path(name).expanduser()
    if path.suffix == SUFFIX:
        return read(path)
    return library(folder).named(name)
