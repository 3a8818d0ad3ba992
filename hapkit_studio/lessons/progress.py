"""A student's progress in a lesson: answers, results, and the samples on which the checks were evaluated."""

import math
import os
from collections.abc import Iterable, Mapping, Sequence
from contextlib import ExitStack, closing, suppress
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import platformdirs

from hapkit_studio.environments.base import Environment
from hapkit_studio.haptics import rows
from hapkit_studio.haptics.signals import COLUMN
from hapkit_studio.lessons import experiments, hand_in
from hapkit_studio.lessons.evaluate import CORRECT, WAITING, Result, evaluate, evaluate_interval
from hapkit_studio.lessons.hand_in import LESSON, Part
from hapkit_studio.lessons.lesson import Check, Lesson, Question
from hapkit_studio.lessons.recent import Rows
from hapkit_studio.lessons.samples import Samples
from hapkit_studio.sessions.file import ABOUT, SETTINGS, SUFFIX, SessionError
from hapkit_studio.sessions.session import Session
from hapkit_studio.workshop.folder import VARIABLE

NOT_STARTED = Result(WAITING, "Nothing is recorded yet.")
_MARGIN = 1e-6  # s: resolution of times in a file
_SAMPLE_SECONDS = 1.0  # s: duration of the stored samples if no interval was evaluated


@dataclass(frozen=True)
class Evaluated:
    """A check's result.

    ``part`` contains the interval's rows with device and settings; None without an interval.

    ``start`` and ``stop`` are the limits of the interval in s of the rows' clock; NaN without an interval.
    """

    result: Result
    part: Part | None = None
    start: float = math.nan
    stop: float = math.nan


def evaluate_rows(
    checks: Iterable[tuple[int, Check]], found: Rows, known: Mapping[str, Environment]
) -> dict[str, Evaluated]:
    """Evaluate checks on the newest rows; each check is given with its step's number, counted from 1.

    ``known`` are the environments by key.
    """
    table = found.table
    if len(table) < 2:
        return {check.key: Evaluated(NOT_STARTED) for _, check in checks}
    begin = float(table[0, rows.HOST_TIME])
    log = [(max(when - begin, 0.0), {**about, **settings}) for when, about, settings in found.log]
    samples = Samples.of_rows(table, [(0.0, log[0][1]), *log[1:]], known)
    return {check.key: _evaluated(check, step, samples, table, found) for step, check in checks}


def _evaluated(check: Check, step: int, samples: Samples, table: np.ndarray, found: Rows) -> Evaluated:
    result = evaluate(check, samples)
    if not math.isfinite(result.start):
        return Evaluated(result)
    first, last = np.searchsorted(samples.time, [result.start, result.stop])
    inside = table[first : last + 1]
    start, stop = (float(inside[at, rows.HOST_TIME]) for at in (0, -1))
    _, about, settings = next((one for one in reversed(found.log) if one[0] <= start), found.log[0])
    return Evaluated(result, Part(step, inside.copy(), about, settings), start, stop)


@dataclass
class Progress:
    """The index of the open step (from 0), the entered text by question, and the evaluated checks by key."""

    lesson: Lesson
    step: int = 0
    answers: dict[str, str] = field(default_factory=dict)
    evaluated: dict[str, Evaluated] = field(default_factory=dict)

    def result(self, task: Check | Question) -> Result:
        """Return the current result of a check or question."""
        if isinstance(task, Question):
            return Result(*task.judge(self.answers.get(task.key, "")))
        return self.evaluated.get(task.key, Evaluated(NOT_STARTED)).result

    def note(self, key: str, found: Evaluated) -> bool:
        """Store a check's newest result, unless an earlier result was correct and the newest is not.

        Return whether the stored interval or sentence has changed.
        """
        before = self.evaluated.get(key)
        if before is not None and before.result.correct and not found.result.correct:
            return False
        self.evaluated[key] = found
        return before is None or before.result.text != found.result.text

    def step_done(self, step: int) -> bool:
        """Return whether all checks and questions of a step (index from 0) have a correct answer."""
        tasks = [task for number, _, task in self.lesson.tasks() if number == step + 1]
        return all(self.result(task).state in (CORRECT, "review") for task in tasks)

    @property
    def counts(self) -> tuple[int, int]:
        """Return the number of completed tasks, and the number of all tasks."""
        states = [self.result(task).state in (CORRECT, "review") for _, _, task in self.lesson.tasks()]
        return sum(states), len(states)

    @property
    def begun(self) -> bool:
        """Return whether there is any progress to save."""
        return self.step > 0 or bool(self.answers) or any(one.part for one in self.evaluated.values())

    def save(self, path: Path, student: str, newest: Rows, recordings: Iterable[Path] = ()) -> None:
        """Write the progress as a handed-in file, which replaces the previous one.

        ``newest`` contains the rows that are saved if no interval was evaluated. ``recordings`` are paths of
        sessions; the file also contains those sessions that have trials of an experiment. Raise SessionError
        if the file cannot be written.
        """
        numbers = {task.key: number for number, _, task in self.lesson.tasks()}
        order = [key for key in numbers if key in self.evaluated and self.evaluated[key].part is not None]
        parts = [part for key in order if (part := self.evaluated[key].part) is not None]
        spare = not parts
        if spare:
            table = newest.table
            if not len(table):
                raise SessionError("There is nothing to save yet: no sample was recorded.")
            newest_rows = table[table[:, rows.HOST_TIME] > table[-1, rows.HOST_TIME] - _SAMPLE_SECONDS]
            _, about, settings = newest.log[-1]
            parts = [Part(self.step + 1, newest_rows, about, settings)]
        new = path.with_name(f".{path.stem}.new{path.suffix}")
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            new.unlink(missing_ok=True)
            with ExitStack() as stack:
                hand_in.write_parts(new, parts, _with_trials(recordings, stack))
            intervals = {} if spare else _intervals(new, order, parts)
            hand_in.hand_in(new, self.lesson, student, self.answers, intervals, self.step)
            new.replace(path)
        except OSError as error:
            raise SessionError(f"{path} cannot be written: {error.strerror}.") from None
        finally:
            new.unlink(missing_ok=True)


