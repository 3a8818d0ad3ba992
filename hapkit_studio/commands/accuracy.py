"""The command for speed and accuracy of methods and scenes, and for the model terms that scenes need."""

import argparse
from dataclasses import replace
from functools import partial
from typing import Any

from hapkit_studio import environments as library
from hapkit_studio.analysis import accuracy as measure
from hapkit_studio.analysis.accuracy import Accuracy
from hapkit_studio.analysis.accuracy.needs import Needs
from hapkit_studio.analysis.accuracy.plan import Sheet, front
from hapkit_studio.analysis.accuracy.scene import PARTS, Option, SceneRequest, SceneResult
from hapkit_studio.analysis.perception import FORCE_SHARE
from hapkit_studio.charts.accuracy import EFFECT_COLUMNS, accuracy_figure, option_columns, winner_columns
from hapkit_studio.columns import Column, text_lines
from hapkit_studio.commands import base
from hapkit_studio.commands.base import Command, Result, option, progress_line, with_files
from hapkit_studio.devices.simulated import TERMS
from hapkit_studio.errors import ParameterError
from hapkit_studio.formatting import plain
from hapkit_studio.lessons.experiments import own_threshold

FORMER_NEEDS = "fidelity"  # former name of ``accuracy --needs``, kept for one release
CHARTS = "integrators, contact, velocity, servo, friction"
OPTIONS = (
    option("environment", nargs="*", metavar="ENV", help="scenes: keys or files; default: all"),
    option(
        "--methods", nargs="*", metavar="CHART", help=f"charts of methods instead: {CHARTS}; default: all"
    ),
    option("--needs", action="store_true", help="show which device terms the scenes need instead"),
    option(
        "--thresholds",
        metavar="SESSION",
        help="for --needs: your own force threshold, from your comparisons",
    ),
    option("--board", action="store_true", help="plot methods over the board's cycles"),
    base.PARAMETER,
    base.TRUST,
    base.PLOT,
)


def run(options: argparse.Namespace) -> Result:
    """Measure methods, scenes or the terms that scenes need; draw the results if requested."""
    needs = options.needs or options.called == FORMER_NEEDS
    if options.parameter and needs:
        raise ParameterError("--needs takes each scene's default parameters: leave out -p.")
    if options.parameter and len(options.environment) != 1:
        raise ParameterError("Parameters belong to one environment: name it.")
    if options.thresholds and not needs:
        raise ParameterError("--thresholds belongs to --needs: a scene is judged by the literature's.")
    scenes = [base.environment_named(wanted, options.trust) for wanted in options.environment]
    scenes = scenes or list(library.discover().values())
    if options.methods is not None:
        found = measure.of_methods(options.methods, progress_line("chart"))
    elif needs:
        share = own_threshold(options.thresholds).weber.value if options.thresholds else FORCE_SHARE
        found = measure.of_needs(scenes, progress_line("scene"), share)
    else:
        given = base.key_values(options.parameter)
        questions = [SceneRequest(e, e.values(given)) for e in scenes]
        found = measure.of_scenes(questions, progress_line("scene"))
    draw = partial(accuracy_figure, board=options.board)
    tables = [*map(_sheet, found.sheets), *map(_scene, found.scenes), *map(_needs, found.needs)]
    return with_files("\n\n".join(tables), as_json(found), base.drawn(options.plot, draw, found))


def as_json(found: Accuracy) -> dict:
    """Return the results as one object."""
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
    """Return a chart's best methods for each tolerance, and a line per point; * marks the Pareto front."""
    cheapest, within = winner_columns(sheet)
    columns = [within, cheapest]
    if sheet.boarded:
        on_board, _ = winner_columns(sheet, board=True)
        columns.append(replace(on_board, title="On the board"))
    best = front(sheet.points)
    points = (
        Column("Method", sheet.name_text, right=False),
        Column("Error", lambda p: sheet.scene.error_text(p.error)),
        Column("Cost", lambda p: p.cost_text()),
        Column("Cost on the board", lambda p: p.cost_text(board=True)),
        Column("", lambda p: "*" * (p in best), right=False),
    )
    return "\n".join([
        f"{sheet.chart} · {sheet.scene.title}", sheet.sentence(),
        *text_lines(columns, sheet.scene.tolerances, "  "), *text_lines(points, sheet.points, "  "),
    ])  # fmt: skip


def _scene(scene: SceneResult) -> str:
    """Return a scene's recommendations, and then one line per option."""
    lines = [scene.question.environment.title]
    parts = (
        Column(head, lambda o, index=index: f"{o.parts[index]:.2f}" if o.parts else "–")  # type: ignore[misc]
        for index, head in enumerate(PARTS)
    )
    columns = (
        *option_columns(scene),
        *parts,
        Column("Rate", lambda o: f"{o.rate:,.0f}", unit="Hz"),
        Column("Stable up to", lambda o: f"{o.limit:,.0f}", unit="N/m"),
        Column("", partial(_option_marks, scene), right=False),
    )
    for place in (place.name for place in scene.question.places):
        lines += filter(None, (scene.sentence(place), scene.reason(place)))
        lines += text_lines(columns, scene.at(place), "  ")
    lines += (f"{method}: {why}".removeprefix(": ") for method, why in scene.refused.items())
    return "\n".join(lines)


def _option_marks(scene: SceneResult, option: Option) -> str:
    marks = {"recommended": scene.recommended(option.place), "default": scene.default(option.place)}
    return ", ".join(word for word, one in marks.items() if one is option)


def _needs(found: Needs) -> str:
    """Return the needed terms, and a line per term; * means needed, † felt by only a few people."""
    columns = (
        Column("Without", lambda e: TERMS[e.term].word, right=False),
        *EFFECT_COLUMNS,
        Column("", lambda e: "*" if e.term in found.needs else "†" * e.differs, right=False),
    )
    return "\n".join([
        f"{found.scene} needs {', '.join(found.needs) or 'none of them'}",
        *(f"  {term.text}" for term in found.law),
        *text_lines(columns, found.effects, "  "),
    ])  # fmt: skip


_HELP = "say how far a scene is from the ideal and which method to use; what methods cost; what scenes need"
COMMAND = Command("accuracy", _HELP, run, OPTIONS, 60, aliases=("speed-accuracy", "chain", FORMER_NEEDS))
