"""The command that judges what a scene's simulated device must model: words, an object, a picture."""

import argparse
from collections.abc import Sequence

from hapkit_studio import environments as library
from hapkit_studio.analysis import fidelity as judge
from hapkit_studio.charts.fidelity import fidelity_figure, outcome_word, percent
from hapkit_studio.commands.base import (
    PLOT,
    Command,
    Result,
    drawn,
    environment_named,
    option,
    progress_line,
    with_files,
)
from hapkit_studio.devices.simulated import TERMS

OPTIONS = (
    option("environment", nargs="*", metavar="ENV", help="keys or files; none: all"),
    option("--trust", action="store_true", help="execute files that you have read"),
    PLOT,
)


def fidelity(options: argparse.Namespace) -> Result:
    """Judge which terms each scene needs; draw the table where asked."""
    scenes = [environment_named(wanted, options.trust) for wanted in options.environment]
    scenes = scenes or list(library.discover().values())
    results = []
    for number, scene in enumerate(scenes, 1):
        results.append(judge.compute(scene, progress_line(f"scene {number} of {len(scenes)}, {scene.key}")))
    return with_files(_text(results), as_json(results), drawn(options.plot, fidelity_figure, results))


def as_json(results: Sequence[judge.Fidelity]) -> dict:
    """Return one object: a row a cell, what each scene needs."""
    rows = [
        {
            "scene": e.scene,
            "term": e.term,
            "change": e.change,
            "outcome": e.outcome,
            "hand": e.hand,
            "needed": e.needed,
            "ns_per_simulated_s_with": e.ns_with,
            "ns_per_simulated_s_without": e.ns_without,
        }
        for result in results
        for e in (*result.effects, result.together)
    ]
    rows = [{k: None if v != v else v for k, v in row.items()} for row in rows]
    return {"rows": rows, "needs": {r.scene: list(r.needs) for r in results}}


def _text(results: Sequence[judge.Fidelity]) -> str:
    parts = [_details(result) for result in results]
    parts += [_table(results)] if len(results) > 1 else []
    parts += ["\n".join(_summary(result) for result in results)]
    return "\n\n".join(parts)


def _table(results: Sequence[judge.Fidelity]) -> str:
    """Return scene × term: the largest change in %, * where the term is needed."""
    lines = [f"{'':<20}" + "".join(f"{key:>14}" for key in TERMS)]
    for result in results:
        cells = [percent(e.change) + ("*" if e.needed else " ") for e in result.effects]
        lines.append(f"{result.scene:<20}" + "".join(f"{cell:>14}" for cell in cells))
    return "\n".join(lines) + "\n* needed: an outcome moves by more than 2 % of its scale without it"


def _details(result: judge.Fidelity) -> str:
    """Return a scene's terms, a line each."""
    lines = [f"{result.scene:<14}{'change':>9}  {'most in':<32}{'µs per simulated second':>24}"]
    for e in result.effects:
        where = f"{outcome_word(e.outcome)} under {e.hand}" if e.change else ""
        cost = "" if e.change is None else f"{1e-3 * e.ns_with:.0f} → {1e-3 * e.ns_without:.0f}"
        mark = "*" if e.needed else " "
        lines.append(f"  {e.term:<12}{percent(e.change):>8}{mark}  {where:<32}{cost:>24}")
    return "\n".join(lines)


def _summary(result: judge.Fidelity) -> str:
    whole = result.together
    share = f"{whole.ns_without / whole.ns_with:.2f} of the cost"
    words = f"{result.scene} needs {', '.join(result.needs) or 'none of them'}"
    return f"{words}; the others together change {percent(whole.change)}, {share} without them"


COMMAND = Command(
    "fidelity",
    "compute what a scene's simulated device must model, and what each term costs",
    fidelity,
    OPTIONS,
    order=40,
)
