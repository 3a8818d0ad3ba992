"""Time of the whole chart of speed against accuracy; its pictures, a file a chart."""

from dataclasses import replace
from pathlib import Path

from hapkit_studio.analysis import accuracy
from hapkit_studio.charts.accuracy import accuracy_figure
from tests.bench.frame import Row

NAME, ORDER = "accuracy", 45


def run(folder: Path | None = None) -> list[Row]:
    """Return the time of all charts, and how many defaults are the cheapest, or as cheap, that will do.

    Each is drawn into accuracy-<chart>.png where a folder is given.
    """
    found = accuracy.compute()
    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)
        for chart in found.charts:
            accuracy_figure(replace(found, charts=(chart,)), folder / f"accuracy-{chart.key}.png")
    choices = [choice for chart in found.charts for choice in chart.choices]
    count, right = len(choices), sum(choice.answer.tied for choice in choices)
    name = f"speed against accuracy, {len(found.rows())} points"
    return [
        Row(name, found.seconds, "s", target="< 60 s", ok=found.seconds < 60.0),
        Row("defaults that nothing as good undercuts", right, "", target=f"{count}", ok=right == count),
    ]
