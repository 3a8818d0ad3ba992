"""The parser of lesson files, which are Markdown with a TOML header and fenced blocks; it checks all parts.

No part of a lesson is executed, and HTML in it is shown as text. An error names the file and the line.
"""

import hashlib
import math
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

from markdown_it import MarkdownIt
from markdown_it.token import Token

from hapkit_studio import environments
from hapkit_studio.discovery import assigning
from hapkit_studio.dynamics.hand import ALL_GRIPS, SCRIPTS, Grip, grip_named
from hapkit_studio.dynamics.loop_settings import USUAL_LOOP, LoopSettings, estimator_texts
from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import FileError, ParameterError
from hapkit_studio.files import (
    checked_integer,
    checked_list,
    checked_number,
    checked_table,
    checked_text,
    parse_toml,
    read_text,
)
from hapkit_studio.formatting import quoted
from hapkit_studio.lessons.lesson import (
    MOST_CRITERIA,
    Block,
    Check,
    Criterion,
    Formula,
    Hint,
    Lesson,
    LessonError,
    Play,
    Plot,
    Question,
    Scene,
    Step,
    Text,
)
from hapkit_studio.lessons.measurements import MEASUREMENTS, NEEDS
from hapkit_studio.parameters import Choice

SUFFIX = ".md"
MOST_STEPS, MOST_TASKS = 40, 100
HIDDEN = ("values", "theory", "verdict", "map", "energy")
"""The parts of the window that a lesson may hide."""
DEVICES = ("any", "simulated")
OVER = ("time", "position", "velocity")
_FENCE = "+++"
_LINE, _PARAGRAPH = 200, 1_000  # maximum numbers of characters of a line and of a paragraph
_MOST_NESTED = 20  # maximum nesting depth of Markdown's blocks
_REACH = 0.06  # m: positions beyond this are outside the range of every handle
_LONGEST_PLAY = 60.0  # s: maximum duration of a run
_WORD = re.compile(r"[a-z][a-z0-9_]*")


@cache
def views() -> tuple[str, ...]:
    """Return the keys of the window's views; they are the names of modules, which are not imported."""
    return "live", *assigning(Path(__file__).parents[1] / "gui" / "pages", "VIEW")


def _is_web_link(url: str) -> bool:
    return url.lower().startswith(("http://", "https://"))


def markdown() -> MarkdownIt:
    """Return the Markdown parser of lessons: CommonMark without HTML and images, with tables.

    Only links to web pages are links, because another scheme may start a program.
    """
    found = MarkdownIt("commonmark", {"html": False, "maxNesting": _MOST_NESTED}).enable("table")
    found.validateLink = _is_web_link  # type: ignore[method-assign]
    return found.disable(["image", "html_block", "html_inline"])


def read(path: str | Path, known: Mapping[str, Environment] | None = None) -> Lesson:
    """Read a lesson from a file; raise LessonError if the file is invalid.

    ``known`` are the environments by key; None means those of the library.
    """
    path = Path(path)
    try:
        text = read_text(path).replace("\r\n", "\n").replace("\r", "\n")
        return _Reader(path, text, environments.discover() if known is None else known).lesson()
    except LessonError:
        raise
    except FileError as error:
        raise LessonError(str(error)) from None


