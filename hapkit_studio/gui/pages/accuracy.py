"""Speed against accuracy: what each method's error costs, which the scene should use, and whether it does."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from PySide6.QtCore import QSignalBlocker, Qt
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QComboBox

from hapkit_studio.analysis import accuracy
from hapkit_studio.analysis.accuracy import words
from hapkit_studio.analysis.accuracy.plan import Accuracy, Chart, Point, Sheet
from hapkit_studio.charts.accuracy import AccuracyAxes, accuracy_figure, computer, draw, marker_and_color
from hapkit_studio.formatting import significant
from hapkit_studio.gui.pages.base import View
from hapkit_studio.gui.pages.drawing import sign
from hapkit_studio.gui.pages.measuring import MeasuringPage
from hapkit_studio.gui.pages.table import Column
from hapkit_studio.gui.widgets.parts import hint, keep_size_when_hidden
from hapkit_studio.gui.widgets.segmented import Segmented

if TYPE_CHECKING:
    from matplotlib.backend_bases import MouseEvent

    from hapkit_studio.gui.live.live import Live
    from hapkit_studio.gui.studio import Studio

CHARTS = (
    ("integrators", "Integrators"),
    ("velocity", "Velocity"),
    ("servo", "Servo rate"),
    ("friction", "Friction"),
)


def columns(sheet: Sheet) -> tuple[Column, ...]:
    """Return the columns of the points that compete: what is chosen between, cost, error in one unit."""
    scene, default = sheet.scene, sheet.answer.default
    head = f"{'Of limit' if scene.goal else 'Error'}\n{words.unit(scene)[1]}"

    def cost(point: Point) -> str:
        return significant(1e-3 * point.ns_per_simulated_s)

    return (
        Column(
            "Rate" if scene.step_s is None else "Method", lambda p: words.name_words(scene, p), right=False,
            sign=lambda p: sign(*marker_and_color(p.method)),
            token=lambda p: "accent" if p is default else "ink",
        ),
        Column("µs\nper s", cost, lambda p: p.ns_per_simulated_s),
        Column(
            head, lambda p: words.error_figures(p.error, scene), lambda p: p.error,
            lambda p: "ok" if sheet.passes(p) else "danger",
        ),
    )  # fmt: skip


class AccuracyPage(MeasuringPage):
    """One chart at a time, one of its scenes; measured charts are kept."""

    file = "accuracy"
    heading, about = "Speed against accuracy", "What each method's error costs in computing time."
    begin, measuring = "Run to see what each method costs.", "Measuring what each method costs…"
    drawn, listed = "Error over computing time of every method", "Methods with cost and error"
    buttons = ("Run", "Run again")
    conditions_title = "Scene"
    read = (
        "Each line is a method, each marker a step size; filled: the loop's own step. Left is faster, "
        "down is more accurate. No method lies below and left of the grey Pareto front. Ring: the studio's "
        "default. Dashed red: tolerance. Choose an integrator in the table to see its motion over time."
    )

    def __init__(self, studio: "Studio", live: "Live"):
        super().__init__(studio, live)
        self._found: dict[str, Chart] = {}
        self._seconds: dict[str, float] = {}
        self._chosen: Point | None = None
        self.charts = Segmented("Chart", tuple(title for _, title in CHARTS))
        self.charts.show_index(0)
        self.scenes = QComboBox()
        self.scenes.setAccessibleName("Scene")
        self.scenes.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToContents)
        self.scenes.hide()
        self.bar.add(self.charts)
        self.bar.add(self.scenes)
        self.reason = hint()
        keep_size_when_hidden(self.chart)
        self.build()
        self.side.add(self.reason)
        self.charts.chosen.connect(lambda _index: self.show_chart())
        self.scenes.currentIndexChanged.connect(lambda _index: self.show_sheet())
        self.table.chosen.connect(self.stand_out)
        self.chart.pointed.connect(self.show_near)
        self.job.running_changed.connect(lambda _on: None if self.sheet else self.show_sheet())

    @property
    def key(self) -> str:
        """Return the key of the chart that is chosen."""
        return CHARTS[self.charts.index][0]

    @property
    def sheet(self) -> Sheet | None:
        """Return the sheet shown, None before it was measured."""
        found = self._found.get(self.key)
        return found.sheet(self.scenes.currentData()) if found and self.scenes.count() else None

    def first(self) -> str:
        return "" if self.key in self._found else self.key

    def run(self) -> None:
        """Measure the chart that is chosen, all its scenes."""
        key = self.key
        self.job.start(lambda progress: accuracy.compute([key], progress=progress))

    def show_result(self, result: Accuracy) -> None:
        """Keep what was measured and show it."""
        for chart in result.charts:
            self._found[chart.key] = chart
            self._seconds[chart.key] = result.seconds
        self.show_chart()

    def show_chart(self) -> None:
        """Show the first scene of the chosen chart, if it was measured."""
        found = self._found.get(self.key)
        with QSignalBlocker(self.scenes):
            self.scenes.clear()
            for index, sheet in enumerate(found.sheets if found else ()):
                self.scenes.addItem(sheet.scene.title, sheet.scene.key)
                self.scenes.setItemData(index, sheet.scene.title, Qt.ItemDataRole.ToolTipRole)
        self.scenes.setVisible(found is not None)
        self.show_sheet()
        self.measure_first()

    def show_sheet(self) -> None:
        """Show the chosen scene: points, answer, methods, conditions."""
        sheet = self.sheet
        self.chart.setVisible(sheet is not None)
        self.point.setText("")
        self.bar.export.setEnabled(sheet is not None)
        self.side.heading.setText(CHARTS[self.charts.index][1])
        self.scenes.setToolTip(self.scenes.currentText())
        self.bar.set_measured(self.key in self._found)
        if sheet is None:
            self.answer.say(self.measuring if self.job.running else self.begin)
            self.table.show_rows((), ())
            self.side.words.setText("Not measured yet.")
            self.conditions.show_pairs([])
            self.reason.setText("")
            if not self.job.running:
                self.bar.say("")
            return
        self.stand_out(None)
        self.table.show_rows(columns(sheet), sorted(sheet.competing, key=lambda p: p.error))
        sign = ("check", "ok") if sheet.passes(sheet.answer.default) else ("triangle", "warn")
        self.answer.say(words.sentence(sheet), *sign)
        choice = next(choice for choice in self._found[self.key].choices if sheet in choice.sheets)
        self.side.words.setText("\n".join(dict.fromkeys((words.verdict(sheet), words.reason(choice)))))
        self.conditions.show_pairs(list(sheet.scene.conditions))
        self.reason.setText(f"Tolerance: {words.tolerance_words(sheet.scene)}. {sheet.scene.reason}.")
        count = sum(len(s.points) for s in self._found[self.key].sheets)
        self.bar.say(f"{count:,} points, {self._seconds[self.key]:.1f} s")

    def stand_out(self, point: Point | None) -> None:
        """Redraw the sheet with a point's method emphasised, its motion below; None for no method."""
        sheet, self._chosen = self.sheet, point
        if sheet is not None:
            self.chart.show_drawing(lambda figure, colors: draw(figure, colors, sheet, point))

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self.scenes.setMaximumWidth(min(max(event.size().width() - 700, 160), 290))

    def show_near(self, event: "MouseEvent | None") -> None:
        """Say in words what the point under the pointer is."""
        self.point.setText("")
        sheet = self.sheet
        if event is None or sheet is None or event.inaxes is not self.chart.figure.axes[0]:
            return
        index = self.chart.near(event, *zip(*map(AccuracyAxes(sheet).place, sheet.points), strict=True))
        if index is not None:
            point = sheet.points[index]
            error = words.error_words(point.error, sheet.scene)
            cost = words.cost_words(point.ns_per_simulated_s)
            step = words.step_words(point.step_s)
            self.point.setText(f"{point.label} at {step}: {error}, {cost} per second")

    def exports(self) -> tuple[Callable[[str], object], Callable[[], dict]]:
        chart, seconds = self._found[self.key], self._seconds[self.key]
        method = self._chosen.method if self._chosen else ""

        def numbers() -> dict:
            return {
                "rows": [p.row() for sheet in chart.sheets for p in sheet.points],
                "choices": [words.choice_row(choice) for choice in chart.choices],
                "conditions": {sheet.scene.key: dict(sheet.scene.conditions) for sheet in chart.sheets},
                "computer": computer(),
            }

        return lambda path: accuracy_figure(Accuracy((chart,), seconds), path, method), numbers


VIEW = View("accuracy", "Accuracy", 20, AccuracyPage, scene=False)
