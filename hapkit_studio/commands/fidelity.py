"""The command that judges what a scene's simulated device must model: words, an object, a picture."""

import argparse
from collections.abc import Sequence

from hapkit_studio import environments as library
from hapkit_studio.analysis import fidelity as judge
from hapkit_studio.charts.fidelity import fidelity_figure, jnd, percent
from hapkit_studio.commands import base
from hapkit_studio.commands.base import Command, Result, option
from hapkit_studio.devices.simulated import TERMS
from hapkit_studio.formatting import plain

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
    for effect, needs in (
        (e, result.needs) for result in results for e in (*result.effects, result.together)
    ):
        row = plain(vars(effect)) | {"needed": effect.term in needs}
        for what in ("with", "without"):
            row[f"ns_per_simulated_s_{what}"] = row.pop(f"ns_{what}")
        rows.append(row)
    return {"rows": rows, "needs": {r.scene: list(r.needs) for r in results}}


def _text(results: Sequence[judge.Fidelity]) -> str:
    table = [_table(results)] if len(results) > 1 else []
    return "\n\n".join([*map(_details, results), *table, "\n".join(map(_summary, results))])


def _table(results: Sequence[judge.Fidelity]) -> str:
    """Return scene × term: the most that is felt in JND, * where the term is needed; what both rules need."""
    lines = [f"{'':<20}" + "".join(f"{key:>14}" for key in TERMS)]
    for result in results:
        cells = [jnd(e.felt) + ("*" if e.term in result.needs else " ") for e in result.effects]
        lines.append(f"{result.scene:<20}" + "".join(f"{cell:>14}" for cell in cells))
    of = sum(len(result.effects) for result in results)
    needed, moves = sum(len(r.needs) for r in results), sum(e.moves for r in results for e in r.effects)
    lines.append(
        f"* needed: more than one JND is felt without it, or without several: {needed} of {of} terms"
    )
    return "\n".join(lines) + f"\nby the rule of 2 % of an outcome's scale {moves} would be"


def _details(result: judge.Fidelity) -> str:
    """Return a scene's terms, a line each."""
    lines = [f"{result.scene:<14}{'JND':>9}  {'most in':<32}{'change':>8}{'µs per simulated second':>26}"]
    for e in result.effects:
        where = f"{e.sense} under {e.hand}" if e.felt else ""
        cost = "" if e.felt is None else f"{1e-3 * e.ns_with:.0f} → {1e-3 * e.ns_without:.0f}"
        mark = "*" if e.term in result.needs else " "
        lines.append(f"  {e.term:<12}{jnd(e.felt):>8}{mark} {where:<32}{percent(e.change):>8}{cost:>26}")
    return "\n".join(lines)


def _summary(result: judge.Fidelity) -> str:
    whole = result.together
    share = f"{whole.ns_without / whole.ns_with:.2f} of the cost"
    words = f"{result.scene} needs {', '.join(result.needs) or 'none of them'}"
    return f"{words}; without the others {jnd(whole.felt)} JND are felt, at {share}"


_HELP = "compute what a scene's simulated device must model, and what each term costs"
COMMAND = Command("fidelity", _HELP, fidelity, OPTIONS, 40)