class _Reader:
    """Reads one file; ``line`` is the line number of the current block."""

    def __init__(self, path: Path, text: str, known: Mapping[str, Environment]):
        self.path, self.text, self.known = path, text, known
        self.lines = text.split("\n")
        self.tasks = 0

    def lesson(self) -> Lesson:
        end = self._header_end()
        head = self._table("\n".join(self.lines[1:end]), 2, end)
        found = {
            "title": head.text("title"),
            "aim": head.text("aim", _PARAGRAPH),
            "minutes": head.number("minutes", 1.0, 600.0, "min"),
            "order": head.integer("order", 0, 1000, 100),
            "hide": head.names("hide", HIDDEN),
            "rubric": self._rubric(head),
            "hide_names": head.flag("hide_names"),
        }
        keys = head.names("environments", tuple(self.known))
        if not keys:
            raise head.wrong("environments", "a lesson must have at least one environment")
        lock = head.names("lock", self._lockable(keys))
        head.finish()
        # Replace the header by empty lines, so that a token's line number is that of the file.
        body = "\n" * (end + 1) + "\n".join(self.lines[end + 1 :])
        intro, steps = self._steps(markdown().parse(body), self._first_scene(keys[0], lock, found["hide"]))
        if not steps:
            raise self._error(
                end + 1, 'a lesson must have at least one step, with a heading such as "## Press"'
            )
        return Lesson(
            key=self.path.stem,
            path=self.path,
            environments=keys,
            lock=lock,
            intro=intro,
            steps=steps,
            stamp=hashlib.sha256(self.text.encode()).hexdigest()[:16],
            known=self.known,
            **found,
        )

    def _header_end(self) -> int:
        """Return the index of the header's last line, counted from 0."""
        if self.lines[0].strip() != _FENCE:
            raise self._error(1, f"a lesson must begin with a header between two lines {_FENCE}")
        for at, line in enumerate(self.lines[1:], 1):
            if line.strip() == _FENCE:
                return at
        raise self._error(1, f"the header does not end; write a line {_FENCE} below it")

    def _lockable(self, keys: Iterable[str]) -> tuple[str, ...]:
        names = (p.key for key in keys for p in self.known[key].parameters)
        return tuple(dict.fromkeys([*names, "loop", "environment"]))

    def _first_scene(self, key: str, lock: tuple[str, ...], hide: tuple[str, ...]) -> Scene:
        environment = self.known[key]
        loop = USUAL_LOOP
        return Scene(environment, environment.values(), loop, "medium", "any", "live", hide, lock)

    def _error(self, line: int, wrong: str) -> LessonError:
        return LessonError(f"{self.path.name}, line {line}: {wrong}.")

    def _table(self, text: str, line: int, last: int) -> "_Table":
        """Return the TOML table in some lines of the file.

        Empty lines are put before the text, so that errors have the file's line numbers.
        """
        found = parse_toml("\n" * (line - 1) + text, self.path.name)
        return _Table(self, found, line, last)

    @staticmethod
    def _rubric(head: "_Table") -> tuple[Criterion, ...]:
        rows = head.records("rubric", lambda row: Criterion(row.text("text"), row.integer("points", 1, 100)))
        if len(rows) > MOST_CRITERIA:
            raise head.wrong("rubric", f"a rubric may have at most {MOST_CRITERIA} rows, not {len(rows)}")
        if len({row.text for row in rows}) < len(rows):
            raise head.wrong("rubric", "two rows of the rubric have the same text")
        return rows

    # --- steps

    def _steps(self, tokens: list[Token], scene: Scene) -> tuple[tuple[Block, ...], tuple[Step, ...]]:
        """Return the blocks before the first step, and the steps."""
        intro: list[Block] = []
        steps: list[Step] = []
        blocks, plays, text = intro, list[Play](), list[Token]()

        def end_text() -> None:
            if text:
                blocks.append(Text(tuple(text)))
                text.clear()

        def end_step() -> None:
            end_text()
            if steps:
                steps[-1] = replace(steps[-1], blocks=tuple(blocks), plays=tuple(plays), scene=scene)

        at = 0
        while at < len(tokens):
            token = tokens[at]
            line = token.map[0] + 1 if token.map else 0
            if token.type == "heading_open" and token.tag in ("h1", "h2") and token.level == 0:
                end_step()
                if token.tag == "h1" or len(steps) >= MOST_STEPS:
                    wrong = "a step must begin with ##; the title of the lesson is in its header"
                    most = f"a lesson may have at most {MOST_STEPS} steps"
                    raise self._error(line, wrong if token.tag == "h1" else most)
                title = tokens[at + 1].content
                self._checked(checked_text, title, line, "a step's title", _LINE)
                steps.append(Step(title, line, (), scene, ()))
                blocks, plays = [], []
                at += 3
                continue
            if token.type == "fence" and token.level == 0:
                end_text()
                word, last = token.info.strip(), token.map[1] if token.map else line
                if word == "set":
                    scene = self._scene(self._table(token.content, line + 1, last), scene)
                elif word == "play":
                    plays.append(self._play(self._table(token.content, line + 1, last), scene))
                else:
                    step = len(steps)
                    if step == 0:
                        raise self._error(
                            line, "a block must belong to a step: write the step's ## heading above it"
                        )
                    blocks.append(self._block(word, token.content, line, last, scene, step))
            else:
                text.append(token)
            at += 1
        end_step()
        return tuple(intro), tuple(steps)

    def _block(self, word: str, content: str, line: int, last: int, scene: Scene, step: int) -> Block:
        if word == "math":
            self._checked(checked_text, content.strip(), line, "a formula", _PARAGRAPH)
            return Formula(content.strip(), line)
        if word == "hint":
            return Hint(tuple(markdown().parse(content)))
        makers: dict[str, Callable[..., Block]] = {
            "check": self._check,
            "question": self._question,
            "plot": self._plot,
        }
        if word not in makers:
            known = ", ".join(("set", *makers, "hint", "math", "play"))
            raise self._error(line, f"a block must be one of {known}, not {quoted(word)}")
        self.tasks += word != "plot"
        if self.tasks > MOST_TASKS:
            raise self._error(line, f"a lesson may have at most {MOST_TASKS} checks and questions")
        return makers[word](self._table(content, line + 1, last), scene, f"{step}.{self.tasks}")

    def _checked(self, check: Callable[..., Any], value: object, line: int, what: str, *limits: Any) -> Any:
        try:
            return check(value, what, *limits)
        except FileError as error:
            raise LessonError(f"{self.path.name}, line {line}: {error}") from None

    # --- blocks

    def _scene(self, table: "_Table", before: Scene) -> Scene:
        environment = table.choice("environment", self.known, None)
        changed = environment is not None
        found = self.known[environment] if environment else before.environment
        values = table.values(found, {} if changed else before.values)
        loop = self._loop(table, before.loop)
        scene = Scene(
            environment=found,
            values=values,
            loop=loop,
            grip=table.choice("grip", ALL_GRIPS, before.grip) or "released",
            device=table.choice("device", DEVICES, before.device) or DEVICES[0],
            view=table.choice("view", views(), before.view) or views()[0],
            hide=table.names("hide", HIDDEN, before.hide),
            lock=table.names("lock", self._lockable([found.key]), before.lock),
        )
        table.finish()
        return scene

    def _loop(self, table: "_Table", before: LoopSettings) -> LoopSettings:
        given = table.table("loop")
        names = ("rate", "delay", "estimator", "controller")
        for key in given:
            if key not in names:
                raise table.wrong("loop", f"the loop has {', '.join(names)}, not {quoted(key)}")
        spec = given.get("estimator")
        try:
            if isinstance(spec, list):
                given = {**given, "estimator": tuple(spec)}
            changed = before.changed(**given)
            estimator_texts(changed.estimator)
        except (ParameterError, TypeError, ValueError) as error:
            raise table.wrong("loop", str(error).removesuffix(".")) from None
        return changed

    def _check(self, table: "_Table", scene: Scene, key: str) -> Check:
        measure = table.choice("measure", MEASUREMENTS)
        assert measure is not None
        environment = table.choice("environment", self.known, scene.environment.key)
        assert environment is not None
        known = self.known[environment]
        expect = table.get("expect")
        if isinstance(expect, str):
            names = [p.key for p in known.parameters if not p.discrete]
            if expect not in names:
                raise table.wrong(
                    "expect", f"a parameter must be one of {', '.join(names)}, not {quoted(expect)}"
                )
        elif expect is not None:
            given = expect
            expect = table.attempt("expect", checked_number, given, "expect", -1e9, 1e9)
        tolerance, percent, least, most = (
            table.number(name, low, 1e9, default=None)
            for name, low in (("tolerance", 0.0), ("percent", 0.0), ("at_least", -1e9), ("at_most", -1e9))
        )
        if expect is None and least is None and most is None:
            raise table.wrong(
                "measure", "a check needs expect with tolerance or percent, or at_least or at_most"
            )
        if (expect is None) != (tolerance is None and percent is None):
            raise table.wrong(
                "expect", "expect needs tolerance or percent, and excludes at_least and at_most"
            )
        if expect is not None and (least is not None or most is not None):
            raise table.wrong("expect", "expect excludes at_least and at_most")
        if tolerance is not None and percent is not None:
            raise table.wrong("percent", "a check must have either tolerance or percent, not both")
        if percent is not None and expect == 0.0:
            raise table.wrong("percent", "a percentage of zero is zero; give a tolerance")
        if least is not None and most is not None and least > most:
            raise table.wrong("at_least", f"at_least is {least:g}, more than at_most, {most:g}")
        between = table.get("between")
        if between is not None:
            between = tuple(table.points("between", between))
        if MEASUREMENTS[measure].needs_region and between is None:
            raise table.wrong("measure", f"{measure} needs the entry between = [from, to] in m")
        check = Check(
            key=key,
            line=table.line,
            title=table.text("title"),
            measure=measure,
            environment=environment,
            expect=expect,
            tolerance=tolerance,
            percent=percent,
            at_least=least,
            at_most=most,
            needs=table.numbers("needs", NEEDS),
            where=self._where(table, known),
            between=between,  # type: ignore[arg-type]
            seconds=table.number("seconds", 0.05, 30.0, "s", None),
            wrong=table.text("wrong", _PARAGRAPH, ""),
        )
        table.finish()
        return check

    @staticmethod
    def _where(table: "_Table", known: Environment) -> dict[str, tuple[float, float] | str]:
        found: dict[str, tuple[float, float] | str] = {}
        parameters = {p.key: p for p in known.parameters}
        loop = ("rate", "delay", "estimator")
        for key, wanted in table.table("where").items():
            if key not in parameters and key not in loop:
                among = ", ".join([*parameters, *loop])
                raise table.wrong("where", f"a setting must be one of {among}, not {quoted(key)}")
            if key == "estimator":
                found[key] = table.attempt("where", checked_text, wanted, key, _LINE)
                table.attempt("where", estimator_texts, wanted)
            elif isinstance(choice := parameters.get(key), Choice):
                index = table.attempt("where", choice.check, wanted)
                found[key] = choice.text(index)
            else:
                low, high = table.points("where", wanted)
                found[key] = low, high
        return found

    @staticmethod
    def _question(table: "_Table", scene: Scene, key: str) -> Question:
        given = table.get("options")
        options = ()
        if given is not None:
            texts = table.attempt("options", checked_list, given, "options")
            options = tuple(table.attempt("options", checked_text, t, "an option", _LINE) for t in texts)
        question = Question(
            key=key,
            line=table.line,
            text=table.text("text", _PARAGRAPH),
            options=options,
            answer=table.text("answer", _LINE, ""),
            value=table.number("value", -1e12, 1e12, default=None),
            unit=table.text("unit", 20, ""),
            tolerance=table.number("tolerance", 0.0, 1e12, default=0.0) or 0.0,
            wrong=table.text("wrong", _PARAGRAPH, ""),
        )
        table.finish()
        if options and question.answer not in options:
            raise table.wrong(
                "answer", f"the answer must be one of the options, not {quoted(question.answer)}"
            )
        if question.answer and not options:
            raise table.wrong("answer", "an answer needs options; a number is given as value")
        if question.tolerance and question.value is None:
            raise table.wrong("tolerance", "a tolerance needs a value")
        if options and question.value is not None:
            raise table.wrong("value", "a question must have either options or a value, not both")
        return question

    @staticmethod
    def _plot(table: "_Table", scene: Scene, key: str) -> Plot:
        plot = Plot(table.choice("over", OVER, OVER[0]) or OVER[0], table.text("caption", _PARAGRAPH, ""))
        table.finish()
        return plot

    def _play(self, table: "_Table", scene: Scene) -> Play:
        key = table.choice("environment", self.known, None)
        environment = self.known[key] if key else scene.environment
        values = table.values(environment, {} if key else scene.values)
        loop = self._loop(table, scene.loop)
        grip = self._grip(table, scene)
        hand = table.peek("hand")
        path: str | tuple[tuple[float, float], ...]
        if isinstance(hand, list):
            table.get("hand")
            path = tuple(
                (seconds, 1e-3 * millimetres)
                for seconds, millimetres in (
                    table.points("hand", point, 1e3 * _REACH, "mm") for point in hand
                )
            )
            times = [when for when, _ in path]
            if not path or times[0] < 0.0 or sorted(set(times)) != times:
                raise table.wrong("hand", "the times of the hand's path must increase, from 0 s or later")
        else:
            path = table.choice("hand", SCRIPTS, "released") or "released"
        play = Play(
            values=values,
            loop=loop,
            grip=grip,
            path=path,
            release=table.number("release", 0.0, _LONGEST_PLAY, "s", math.inf) or 0.0,
            seconds=table.number("seconds", 0.1, _LONGEST_PLAY, "s", 3.0) or 3.0,
            environment=environment,
        )
        table.finish()
        return play

    @staticmethod
    def _grip(table: "_Table", scene: Scene) -> Grip | None:
        """Return a grip by its name, or a grip with the given mass, damping and stiffness."""
        if not isinstance(table.peek("grip"), dict):
            return grip_named(table.choice("grip", ALL_GRIPS, scene.grip) or "released")
        names = ("mass", "damping", "stiffness")
        given = table.numbers("grip", names)
        return Grip(*(given.get(name, 0.0) for name in names))


