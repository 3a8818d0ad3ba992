"""Speed against accuracy: what each method's error costs, which the scene should use, and whether it does."""

from typing import TYPE_CHECKING

from PySide6.QtCore import Qt
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QComboBox

from hapkit_studio.gui.segmented import Segmented
from hapkit_studio.gui.tabs.accuracy_chart import AccuracyChart
from hapkit_studio.gui.tabs.accuracy_table import MethodTable
from hapkit_studio.gui.tabs.bar import RunBar
from hapkit_studio.gui.tabs.base import Page, Tab, filled
from hapkit_studio.gui.tabs.export import Export
from hapkit_studio.gui.tabs.job import Job, Progress
from hapkit_studio.gui.tabs.side import Pairs, SidePanel, hint
from hapkit_studio.gui.tabs.verdict_line import VerdictLine

if TYPE_CHECKING:
    from hapkit_studio.analysis.accuracy import Chart, Point, Sheet
    from hapkit_studio.gui.live import Live
    from hapkit_studio.gui.studio import Studio

CHARTS = (
    ("integrators", "Integrators"),
    ("velocity", "Velocity"),
    ("servo", "Servo rate"),
    ("friction", "Friction"),
)
_SCENE_WIDTH = 160
# how wide the scenes' names may be, from which width of the page on
_SCENE_WIDTHS = ((1000, 290), (880, 200))
_AGAIN = "Run again"
_BEGIN = "Run to see what each method costs."
_READ = (
    "Each line is a method, each marker a step; filled: the loop's own step. Further left is faster, further "
    "down more accurate. Nothing lies below and left of the grey front. The ring is what the studio uses."
)


def answer_words(sheet: "Sheet") -> str:
    """Write the answer in one sentence; the cheapest is not called so where others cost the same."""
    from hapkit_studio.analysis.accuracy import words
    from hapkit_studio.analysis.accuracy.sheet import TIE

    found, scene = sheet.answer.cheapest, sheet.scene
    if found is None or not sheet.answer.as_cheap:
        return words.sentence(sheet)
    among = f"Among the cheapest (to {100.0 * (TIE - 1.0):.0f} %) {words.limit_words(scene)}"
    cost = words.cost_words(found.ns_per_simulated_s)
    return f"{among}: {words.name_words(scene, found)}, {cost} per simulated second."


