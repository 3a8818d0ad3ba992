"""Time of the whole chart of speed against accuracy; its pictures, a file a chart."""

from dataclasses import replace
from pathlib import Path

from hapkit_studio.analysis import accuracy
from hapkit_studio.charts.accuracy import accuracy_figure
from tests.bench.frame import Row

NAME = "accuracy"
ORDER = 45
MOST_SECONDS = 60.0


def pictures(found: accuracy.Accuracy, folder: Path) -> list[Path]:
    """Draw each chart into accuracy-<chart>.png in a folder; return the files."""
    folder.mkdir(parents=True, exist_ok=True)
    made = []
    for chart in found.charts:
        made.append(folder / f"accuracy-{chart.key}.png")
        accuracy_figure(replace(found, charts=(chart,)), made[-1])
    return made


def rows(found: accuracy.Accuracy) -> list[Row]:
    """Return the time of all charts, and in how many scenes the default is the cheapest that will do."""
    count = len(found.sheets)
    right = sum(sheet.answer.right for sheet in found.sheets)
    points = len(found.rows())
    name = f"speed against accuracy, {points} points"
    return [
        Row(name, found.seconds, "s", target="< 60 s", ok=found.seconds < MOST_SECONDS),
        Row("scenes whose default is right", right, "", target=f"{count}", ok=right == count),
    ]


def run(folder: Path | None = None) -> list[Row]:
    """Compute every chart; draw them where a folder is given."""
    found = accuracy.compute()
    if folder is not None:
        pictures(found, folder)
    return rows(found)