class _Table:
    """A TOML table of a lesson. Reading a value removes it, and ``finish`` rejects the values that remain."""

    def __init__(self, reader: _Reader, values: Mapping[str, Any], line: int, last: int):
        self._reader, self._left, self.line, self._last = reader, dict(values), line, last

    def line_of(self, key: str) -> int:
        """Return the line number of a key.

        If the table lacks the key, return the line number of the table.
        """
        begins = re.compile(rf"\s*{re.escape(key)}\s*[=.]|\s*\[+\s*{re.escape(key)}\s*\]")
        for line in range(self.line, self._last + 1):
            if begins.match(self._reader.lines[line - 1]):
                return line
        return self.line

    def wrong(self, key: str, why: str) -> LessonError:
        return self._reader._error(self.line_of(key), why)

    def attempt(self, key: str, check: Callable[..., Any], *given: Any) -> Any:
        """Return the result of ``check`` for these values.

        Raise LessonError with the line number of the key.
        """
        try:
            return check(*given)
        except ParameterError as error:
            raise self.wrong(key, str(error).removesuffix(".")) from None

    def peek(self, key: str) -> Any:
        return self._left.get(key)

    def get(self, key: str) -> Any:
        return self._left.pop(key, None)

    def text(self, key: str, longest: int = _LINE, default: str | None = None) -> str:
        if key not in self._left and default is not None:
            return default
        if key not in self._left:
            raise self.wrong(key, f"{key} is missing")
        value = self.get(key)
        return self.attempt(key, checked_text, value, key, longest)

    def number(self, key: str, low: float, high: float, unit: str = "", default: Any = ...) -> Any:
        if key not in self._left and default is not ...:
            return default
        if key not in self._left:
            raise self.wrong(key, f"{key} is missing")
        value = self.get(key)
        return self.attempt(key, checked_number, value, key, low, high, unit)

    def flag(self, key: str) -> bool:
        value = self.get(key)
        if value is not None and not isinstance(value, bool):
            raise self.wrong(key, f"{key} must be true or false, not {quoted(value)}")
        return value is True

    def integer(self, key: str, low: int, high: int, default: int | None = None) -> int:
        if key not in self._left and default is not None:
            return default
        value = self.get(key)
        return self.attempt(key, checked_integer, value, key, low, high)

    def choice(self, key: str, known: Iterable[str], default: str | None = "") -> str | None:
        if key not in self._left and default != "":
            return default
        if key not in self._left:
            raise self.wrong(key, f"{key} is missing")
        value, names = self.get(key), tuple(known)
        if not isinstance(value, str) or value not in names:
            raise self.wrong(key, f"{key} must be one of {', '.join(names)}, not {quoted(value)}")
        return value

    def names(self, key: str, known: Iterable[str], default: tuple[str, ...] = ()) -> tuple[str, ...]:
        if key not in self._left:
            return default
        value, names = self.get(key), tuple(known)
        if not isinstance(value, list):
            raise self.wrong(key, f"{key} must be a list of names, not {quoted(value)}")
        for one in value:
            if not isinstance(one, str) or one not in names:
                raise self.wrong(key, f"{key} must contain only {', '.join(names)}, not {quoted(one)}")
        return tuple(dict.fromkeys(value))

    def table(self, key: str) -> dict[str, Any]:
        value = self._left.pop(key, {})
        return self.attempt(key, checked_table, value, key)

    def numbers(self, key: str, known: Iterable[str]) -> dict[str, float]:
        """Return a table of positive numbers with known names."""
        found, names = {}, tuple(known)
        for name, value in self.table(key).items():
            if name not in names:
                raise self.wrong(key, f"{key} must contain only {', '.join(names)}, not {quoted(name)}")
            found[name] = self.attempt(key, checked_number, value, name, 0.0, 1e9)
        return found

    def points(self, key: str, value: object, reach: float = 1e9, unit: str = "") -> tuple[float, float]:
        """Return two numbers; if they are a range, they must be in ascending order."""
        pair = self.attempt(key, checked_list, value, key, 2)
        low, high = (self.attempt(key, checked_number, v, key, -reach, reach, unit) for v in pair)
        if key != "hand" and low >= high:
            raise self.wrong(
                key, f"{key} must go from a lower to a higher value, not from {low:g} to {high:g}"
            )
        return low, high

    def values(self, environment: Environment, before: Mapping[str, float]) -> dict[str, float]:
        """Return an environment's values: ``before``, with some of them replaced by the table "values"."""
        given = {**before, **self.table("values")}
        return self.attempt("values", environment.values, given)

    def records(self, key: str, make: Callable[["_Table"], Any]) -> tuple[Any, ...]:
        if key not in self._left:
            return ()
        value = self.get(key)
        found = []
        for one in self.attempt(key, checked_list, value, key):
            row = self.attempt(key, checked_table, one, key)
            part = _Table(self._reader, row, self.line_of(key), self._last)
            found.append(make(part))
            part.finish()
        return tuple(found)

    def finish(self) -> None:
        """Raise LessonError if an unknown key remains."""
        for key in self._left:
            raise self.wrong(key, f"the name {quoted(key)} is not known here")
