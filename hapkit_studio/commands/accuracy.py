"""Speed and accuracy: tables, one object, a picture; of methods, of scenes, or of what scenes need."""

import argparse
from functools import partial
from typing import Any

from hapkit_studio import environments as library
from hapkit_studio.analysis import accuracy as measure
from hapkit_studio.analysis.accuracy import Accuracy, words
from hapkit_studio.analysis.accuracy.needs import Needs
from hapkit_studio.analysis.accuracy.plan import Sheet, front
from hapkit_studio.analysis.accuracy.scene import PARTS, Question, SceneResult
from hapkit_studio.charts.accuracy import accuracy_figure, felt_words
from hapkit_studio.commands import base
from hapkit_studio.commands.base import Command, Result, option, progress_line, with_files
from hapkit_studio.devices.simulated import TERMS
from hapkit_studio.errors import ParameterError
from hapkit_studio.formatting import plain

CHARTS = "integrators, contact, velocity, servo, friction"
OPTIONS = (
    option("environment", nargs="*", metavar="ENV", help="scenes: keys or files; none: all"),
    option("--methods", nargs="*", metavar="CHART", help=f"charts of methods instead: {CHARTS}; none: all"),
    option("--needs", action="store_true", help="what the scenes need of the device instead"),
    option("--board", action="store_true", help="draw methods over the board's cycles"),
    base.PARAMETER,
    base.TRUST,
    base.PLOT,
)


def run(options: argparse.Namespace) -> Result:
    """Measure methods, scenes or needs; draw them where asked."""
    if options.parameter and (len(options.environment) != 1 or options.needs):
        raise ParameterError("Parameters are of one environment: name it.")
    scenes = [base.environment_named(wanted, options.trust) for wanted in options.environment]
    scenes = scenes or list(library.discover().values())
    if options.methods is not None:
        found = measure.of_methods(options.methods, progress_line("chart"))
    elif options.needs:
        found = measure.of_needs(scenes, progress_line("scene"))
    else:
        given = base.key_values(options.parameter)
        questions = [Question(e, e.values(given)) for e in scenes]
        found = measure.of_scenes(questions, progress_line("scene"))
    draw = partial(accuracy_figure, board=options.board)
    tables = [*map(_sheet, found.sheets), *map(_scene, found.scenes), *map(_needs, found.needs)]
    return with_files("\n\n".join(tables), as_json(found), base.drawn(options.plot, draw, found))


def as_json(found: Accuracy) -> dict:
    """Return what was found as one object."""
    return {
        "methods": [_sheet_json(sheet) for sheet in found.sheets],
        "scenes": [_scene_json(scene) for scene in found.scenes],
        "needs": [plain(one) for one in found.needs],
    }


def _sheet_json(sheet: Sheet) -> dict[str, Any]:
    winners = {str(t): sheet.winners(t) for t in sheet.scene.tolerances}
    orders = {method: sheet.order(method) for method in sheet.methods}
    return plain({**plain(sheet), "rows": sheet.points, "orders": orders, "winners": winners})


def _scene_json(scene: SceneResult) -> dict[str, Any]:
    answers = {}
    for place in (place.name for place in scene.question.places):
        pair = {"recommended": scene.recommended(place), "default": scene.default(place)}
        rows = {key: one.row() if one else None for key, one in pair.items()}
        answers[place] = {**rows, "answer": f"{scene.sentence(place)} {scene.reason(place)}".strip()}
    asked = {"scene": scene.question.environment.key, "values": dict(scene.question.values)}
    found = {"rows": [o.row() for o in scene.options], "answers": answers, "refused": dict(scene.refused)}
    return plain({**asked, **found, "ideal_Hz": scene.ideal_rate})


def _sheet(sheet: Sheet) -> str:
    """Return a chart's winners, and a line a point; * marks the Pareto front."""
    lines = [f"{sheet.chart} · {sheet.scene.title}", words.sentence(sheet)]
    for tolerance in sheet.scene.tolerances:
        within = words.tolerance_words(tolerance, sheet.scene)
        said = f"  error within {within}: {words.winner_words(sheet, tolerance)}"
        board = f"; on the board {words.winner_words(sheet, tolerance, True)}" if sheet.boarded else ""
        lines.append(said + board)
    best = front(sheet.points)
    for p in sheet.points:
        costs = f"{words.cost_words(p):>10}{words.cost_words(p, True):>22}{' *' * (p in best)}"
        error = words.error_words(p.error, sheet.scene)
        lines.append(f"  {words.name_words(p, sheet):<40}{error:>14}{costs}")
    return "\n".join(lines)


def _scene(scene: SceneResult) -> str:
    """Return a scene's answers, then a line an option."""
    lines = [scene.question.environment.title]
    for place in (place.name for place in scene.question.places):
        lines += filter(None, (scene.sentence(place), scene.reason(place)))
        heads = ("JND", *PARTS, "Hz", "N/m")
        lines.append(f"  {'':<18}" + "".join(f"{head:>10}" for head in heads))
        for o in scene.at(place):
            marks = {"recommended": scene.recommended(place), "default": scene.default(place)}
            marked = ", ".join(word for word, one in marks.items() if o is one)
            numbers = (
                "".join(f"{one:>10.2f}" for one in (o.error, *o.parts)) + f"{o.rate:>10,.0f}{o.limit:>10,.0f}"
            )
            lines.append(f"  {o.method or 'as set':<18}{numbers}  {marked}".rstrip())
    return "\n".join([*lines, *scene.refused.values()])


def _needs(found: Needs) -> str:
    """Return the gains without law terms, then a line a term; * needed, † only the most sensitive feel it."""
    lines = [f"{found.scene} needs {', '.join(found.needs) or 'none of them'}"]
    lines += [f"  {term.words}" for term in found.law]
    lines.append(
        f"  {'without':<16}{'JND':>7}  {'sense, hand motion':<36}{'noticeable':<18}{'limit change':>16}"
    )
    for e in found.effects:
        mark = "*" if e.term in found.needs else "†" if e.differs else " "
        where = f"{e.sense}, {e.hand}" if e.felt else ""
        cells = f"{felt_words(e.felt):>7}{mark} {where:<36}{e.since_words:<18}{e.gain_words:>16}"
        lines.append(f"  {TERMS[e.term].word:<16}{cells}".rstrip())
    return "\n".join(lines)


_HELP = "say how far a scene is from the ideal and which method to use; what methods cost; what scenes need"
COMMAND = Command("accuracy", _HELP, run, OPTIONS, 60, aliases=("speed-accuracy", "chain"))
