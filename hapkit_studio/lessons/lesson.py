"""The parts of a lesson: steps with text, settings, checks, questions, plots and hints."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from hapkit_studio.dynamics.hand import Grip
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import FileError
from hapkit_studio.formatting import number

MOST_CRITERIA = 50  # maximum number of rows of a rubric
_ROUNDING = 1e-12  # relative rounding error of decimal numbers: 2.1 − 2.0 is more than 0.1


class LessonError(FileError):
    """A lesson is invalid; the message names the lesson's file and line."""


@dataclass(frozen=True)
class Text:
    """Markdown as tokens of markdown-it."""

    tokens: Sequence[Any]


@dataclass(frozen=True)
class Formula:
    """A displayed formula in the TeX of matplotlib's mathtext."""

    tex: str
    line: int


@dataclass(frozen=True)
class Hint:
    """A hint, which is shown on request."""

    tokens: Sequence[Any]


@dataclass(frozen=True)
class Plot:
    """A plot in a step's text; the report draws it from the evaluated interval."""

    over: str
    caption: str


@dataclass(frozen=True)
class Scene:
    """The initial settings of a step. If ``grip`` is None, there is no hand.

    ``view`` is the page that the window shows.
    """

    environment: Environment
    values: Mapping[str, float]
    loop: LoopSettings
    grip: str
    device: str
    view: str
    hide: tuple[str, ...]
    lock: tuple[str, ...]


@dataclass(frozen=True)
class Check:
    """A measurement on the student's own data, and its expected value.

    ``expect`` is a number in SI, or the key of a parameter whose current value is expected. ``tolerance`` is
    in SI, or in percent of the expected value. ``at_least`` and ``at_most`` are limits that replace an
    expected value. ``needs`` maps the name of each required movement to its smallest permitted size.
    ``where`` contains the permitted range, or a choice's permitted option, of each setting by key.
    ``between`` contains the two positions in m between which the handle must move.
    """

    key: str
    line: int
    title: str
    measure: str
    environment: str
    expect: float | str | None = None
    tolerance: float | None = None
    percent: float | None = None
    at_least: float | None = None
    at_most: float | None = None
    needs: Mapping[str, float] = field(default_factory=dict)
    where: Mapping[str, tuple[float, float] | str] = field(default_factory=dict)
    between: tuple[float, float] | None = None
    seconds: float | None = None
    wrong: str = ""


@dataclass(frozen=True)
class Question:
    """A question. Its answer is one of several options, a number with unit and tolerance, or free text."""

    key: str
    line: int
    text: str
    options: tuple[str, ...] = ()
    answer: str = ""
    value: float | None = None
    unit: str = ""
    tolerance: float = 0.0
    wrong: str = ""

    @property
    def kind(self) -> str:
        return "choice" if self.options else "text" if self.value is None else "number"

    @property
    def example(self) -> str:
        """Return an answer that is accepted."""
        if self.value is not None:
            return f"{self.value:g}"
        return self.answer or "My answer in my own words."

    def judge(self, given: str) -> tuple[str, str]:
        """Return the state of an entered answer, and a sentence about it."""
        given = given.strip()
        if not given:
            return "waiting", "This question is not answered yet."
        if self.kind == "text":
            return "review", "Your answer is stored. A reviewer will read it."
        if self.kind == "choice":
            if given == self.answer:
                return "correct", "Your answer is correct."
            return "wrong", self.wrong or "This answer is wrong. Read the step again."
        try:
            found = float(given.replace(",", ".").replace("\N{MINUS SIGN}", "-"))
        except ValueError:
            return "wrong", f"Enter a number in {self.unit}." if self.unit else "Enter a number."
        assert self.value is not None
        rounding = _ROUNDING * (abs(self.value) + self.tolerance)
        if abs(found - self.value) <= self.tolerance + rounding:
            return "correct", f"{given} {self.unit}".rstrip() + " is correct."
        way = "too high" if found > self.value else "too low"
        return "wrong", f"{given} {self.unit}".rstrip() + f" is {way}. {self.wrong}".rstrip()


@dataclass(frozen=True)
class Play:
    """One run of a scripted student: settings that differ from those of the scene, and the hand's path.

    ``path`` is the name of a path in ``SCRIPTS``, or a sequence of points (time in s, position in m).
    ``release`` is the time in s at which the hand releases the handle.
    """

    values: Mapping[str, float]
    loop: LoopSettings
    grip: Grip | None
    path: str | tuple[tuple[float, float], ...]
    release: float
    seconds: float
    environment: Environment


Block = Text | Formula | Hint | Plot | Check | Question


@dataclass(frozen=True)
class Step:
    """A step with its title, its content in the order of the file, its scene and its scripted runs."""

    title: str
    line: int
    blocks: tuple[Block, ...]
    scene: Scene
    plays: tuple[Play, ...]

    @property
    def checks(self) -> tuple[Check, ...]:
        return tuple(block for block in self.blocks if isinstance(block, Check))

    @property
    def questions(self) -> tuple[Question, ...]:
        return tuple(block for block in self.blocks if isinstance(block, Question))


@dataclass(frozen=True)
class Criterion:
    """A row of the table of criteria for a review."""

    text: str
    points: int


@dataclass(frozen=True)
class Lesson:
    """A lesson. ``key`` is the name of its file, ``stamp`` the hash of its text.

    If ``hide_names`` is True, reports and reviews do not name students. ``known`` are the environments by key
    with which the file was read; they may include environments that are not in the library.
    """

    key: str
    path: Path
    title: str
    aim: str
    minutes: float
    order: int
    environments: tuple[str, ...]
    hide: tuple[str, ...]
    lock: tuple[str, ...]
    rubric: tuple[Criterion, ...]
    intro: tuple[Block, ...]
    steps: tuple[Step, ...]
    stamp: str
    hide_names: bool = False
    known: Mapping[str, Environment] = field(default_factory=dict, repr=False, compare=False)

    def tasks(self) -> Iterator[tuple[int, Step, Check | Question]]:
        """Yield all checks and questions, each with its step and the step's number (counted from 1)."""
        for at, step in enumerate(self.steps, 1):
            for block in step.blocks:
                if isinstance(block, Check | Question):
                    yield at, step, block

    @property
    def summary(self) -> str:
        """Return one line with the numbers of steps, checks and questions, and the duration."""
        kinds = [type(task) for _, _, task in self.tasks()]
        counts = {
            "step": len(self.steps),
            "check": kinds.count(Check),
            "question": kinds.count(Question),
        }
        parts = [f"{count} {name}{'s' if count != 1 else ''}" for name, count in counts.items()]
        return ", ".join([*parts, f"{number(self.minutes, 0)} min"])
