"""The class ``Command``, and options that several commands share."""

import argparse
import contextlib
import os
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hapkit_studio import environments
from hapkit_studio.charts.style import check_picture
from hapkit_studio.dynamics.estimators import ESTIMATORS, Spec
from hapkit_studio.dynamics.hand import ALL_GRIPS
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import LawError, ParameterError
from hapkit_studio.files import is_special
from hapkit_studio.formatting import compact, printable
from hapkit_studio.workshop import reading, trial
from hapkit_studio.workshop.source import Source, is_trusted, read, trust_source

QUIET_SECONDS = 1.0
_BAR = 20


Option = tuple[tuple[str, ...], dict[str, Any]]


def option(*names: str, **how: Any) -> Option:
    """Return arguments for ``ArgumentParser.add_argument``."""
    return names, how


ENVIRONMENT = option("environment", help="an environment's key, or a Python file: my_env.py")
TRUST = option("--trust", action="store_true", help="allow a file that you have read to be executed")
PARAMETER = option("-p", "--parameter", action="append", default=[], metavar="KEY=VALUE")
PLOT = option("--plot", metavar="PATH", help="write a picture")


@dataclass(frozen=True)
class Result:
    """The result of a command: text for a person, one object for ``--json``, and the exit code."""

    text: str
    as_json: dict
    code: int = 0


def with_files(text: str, as_json: dict, written: Sequence[str], code: int = 0) -> Result:
    """Return a result that also lists the written files."""
    lines = [text, *(f"wrote {path}" for path in written)]
    return Result("\n".join(lines), {**as_json, "written": list(written)}, code)


def drawn(plot: str | None, draw: Callable[[Any, str], object], found: Any) -> list[str]:
    """Draw a result if a figure is requested; return the written files."""
    if not plot:
        return []
    draw(found, plot)
    return [plot]


@dataclass(frozen=True)
class Command:
    """A command: its options in addition to ``--json``, and ``run``; ``aliases`` are former names."""

    name: str
    help: str
    run: Callable[[argparse.Namespace], Result]
    options: Sequence[Option] = ()
    order: int = 100
    aliases: Sequence[str] = ()


def span(seconds: float) -> str:
    """Format a duration with few digits, as in "40 s", "3 min" or "2.5 h"."""
    size, unit = next((u for u in ((3600.0, "h"), (60.0, "min")) if seconds >= 1.5 * u[0]), (1.0, "s"))
    return f"{compact(seconds / size, 2)} {unit}"


def progress_line(what: str) -> Callable[[int, int], None]:
    """Return a progress callback (done, of) that updates one line on a terminal, for long tasks only."""
    begin, first = time.monotonic(), list[int]()

    def report(done: int, of: int) -> None:
        first[:] = first or [done]  # the speed excludes cells that an earlier run computed
        spent, new = time.monotonic() - begin, done - first[0]
        if spent < QUIET_SECONDS or not sys.stderr.isatty():
            return
        last = done >= of
        left = f", {span(spent * (of - done) / new)} left" if new else ""
        line = f"{what}: {'█' * (_BAR * done // of):░<{_BAR}} {done:,} of {of:,}{left}"
        print(f"\r{'' if last else line:<79}", end="\r" if last else "", file=sys.stderr, flush=True)

    return report


ESTIMATOR_HELP = f"{', '.join(ESTIMATORS)}; options as iir:cutoff=20"


def key_values(
    pairs: Sequence[str], what: str = "A parameter", like: str = "stiffness=400"
) -> dict[str, object]:
    """Return {key: number or word} of KEY=VALUE pairs; raise ParameterError for an invalid pair."""
    found: dict[str, object] = {}
    for pair in pairs:
        key, equals, value = pair.partition("=")
        if not equals or not key or not value:
            raise ParameterError(f"{what} has the form KEY=VALUE, e.g. {like}, not {pair!r}.")
        try:
            found[key] = float(value)
        except ValueError:
            found[key] = value
    return found


def numbers(text: str, what: str, unit: str, like: str) -> tuple[float, ...]:
    """Return the numbers in a text such as ``0,1,2``; raise ParameterError for an invalid number."""
    try:
        return tuple(float(word) for word in text.split(","))
    except ValueError:
        raise ParameterError(f"{what} are numbers in {unit} as {like}, not {text!r}.") from None


def estimator_spec(text: str) -> Spec:
    """Return the estimator in ``iir`` or ``iir:cutoff=20``; raise ParameterError for an invalid option."""
    name, colon, options = text.partition(":")
    if not colon:
        return name
    numbers = key_values(options.split(","), "An option", "cutoff=20")
    for key, value in numbers.items():
        if not isinstance(value, float):
            raise ParameterError(f"The estimator's {key} must be a number, not {value!r}.")
    return name, numbers  # type: ignore[return-value]


