"""What a lesson consists of: steps of text, settings, checks, questions, plots and hints."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from hapkit_studio.dynamics.hand import Grip
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import FileError
from hapkit_studio.formatting import number


class LessonError(FileError):
    """A lesson cannot be used; the text names its file and line."""


@dataclass(frozen=True)
class Text:
    """Markdown, parsed into tokens of markdown-it."""

    tokens: Sequence[Any]


@dataclass(frozen=True)
class Formula:
    """A displayed formula in TeX, as matplotlib's mathtext takes it."""

    tex: str
    line: int


@dataclass(frozen=True)
class Hint:
    """Help that is shown on request."""

    tokens: Sequence[Any]


@dataclass(frozen=True)
class Plot:
    """A plot that a step points at, and that the report draws from the evaluated interval."""

    over: str
    caption: str


@dataclass(frozen=True)
class Scene:
    """The settings with which a step begins; grip None: no hand. view: the page of the window to show."""

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
    """A measurement on the student's own data and what it must come to.

    expect: a number in SI, or the key of a parameter whose value in force is expected; tolerance in SI, or
    percent of what is expected; at_least, at_most: limits in place of an expected value. needs: the least
    size of the movement by the name of a quantity; where: the range of settings in force that counts, by key,
    or the option of a choice. between: positions in m that the handle must pass.
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
    """A question: options and the right one; a number with unit and tolerance; or free text."""

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
        """Return "choice", "number" or "text"."""
        return "choice" if self.options else "text" if self.value is None else "number"

    @property
    def example(self) -> str:
        """Return an answer that is accepted."""
        if self.value is not None:
            return f"{self.value:g}"
        return self.answer or "My answer in my own words."

    def judge(self, given: str) -> tuple[str, str]:
        """Return the state and a sentence for an answer as it was entered."""
        given = given.strip()
        if not given:
            return "waiting", "Not answered yet."
        if self.kind == "text":
            return "review", "Answered; a reviewer reads it."
        if self.kind == "choice":
            right = given == self.answer
            return ("correct", "Correct.") if right else ("wrong", self.wrong or "Read the step again.")
        try:
            found = float(given.replace(",", ".").replace("\N{MINUS SIGN}", "-"))
        except ValueError:
            return "wrong", f"Enter a number in {self.unit}." if self.unit else "Enter a number."
        assert self.value is not None
        if abs(found - self.value) <= self.tolerance:
            return "correct", f"{given} {self.unit}".rstrip() + ": correct."
        way = "too high" if found > self.value else "too low"
        return "wrong", f"{given} {self.unit}".rstrip() + f" is {way}. {self.wrong}".rstrip()


@dataclass(frozen=True)
class Play:
    """One run of a scripted student: settings that differ from the scene's, and the hand's path.

    path: the hand's name in ``SCRIPTS``, or points (s, m); release: when it lets go in s.
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
    """One step: its title, its content in the order of the file, its scene and its scripted runs."""

    title: str
    line: int
    blocks: tuple[Block, ...]
    scene: Scene
    plays: tuple[Play, ...]

    @property
    def checks(self) -> tuple[Check, ...]:
        """Return the step's checks."""
        return tuple(block for block in self.blocks if isinstance(block, Check))

    @property
    def questions(self) -> tuple[Question, ...]:
        """Return the step's questions."""
        return tuple(block for block in self.blocks if isinstance(block, Question))


@dataclass(frozen=True)
class Criterion:
    """A row of the rubric."""

    text: str
    points: int


@dataclass(frozen=True)
class Lesson:
    """A lesson: its key is its file's name; source its text; stamp identifies this version of the text."""

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

    def tasks(self) -> Iterator[tuple[int, Step, Check | Question]]:
        """Yield every check and question with its step and the step's number, the first 1."""
        for at, step in enumerate(self.steps, 1):
            for block in step.blocks:
                if isinstance(block, Check | Question):
                    yield at, step, block

    @property
    def summary(self) -> str:
        """Return steps, checks, questions and duration in one line."""
        kinds = [type(task) for _, _, task in self.tasks()]
        counts = {
            "step": len(self.steps),
            "check": kinds.count(Check),
            "question": kinds.count(Question),
        }
        words = [f"{count} {name}{'s' if count != 1 else ''}" for name, count in counts.items()]
        return ", ".join([*words, f"{number(self.minutes, 0)} min"])