def _with_trials(recordings: Iterable[Path], stack: ExitStack) -> list[Session]:
    """Return the sessions that contain trials of an experiment; the stack closes them."""
    found = []
    for path in recordings:
        with suppress(SessionError):  # the session's file may have been moved
            session = stack.enter_context(closing(Session(path)))
            trials = experiments.of_session(session)
            if trials.trials or trials.comparisons:
                found.append(session)
    return found


def _intervals(path: Path, keys: Sequence[str], parts: Sequence[Part]) -> dict[str, tuple[float, float]]:
    """Return start and stop in s of each part; the parts are the last samples of a session."""
    with closing(Session(path)) as session:
        time = Samples.of_session(session).time
    ends = len(time) - np.cumsum([0, *(len(part.table) for part in reversed(parts))])[::-1]
    return {
        key: (float(time[first]), float(time[last - 1]))
        for key, (first, last) in zip(keys, pairwise(ends), strict=True)
    }


def file_of(lesson: Lesson) -> Path:
    """Return the file for the user's progress in a lesson; the file may not exist yet."""
    base = os.environ.get(VARIABLE) or platformdirs.user_data_dir("hapkit-studio", appauthor=False)
    return Path(base) / "lessons" / f"{lesson.key}{SUFFIX}"


def load(path: Path, lesson: Lesson, known: Mapping[str, Environment]) -> Progress:
    """Return the progress from a file that ``Progress.save`` wrote; every check is evaluated again.

    Raise SessionError if the file cannot be read.
    """
    handed = hand_in.read(path)
    found = Progress(lesson)
    samples = replace(handed.samples, known=known)
    tasks = {task.key: (number, task) for number, _, task in lesson.tasks()}
    with closing(Session(path)) as session:
        table = _table(session)
        step = session.latest(LESSON).get("step")
        if isinstance(step, int) and 0 <= step < len(lesson.steps):
            found.step = step
        for key, answer in handed.answers.items():
            number, task = tasks.get(key, (0, None))
            if isinstance(task, Question) and answer.given:
                found.answers[key] = answer.given
            if not isinstance(task, Check) or not math.isfinite(answer.result.start):
                continue
            inside = samples.between(answer.result.start - _MARGIN, answer.result.stop + _MARGIN)
            if len(inside) < 2:
                continue
            result = evaluate_interval(task, inside)
            first = int(np.searchsorted(samples.time, inside.time[0]))
            part = table[first : first + len(inside)]
            when = float(part[0, rows.HOST_TIME])
            about, settings = session.latest(ABOUT, when), session.latest(SETTINGS, when)
            found.evaluated[key] = Evaluated(result, Part(number, part, about, settings))
    return found


def _table(session: Session) -> np.ndarray:
    """Return a session's telemetry rows (n, ROW_WIDTH) with NaN for signals that were not recorded."""
    names = [name for name in session.layout.names if name in COLUMN]
    signals: dict[str, Any] = session.read([*names, "state"])
    state = signals.pop("state")
    table = np.full((len(state), rows.ROW_WIDTH), math.nan)
    for name, values in signals.items():
        table[:, COLUMN[name]] = values
    table[:, rows.STATE : rows.STATE + state.shape[1]] = state
    return table