SETTING = {
    "mass": ("kg", "of the handle"),
    "viscous": ("N·s/m", "the handle's own damping"),
    "coulomb": ("N", "the handle's friction"),
    "quantum": ("m", "the sensor's steps"),
    "rate": ("Hz", "of the loop"),
    "delay": ("s", "from a sample to its force"),
}


_USUAL = LoopSettings()
SETTING_OPTIONS = (
    *(
        option(f"--{name}", type=float, metavar=unit, help=f"{label}; {getattr(_USUAL, name):g}")
        for name, (unit, label) in SETTING.items()
    ),
    option("--estimator", metavar="NAME", help=ESTIMATOR_HELP),
    option("--hand", metavar="GRIP", help=", ".join(ALL_GRIPS)),
    option("--controller", action="store_true", help="with the passivity controller"),
)
"""Options of a LoopSettings; an option that is not given is None."""


def of_options(options: argparse.Namespace, names: Sequence[str]) -> dict[str, Any]:
    """Return the given options by name; parse the estimator, and raise ParameterError if it is invalid."""
    found = {name: getattr(options, name) for name in names if getattr(options, name) is not None}
    if "estimator" in found:
        found["estimator"] = estimator_spec(found["estimator"])
    return found


def setting_of(options: argparse.Namespace) -> LoopSettings:
    """Return the LoopSettings of the given options; raise ParameterError for an invalid one."""
    given = of_options(options, (*SETTING, "estimator", "hand"))
    return LoopSettings(**given, controller=options.controller)


_OUTPUTS = ("csv", "plot")
_PICTURE = ".png"


def check_outputs(options: argparse.Namespace) -> None:
    """Raise ParameterError if --csv or --plot cannot be written; a figure without a suffix is a PNG."""
    for name in _OUTPUTS:
        given = getattr(options, name, None)
        if given is None:
            continue
        path = Path(given)
        if not given or path.is_dir():
            raise ParameterError(f"--{name} takes the path of a file, not {given!r}.")
        if not path.parent.is_dir():
            raise ParameterError(f"--{name}: there is no folder {path.parent}. Create it, or choose another.")
        if not os.access(path if path.exists() else path.parent, os.W_OK):
            raise ParameterError(f"--{name}: you may not write {path}. Name another file.")
        if name == "plot":
            check_picture(given)
            bare = not path.suffix and not is_special(path)
            setattr(options, name, given + _PICTURE if bare else given)


YES = ("y", "yes")


_SKETCHES = (".ino", ".pde", ".c", ".cpp", ".h")


def environment_named(wanted: str, trusting: bool) -> Environment:
    """Return an environment by its key or its Python file; raise ParameterError or LawError if it is invalid.

    An untrusted file is shown, and is executed only after consent at the terminal or with ``trusting``.
    """
    file = Path(wanted).expanduser().absolute()
    if file.suffix in _SKETCHES:
        raise ParameterError(
            f"{file.name} is an Arduino sketch: upload it with the Arduino IDE. This command takes an "
            f"environment's key, as wall, or its Python file, as {file.stem}.py."
        )
    if file.suffix != ".py":
        return environments.named(wanted)
    try:
        source = read(file)
        _consent(source, trusting)
        _try(source)
        return reading.load_source(source)
    except LawError as error:
        text = reading.without_line(error)
        if error.line:
            text = f"{file.name}, line {error.line}: {text}"
        elif file.name not in text:
            text = f"{file.name}: {text}"
        raise LawError(text) from None


def _consent(source: Source, trusting: bool) -> None:
    """Raise LawError unless the user allows that a file is executed."""
    if is_trusted(source):
        return
    if not trusting:
        if not (sys.stdin and sys.stdin.isatty() and sys.stderr.isatty()):
            raise LawError("not executed without your consent: read it, then pass --trust")
        print(printable(source.text), file=sys.stderr)
        question = f"Execute {source.path.name} as shown above? [y/N] "
        print(question, end="", file=sys.stderr, flush=True)
        if sys.stdin.readline().strip().lower() not in YES:
            raise LawError("not executed")
    with contextlib.suppress(OSError):  # if the consent cannot be stored, the next run asks again
        trust_source(source)


def _try(source: Source) -> None:
    """Raise LawError unless a file passes its trial or has passed it before."""
    if trial.has_passed(source):
        return
    verdict = trial.check(source)
    trial.remember(source, verdict.ok)
    for problem in verdict.problems:
        raise LawError(problem.text, problem.line)
