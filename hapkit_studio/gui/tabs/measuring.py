"""The page of a view that measures: a run bar, the answer, a drawing; beside it table, words, conditions."""

from typing import TYPE_CHECKING

from PySide6.QtWidgets import QWidget

from hapkit_studio.errors import StudioError
from hapkit_studio.gui.tabs.bar import RunBar
from hapkit_studio.gui.tabs.base import Page, filled
from hapkit_studio.gui.tabs.drawing import Drawing
from hapkit_studio.gui.tabs.export import Export
from hapkit_studio.gui.tabs.job import Job
from hapkit_studio.gui.tabs.side import Pairs, SidePanel, hint
from hapkit_studio.gui.tabs.table import Table
from hapkit_studio.gui.tabs.verdict_line import VerdictLine

if TYPE_CHECKING:
    from hapkit_studio.gui.live.live import Live
    from hapkit_studio.gui.studio import Studio


class MeasuringPage(Page):
    """A view declares its words, and what it measures, shows and saves."""

    file = ""
    """What exported files are called."""
    heading, about = "", ""
    """The side's title and what stands below it."""
    begin = ""
    """What the answer's line says before there is one."""
    read = ""
    """How to read the drawing."""
    drawn, listed = "", ""
    """What drawing and table are called where they are not seen."""
    buttons = ("Measure", "Measure again")
    needs = "analysis"
    """What must be compiled before, "" for nothing."""
    conditions_title = "Conditions"
    side: SidePanel

    def __init__(self, studio: "Studio", live: "Live"):
        super().__init__()
        self._studio, self._live = studio, live
        self.job = Job(self, needs=self.needs)
        self.bar = RunBar(self.job, *self.buttons)
        self.verdict, self.chart = VerdictLine(self.begin), Drawing(self.drawn)
        self.table, self.point, self.conditions = Table(self.listed), hint(), Pairs()
        self.side = SidePanel(self.heading, self.about)
        self.bar.run_pressed.connect(self.press)
        self.bar.export_pressed.connect(self.export)
        self.job.finished.connect(self.show_result)
        self._export = Export(self, self.file, self.bar.say)

    def build(self, body: QWidget | None = None) -> None:
        """Put the parts together; body: what stands below the answer if not the drawing alone."""
        answer = (self.verdict,) if self.begin else ()
        self.column.addWidget(filled(self.bar, *answer, body or self.chart))
        if not self.heading:  # its side and what stands in it are its own
            return
        self.side.add(self.table)
        self.side.add(self.point)
        self.fill_side()
        if self.read:
            self.side.section("Read the chart")
            self.side.add(hint(self.read))
        self.conditions.stand_under(self.side.section(self.conditions_title))
        self.side.add(self.conditions)

    def fill_side(self) -> None:
        """Put what a view has besides between its table and how to read the drawing."""

    # what a view does

    def run(self) -> None:
        """Measure; raise StudioError where that cannot be."""
        raise NotImplementedError

    def show_result(self, result) -> None:
        """Show what was measured."""
        raise NotImplementedError

    def save(self, path: str) -> None:
        """Write what is in sight as a picture, in a thread."""
        raise NotImplementedError

    def numbers(self) -> dict:
        """Return what is in sight as one object, SI."""
        raise NotImplementedError

    # what all do

    def press(self) -> None:
        """Measure, or say why not."""
        try:
            self.run()
        except StudioError as error:
            self.bar.say(str(error), danger=True)

    def export(self) -> None:
        """Save what is in sight as a picture or as numbers."""
        self._export.ask(self.save, self.numbers)

    def end(self) -> None:
        self.job.end()
        self._export.job.end()
