"""The command that demonstrates limits of methods: trials just inside and just outside each limit."""

import argparse
import textwrap
from pathlib import Path

from hapkit_studio.analysis.failures import failures, named
from hapkit_studio.analysis.failures.base import Shown, Try, as_json, show, try_json
from hapkit_studio.charts.failures import failure_figure
from hapkit_studio.charts.plane import plane_figure
from hapkit_studio.commands.base import Command, Result, drawn, key_values, option, progress_line, with_files
from hapkit_studio.errors import ParameterError
from hapkit_studio.formatting import on_screen

_WIDTH = 100


OPTIONS = (
    option("failure", nargs="?", metavar="KEY", help="one of the failures; none: a table of all"),
    option(
        "-p",
        dest="given",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="a condition of the failure",
    ),
    option("--at", type=float, metavar="VALUE", help="also try the knob at this value, SI"),
    option("--plot", metavar="PATH", help="draw it; without KEY one picture for each"),
    option("--plane", action="store_true", help="draw the failure's plane of dimensionless numbers instead"),
)


def run(options: argparse.Namespace) -> Result:
    """Try one failure, or all failures, on both sides of the limit; draw the results if requested."""
    if options.failure is None and (options.given or options.at is not None):
        raise ParameterError("Options and --at belong to one failure: name it, e.g. break-it sampled_spring.")
    planes = [failure.key for failure in failures().values() if failure.plane]
    if options.plane and options.failure not in planes:
        raise ParameterError(f"--plane belongs to one of {', '.join(planes)}: name it before --plane.")
    chosen = [named(options.failure)] if options.failure else list(failures().values())
    given = key_values(options.given, "An option", "rate=1000")
    results: list[Shown] = []
    written: list[str] = []
    for failure in chosen:
        report = progress_line(f"{failure.key}")
        results.append(
            show(
                failure,
                given,
                chart=bool(options.plot) and not options.plane,
                plane=options.plane,
                progress=report,
            )
        )
        path = options.plot
        if path and not options.failure:
            path = str(Path(path).with_stem(f"{Path(path).stem}-{failure.key}"))
        written += drawn(path, plane_figure if options.plane else failure_figure, results[-1])
    tried = [Try(options.at, chosen[0].try_at(options.at, given))] if options.at is not None else []
    text = _details(results[0], tried) if options.failure else _table(results)
    found = {"failures": [as_json(r) for r in results], "tried": [try_json(t) for t in tried]}
    return with_files(text, found, written)


def _verdict(one: Try | None) -> str:
    assert one is not None
    return f"{'holds' if one.evidence.holds else 'fails'}: {one.evidence.text}"


def _limit(shown: Shown) -> str:
    knob = shown.failure.knob
    assert shown.limit is not None
    return f"{knob.label[0].lower()}{knob.label[1:]} {on_screen(shown.limit, knob.unit)}"


def _table(results: list[Shown]) -> str:
    """Return a block for each failure: its theoretical limit, and the results inside and outside."""
    lines = []
    for shown in results:
        margin = f"{100.0 * shown.failure.margin:g} %"
        lines += [
            f"{shown.failure.key:<18}{shown.failure.title}",
            f"{'':<18}limit: {_limit(shown)}   [{shown.failure.formula}]",
            f"{'':<18}{margin:>4} inside  {_verdict(shown.inside)}",
            f"{'':<18}{margin:>4} outside {_verdict(shown.outside)}",
        ]
    right = sum(shown.as_theory_says for shown in results)
    return "\n".join([*lines, "", f"{right} of {len(results)} hold inside their limit and fail outside."])


def _details(shown: Shown, tried: list[Try]) -> str:
    failure = shown.failure
    lines = [failure.title, "", *textwrap.wrap(failure.explanation, _WIDTH), "", failure.formula]
    pairs = [f"{p.key}={p.text(shown.case[p.key])}" for p in failure.options]
    lines += [f"with {', '.join(pairs)}", f"limit: {_limit(shown)}"]
    for one in filter(None, (shown.inside, shown.outside, *tried)):
        lines.append(f"{on_screen(one.value, failure.knob.unit)} {_verdict(one)}")
    return "\n".join(lines)


COMMAND = Command("break-it", "where methods fail: inside and outside each limit", run, OPTIONS, 57)
