"""Handing in adds a student's answers as events to the session that contains the samples.

One event names the lesson and the student; each answered check or question is another event. A check's answer
has its interval and a hash of the interval's samples and settings. The check can therefore be evaluated
again, and a modified file is detected.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from hapkit_studio.errors import FileError
from hapkit_studio.files import checked_list, checked_number, checked_text
from hapkit_studio.formatting import plain
from hapkit_studio.haptics import rows
from hapkit_studio.lessons import experiments
from hapkit_studio.lessons.evaluate import WAITING, Result, evaluate, evaluate_interval
from hapkit_studio.lessons.experiments import Experiments
from hapkit_studio.lessons.lesson import Check, Lesson, Question, Step
from hapkit_studio.lessons.play import DEVICE, Played
from hapkit_studio.lessons.samples import Samples
from hapkit_studio.sessions.chunk import pack
from hapkit_studio.sessions.file import ABOUT, SETTINGS, Event, SessionError, SessionWriter
from hapkit_studio.sessions.layout import LAYOUT
from hapkit_studio.sessions.session import Session, add_events
from hapkit_studio.settings_log import LoggedSettings
from hapkit_studio.version import __version__

LESSON, STEP, ANSWER = "lesson", "step", "answer"
"""Kinds of events. They contain lesson and student, the number of a step that starts, or an answer."""
MOST_TEXT = 20_000  # maximum number of characters in an answer
_MOST_LINES, _NAME, _SENTENCE = 1_000, 200, 2_000
_MOST_ANSWERS = 1_000  # maximum number of answers in a file
_LONGEST = 31 * 86_400.0  # s: maximum length of a session
_CHUNK = 1000  # number of samples in a chunk
# s: pause between two parts; time between the settings' event and the first sample after it
_PAUSE, _BEFORE = 0.5, 0.001
_STATES = ("correct", "wrong", "waiting", "review")


@dataclass(frozen=True)
class Answer:
    """A stored answer: either a check's result with its interval, or the text entered for a question."""

    key: str
    result: Result
    given: str = ""


@dataclass(frozen=True)
class HandedIn:
    """A handed-in file: the lesson's key and stamp, the student, the samples, and the answers by key.

    ``experiments`` are the trials of experiments in the file. ``damage`` contains messages about unreadable
    parts of the file.
    """

    path: Path
    lesson: str
    stamp: str
    student: str
    samples: Samples
    answers: Mapping[str, Answer]
    about: Mapping[str, Any]
    damage: tuple[str, ...]
    experiments: Experiments

    def of_lesson(self, lesson: Lesson) -> "HandedIn":
        """Return the file with the environments of its lesson, which its checks need."""
        return replace(self, samples=replace(self.samples, known=lesson.known))


def hand_in(
    path: str | Path,
    lesson: Lesson,
    student: str,
    answers: Mapping[str, str],
    intervals: Mapping[str, tuple[float, float]] | None = None,
    step: int = 0,
) -> list[tuple[Check | Question, Result]]:
    """Add the answers to a complete session, and return the result of every check and question.

    ``answers`` contains the entered text for each question's key. ``intervals`` contains start and stop in s
    after the session's start for the key of each evaluated check; other checks are evaluated on the step's
    samples. ``step`` is the index of the open step. Raise SessionError if the session is incomplete, damaged,
    or cannot be written.
    """
    found: list[tuple[Check | Question, Result]] = []

    def make(session: Session) -> Iterable[Event]:
        when = float(session.stops[-1])
        who = checked_text(" ".join(student.split()), "The student's name", _NAME)
        about = {"key": lesson.key, "title": lesson.title, "stamp": lesson.stamp}
        yield Event(when, LESSON, {**about, "student": who, "step": step, "studio": __version__})
        samples = replace(Samples.of_session(session), known=lesson.known)
        ranges = _step_ranges(session, samples)
        for number, _, task in lesson.tasks():
            if isinstance(task, Question):
                given = answers.get(task.key, "")
                result = Result(*task.judge(given))
                detail: dict[str, Any] = {"given": given[:MOST_TEXT].splitlines()[:_MOST_LINES]}
            else:
                own = ranges.get(number, []) if ranges else None
                result = _evaluated(task, samples, own, (intervals or {}).get(task.key))
                detail = {}
            found.append((task, result))
            yield Event(when, ANSWER, {"key": task.key, **detail, **plain(result)})

    try:
        add_events(Path(path), make)
    except SessionError:
        raise
    except FileError as error:
        raise SessionError(str(error)) from None
    return found


def _evaluated(
    check: Check,
    samples: Samples,
    ranges: Sequence[tuple[float, float]] | None,
    interval: tuple[float, float] | None,
) -> Result:
    if interval is not None:
        return evaluate_interval(check, samples.between(*interval))
    if ranges is None:
        return evaluate(check, samples)
    if not ranges:
        return Result(WAITING, "Nothing was recorded in this step.")
    found = [evaluate(check, samples.between(start, stop)) for start, stop in reversed(ranges)]
    return next((result for result in found if result.correct), found[0])


def _step_ranges(session: Session, samples: Samples) -> dict[int, list[tuple[float, float]]]:
    """Return the intervals (start, stop) of each step in s after the session's start; {} if unknown."""
    begin = float(session.starts[0])
    steps = [(event.time - begin, event.what.get("number")) for event in session.events if event.kind == STEP]
    found: dict[int, list[tuple[float, float]]] = {}
    for (start, number), (end, _) in pairwise([*steps, (math.inf, None)]):
        if isinstance(number, int):
            found.setdefault(number, []).append((start, end))
    return found


