"""The command that charts speed against accuracy: a table with the front marked, an object, pictures."""

import argparse

from hapkit_studio.analysis import accuracy as measure
from hapkit_studio.analysis.accuracy import words
from hapkit_studio.analysis.accuracy.plan import Accuracy, Sheet
from hapkit_studio.charts.accuracy import accuracy_figure
from hapkit_studio.commands.base import PLOT, Command, Result, drawn, option, progress_line, with_files

CHARTS = "integrators, velocity, servo, friction"


OPTIONS = (
    option("chart", nargs="*", metavar="CHART", help=f"of {CHARTS}; none: all"),
    option("--scene", metavar="KEY", help="this scene alone"),
    PLOT,
)


def accuracy(options: argparse.Namespace) -> Result:
    """Measure error and cost of every method; draw the charts where asked."""
    found = measure.compute(options.chart, options.scene, progress=progress_line("scene"))
    return with_files(_text(found), _as_json(found), drawn(options.plot, accuracy_figure, found))


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
    return {"rows": found.rows(), "answers": answers, "seconds": found.seconds}


def _text(found: Accuracy) -> str:
    parts = [_sheet(sheet) for sheet in found.sheets]
    right = sum(sheet.answer.right for sheet in found.sheets)
    count = sum(len(sheet.points) for sheet in found.sheets)
    parts.append(
        f"{count} points in {found.seconds:.1f} s. Nothing beats what is marked *: the Pareto front. "
        f"The default is the cheapest within the tolerance in {right} of {len(found.sheets)} scenes."
    )
    return "\n\n".join(parts)


def _sheet(sheet: Sheet) -> str:
    """Return a scene's table: a line a point, the default marked."""
    scene, answer = sheet.scene, sheet.answer
    lines = [f"{sheet.chart} · {scene.title}", words.sentence(sheet), words.verdict(sheet)]
    lines.append(f"Tolerance: {scene.reason}.")
    lines.append(f"  {'method':<22}{'step':>10}{'error':>14}{'per simulated s':>18}")
    for point in sheet.points:
        marks = ("* " if point.pareto else "  ") + ("default" if point is answer.default else "")
        error, cost = words.error_words(point.error, scene.unit), words.cost_words(point.ns_per_simulated_s)
        line = f"  {point.label:<22}{words.step_words(point.step_s):>10}{error:>14}{cost:>18} {marks}"
        lines.append(line.rstrip())
    return "\n".join(lines)


COMMAND = Command("accuracy", "chart every method's error against its computing time", accuracy, OPTIONS, 60)