class AccuracyPage(Page):
    """One chart at a time, one of its scenes; measured charts are kept."""

    side: SidePanel

    def __init__(self, studio: "Studio", live: "Live"):
        super().__init__()
        self._found: dict[str, Chart] = {}
        self._seconds: dict[str, float] = {}
        self.job = Job(self)
        self.bar = RunBar(self.job, "Run", _AGAIN)
        self.charts = Segmented("Chart", tuple(title for _, title in CHARTS))
        self.charts.show_index(0)
        self.scenes = QComboBox()
        self.scenes.setAccessibleName("Scene")
        self.scenes.setMaximumWidth(_SCENE_WIDTH)
        self.scenes.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToContents)
        self.scenes.hide()
        self.bar.add(self.charts)
        self.bar.add(self.scenes)
        self.verdict, self.chart, self.table = VerdictLine(_BEGIN), AccuracyChart(), MethodTable()
        self.point, self.conditions, self.reason = hint(), Pairs(), hint()
        self.side = self._side()
        self.column.addWidget(filled(self.bar, self.verdict, self.chart))
        self._export = Export(self, "accuracy", self.bar.say)
        self._join()

    @property
    def key(self) -> str:
        """Return the key of the chart that is chosen."""
        return CHARTS[self.charts.index][0]

    @property
    def sheet(self) -> "Sheet | None":
        """Return the sheet in sight, None before it was measured."""
        found = self._found.get(self.key)
        return found.sheet(self.scenes.currentData()) if found and self.scenes.count() else None

    def run(self) -> None:
        """Measure the chart that is chosen, all its scenes."""
        key = self.key

        def work(progress: Progress):
            from hapkit_studio.analysis import accuracy

            return accuracy.compute([key], progress=progress)

        self.job.start(work)

    def show_result(self, result) -> None:
        """Keep what was measured and show it."""
        for chart in result.charts:
            self._found[chart.key] = chart
            self._seconds[chart.key] = result.seconds
        self.show_chart()

    def show_chart(self) -> None:
        """Show the chosen chart as far as it was measured; its first scene."""
        found = self._found.get(self.key)
        self.scenes.blockSignals(True)
        self.scenes.clear()
        for sheet in found.sheets if found else ():
            self.scenes.addItem(sheet.scene.title, sheet.scene.key)
            self.scenes.setItemData(self.scenes.count() - 1, sheet.scene.title, Qt.ItemDataRole.ToolTipRole)
        self.scenes.blockSignals(False)
        self.scenes.setVisible(found is not None)
        self.show_sheet()

    def show_sheet(self) -> None:
        """Show the chosen scene: points, answer, methods, conditions."""
        from hapkit_studio.analysis.accuracy import words

        sheet = self.sheet
        self.chart.show_sheet(sheet)
        self.table.show_sheet(sheet)
        self.point.setText("")
        self.bar.export.setEnabled(sheet is not None)
        self.side.heading.setText(CHARTS[self.charts.index][1])
        self.scenes.setToolTip(self.scenes.currentText())
        self._name_run()
        if sheet is None:
            self._show_nothing()
            return
        right = sheet.answer.right
        self.verdict.say(answer_words(sheet), *(("check", "ok") if right else ("triangle", "warn")))
        self.side.words.setText(words.verdict(sheet))
        self.conditions.show_pairs(list(sheet.scene.conditions))
        self.reason.setText(
            f"Tolerance {words.error_words(sheet.scene.tolerance, sheet.scene.unit)}: {sheet.scene.reason}"
        )
        count = sum(len(s.points) for s in self._found[self.key].sheets)
        self.bar.say(f"{count} points, {self._seconds[self.key]:.1f} s")

    def _show_nothing(self) -> None:
        """Show that this chart was not measured yet."""
        self.verdict.say(_BEGIN)
        self.side.words.setText("Not measured yet.")
        self.conditions.show_pairs([])
        self.reason.setText("")
        if not self.job.running:
            self.bar.say("")

    def _name_run(self) -> None:
        """Offer to run again only what was run."""
        if not self.job.running:
            self.bar.run.setText(_AGAIN if self.key in self._found else "Run")

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        room = event.size().width()
        widths = (width for least, width in _SCENE_WIDTHS if room >= least)
        self.scenes.setMaximumWidth(next(widths, _SCENE_WIDTH))

    def show_point(self, point: "Point | None") -> None:
        """Say in words what the point under the pointer is."""
        from hapkit_studio.analysis.accuracy import words

        sheet = self.sheet
        if point is None or sheet is None:
            self.point.setText("")
            return
        error = words.error_words(point.error, sheet.scene.unit)
        cost = words.cost_words(point.ns_per_simulated_s)
        self.point.setText(f"{point.label} at {words.step_words(point.step_s)}: {error}, {cost} per second")

    def export(self) -> None:
        """Save the chart that is chosen as a picture, or its points as numbers."""
        from hapkit_studio.analysis.accuracy import Accuracy

        shown = Accuracy((self._found[self.key],), self._seconds[self.key])

        def figure(path: str) -> None:
            from hapkit_studio.charts.accuracy import accuracy_figure

            accuracy_figure(shown, path)

        self._export.ask(figure, lambda: {"rows": shown.rows()})

    def end(self) -> None:
        self.job.end()

    def _join(self) -> None:
        self.bar.run_pressed.connect(self.run)
        self.bar.export_pressed.connect(self.export)
        self.charts.chosen.connect(lambda _index: self.show_chart())
        self.scenes.currentIndexChanged.connect(lambda _index: self.show_sheet())
        self.job.finished.connect(self.show_result)
        self.job.running_changed.connect(lambda _running: self._name_run())
        self.table.chosen.connect(self.chart.stand_out)
        self.chart.pointed_at.connect(self.show_point)

    def _side(self) -> SidePanel:
        side = SidePanel("Speed against accuracy", "What each method's error costs in computing time.")
        side.add(self.table)
        side.add(self.point)
        side.section("Read the chart")
        side.add(hint(_READ))
        self.conditions.stand_under(side.section("Scene"))
        side.add(self.conditions)
        side.add(self.reason)
        return side


TAB = Tab("accuracy", "Accuracy", 20, AccuracyPage, scene=False)