def step_event(time: float, number: int) -> Event:
    """Return the event for the start of a step (counted from 1) at a time in s of the computer's clock."""
    return Event(time, STEP, {"number": number})


def save_played(
    path: str | Path, lesson: Lesson, played: Sequence[tuple[Step, Played]], student: str
) -> list[tuple[Check | Question, Result]]:
    """Save a scripted student's runs as a new session, and hand it in.

    Raise SessionError if the file cannot be written.
    """
    answers = {key: given for _, one in played for key, given in one.answers.items()}
    about = {"device": "Simulated Hapkit", "quantum_m": DEVICE.quantum}
    write_parts(
        path,
        [
            Part(number, table, about, settings)
            for number, (_, one) in enumerate(played, 1)
            for table, settings in zip(one.tables, one.settings, strict=True)
        ],
    )
    return hand_in(path, lesson, student, answers)


@dataclass(frozen=True)
class Part:
    """Telemetry rows (n, ROW_WIDTH), n > 0, without gaps, with their step's number, device and settings."""

    step: int
    table: np.ndarray
    about: LoggedSettings
    settings: LoggedSettings


def write_parts(path: str | Path, parts: Sequence[Part], recordings: Iterable[Session] = ()) -> None:
    """Write recordings unchanged, then parts one after another, into a new session.

    The clocks of each part are shifted so that the part starts _PAUSE after the samples before it. A
    recording that overlaps in time with an earlier one is omitted. This may happen after a restart of the
    computer, which also restarts its clock. Raise SessionError if the file cannot be written.
    """
    step = 0
    about: LoggedSettings = {}
    with SessionWriter.whole(path) as writer:
        begin = _copy(writer, recordings)
        for part in parts:
            table = part.table.copy()
            for clock in (rows.HOST_TIME, rows.BOARD_TIME):
                table[:, clock] += begin - table[0, clock]
            noted = begin - _BEFORE
            if part.about != about:
                writer.note(Event(noted, ABOUT, dict(part.about)))
            if part.step != step:
                writer.note(step_event(noted, part.step))
            writer.note(Event(noted, SETTINGS, dict(part.settings)))
            step, about = part.step, part.about
            states = len(part.settings["state_names"])
            for first in range(0, len(table), _CHUNK):
                writer.add(pack(table[first : first + _CHUNK], part.about["quantum_m"], states))
            begin = float(table[-1, rows.HOST_TIME]) + _PAUSE


def _copy(writer: SessionWriter, recordings: Iterable[Session]) -> float:
    """Write recordings in the order of time; return the time in s at which the next part may start."""
    begin = 0.0
    for recording in sorted(recordings, key=lambda one: float(one.starts[0])):
        if recording.layout != LAYOUT or recording.starts[0] < begin:
            continue
        for event in recording.events:
            if event.kind not in (LESSON, STEP, ANSWER):
                writer.note(event)
        for number in range(len(recording.counts)):
            writer.add(recording.chunk(number))
        begin = float(recording.stops[-1]) + _PAUSE
    return begin


# --- read a handed-in file


def read(path: str | Path) -> HandedIn:
    """Read a handed-in file; raise SessionError for any other file."""
    with closing(Session(path)) as session:
        lesson = session.latest(LESSON)
        if not lesson:
            raise SessionError(
                f"{session.name} is a recording without a lesson, not a file that was handed in."
            )
        try:
            key, student, stamp = (
                checked_text(lesson.get(name), f"{session.name}: {name}", _NAME)
                for name in ("key", "student", "stamp")
            )
            answers_given = [event.what for event in session.events if event.kind == ANSWER][-_MOST_ANSWERS:]
            answers = {
                answer.key: answer for answer in (_answer(what, session.name) for what in answers_given)
            }
        except FileError as error:
            raise SessionError(str(error)) from None
        samples = Samples.of_session(session)
        about, damage, found = session.latest(ABOUT), session.damage, Experiments()
        try:
            found = experiments.of_session(session)
        except SessionError as error:
            damage = (*damage, str(error))
        return HandedIn(session.path, key, stamp, student, samples, answers, about, damage, found)


def _answer(what: Mapping[str, Any], name: str) -> Answer:
    """Check every value of an answer and return the answer; raise FileError for an invalid value."""
    key = checked_text(what.get("key"), f"{name}: an answer's key", 20)
    place = f"{name}: answer {key}"
    state = checked_text(what.get("state"), f"{place}: state", 20)
    if state not in _STATES:
        raise FileError(f"{place}: the state must be one of {', '.join(_STATES)}, not {state}.")
    numbers = {
        field: math.nan
        if what.get(field) is None
        else checked_number(what[field], f"{place}: {field}", *limits)
        for field, limits in (
            ("value", (-1e12, 1e12)),
            ("half", (-1e12, 1e12)),
            ("start", (0.0, _LONGEST)),
            ("stop", (0.0, _LONGEST)),
        )
    }
    lines = what.get("given", [])
    given = [
        checked_text(line, f"{place}: given", MOST_TEXT)
        for line in (checked_list(lines, place) if lines else [])
    ]
    return Answer(
        key,
        Result(
            state,
            checked_text(what.get("text"), f"{place}: text", _SENTENCE),
            stamp=checked_text(what.get("stamp", ""), f"{place}: stamp", _NAME),
            **numbers,
        ),
        "\n".join(given[:_MOST_LINES]),
    )
