"""The command that charts speed against accuracy: a table with the front marked, an object, pictures."""

import argparse
from functools import partial

from hapkit_studio.analysis import accuracy as measure
from hapkit_studio.analysis.accuracy import words
from hapkit_studio.analysis.accuracy.plan import Accuracy, Sheet
from hapkit_studio.charts.accuracy import accuracy_figure
from hapkit_studio.commands.base import PLOT, Command, Result, drawn, option, progress_line, with_files
from hapkit_studio.dynamics.integrators import INTEGRATORS

CHARTS = "integrators, velocity, servo, friction"


OPTIONS = (
    option("chart", nargs="*", metavar="CHART", help=f"of {CHARTS}; none: all"),
    option("--scene", metavar="KEY", help="this scene alone"),
    option("--method", default="", choices=INTEGRATORS, help="whose motion is drawn; the default's"),
    PLOT,
)


def accuracy(options: argparse.Namespace) -> Result:
    """Measure error and cost of every method; draw the charts where asked."""
    draw = partial(accuracy_figure, method=options.method)
    found = measure.compute(options.chart, options.scene, progress=progress_line("scene"))
    return with_files(_text(found), _as_json(found), drawn(options.plot, draw, found))


def _as_json(found: Accuracy) -> dict:
    answers = [
        {
            "chart": sheet.chart,
            "scene": sheet.scene.key,
            "tolerance": sheet.scene.tolerance,
            "error_unit": sheet.scene.unit or "share",
            "reason": sheet.scene.reason,
            "cheapest": sheet.answer.cheapest.row() if sheet.answer.cheapest else None,
            "default": sheet.answer.default.row() if sheet.answer.default else None,
            "default_is_cheapest": sheet.answer.right,
            "answer": f"{words.sentence(sheet)} {words.verdict(sheet)}",
        }
        for sheet in found.sheets
    ]
    choices = [words.choice_row(choice) for chart in found.charts for choice in chart.choices]
    return {"rows": found.rows(), "answers": answers, "choices": choices, "seconds": found.seconds}


def _text(found: Accuracy) -> str:
    parts = []
    for chart in found.charts:
        parts += [_sheet(sheet) for sheet in chart.sheets]
        parts += [f"{chart.title}: {words.reason(choice)}" for choice in chart.choices]
    count = sum(len(sheet.points) for sheet in found.sheets)
    parts.append(
        f"{count} points in {found.seconds:.1f} s. Nothing beats what is marked *: the Pareto front."
    )
    return "\n\n".join(parts)


def _sheet(sheet: Sheet) -> str:
    """Return a scene's table: a line a point, the default marked."""
    scene, answer = sheet.scene, sheet.answer
    lines = [f"{sheet.chart} · {scene.title}", words.sentence(sheet), words.verdict(sheet)]
    lines.append(f"Tolerance: {words.tolerance_words(scene)}. {scene.reason}.")
    lines.append(f"  {'method':<22}{'step':>10}{'error':>14}{'per simulated s':>18}")
    for point in sheet.points:
        marks = ("* " if point.pareto else "  ") + ("default" if point is answer.default else "")
        error, cost = words.error_words(point.error, scene), words.cost_words(point.ns_per_simulated_s)
        line = f"  {point.label:<22}{words.step_words(point.step_s):>10}{error:>14}{cost:>18} {marks}"
        lines.append(line.rstrip())
    return "\n".join(lines)


COMMAND = Command("accuracy", "chart every method's error against its computing time", accuracy, OPTIONS, 60)
