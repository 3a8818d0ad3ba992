"""The command that judges what a scene's simulated device must model: words, an object, a picture."""

import argparse
from collections.abc import Sequence

from hapkit_studio import environments as library
from hapkit_studio.analysis import fidelity as judge
from hapkit_studio.charts.fidelity import fidelity_figure, outcome_word, percent
from hapkit_studio.commands import base
from hapkit_studio.commands.base import Command, Result, option
from hapkit_studio.devices.simulated import TERMS

OPTIONS = (
    option("environment", nargs="*", metavar="ENV", help="keys or files; none: all"),
    option("--trust", action="store_true", help="execute files that you have read"),
    base.PLOT,
)


def fidelity(options: argparse.Namespace) -> Result:
    """Judge which terms each scene needs; draw the table where asked."""
    scenes = [base.environment_named(wanted, options.trust) for wanted in options.environment]
    scenes = scenes or list(library.discover().values())
    results = []
    for number, scene in enumerate(scenes, 1):
        results.append(
            judge.compute(scene, base.progress_line(f"scene {number} of {len(scenes)}, {scene.key}"))
        )
    written = base.drawn(options.plot, fidelity_figure, results)
    return base.with_files(_text(results), as_json(results), written)


def as_json(results: Sequence[judge.Fidelity]) -> dict:
    """Return one object: a row a cell, what each scene needs."""
    rows = []
    for effect in (e for result in results for e in (*result.effects, result.together)):
        row = {k: None if v != v else v for k, v in vars(effect).items()} | {"needed": effect.needed}
        for what in ("with", "without"):
            row[f"ns_per_simulated_s_{what}"] = row.pop(f"ns_{what}")
        rows.append(row)
    return {"rows": rows, "needs": {r.scene: list(r.needs) for r in results}}


def _text(results: Sequence[judge.Fidelity]) -> str:
    table = [_table(results)] if len(results) > 1 else []
    return "\n\n".join([*map(_details, results), *table, "\n".join(map(_summary, results))])


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


_HELP = "compute what a scene's simulated device must model, and what each term costs"
COMMAND = Command("fidelity", _HELP, fidelity, OPTIONS, 40)
