"""Base class of measuring views.

A view has a run bar, an answer, a drawing and an export. Its side panel has a table and the conditions.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QEvent, Signal
from PySide6.QtWidgets import QFrame, QProgressBar, QPushButton, QSizePolicy, QWidget

from hapkit_studio.dynamics.loop_settings import USUAL_LOOP
from hapkit_studio.errors import StudioError
from hapkit_studio.gui.live.export import write
from hapkit_studio.gui.pages.base import Page, Pairs, SidePanel
from hapkit_studio.gui.pages.drawing import Drawing
from hapkit_studio.gui.state.background import Job
from hapkit_studio.gui.widgets import icons
from hapkit_studio.gui.widgets.parts import (
    AnswerLine,
    choose_file,
    hbox,
    hint,
    keep_size_when_hidden,
    label,
    lay_out,
    primary,
    rule,
    vbox,
)
from hapkit_studio.gui.widgets.style import mark
from hapkit_studio.gui.widgets.table import Table

if TYPE_CHECKING:
    from hapkit_studio.gui.live.live import Live
    from hapkit_studio.gui.state.studio import Studio


_BESIDE = 26  # a status with more letters gets its own line
_MARGINS, _GAP = (12, 7, 8, 7), 6


class RunBar(QWidget):
    """The bar with the run button; emits ``run_pressed`` and ``export_pressed``.

    While the job runs, the run button cancels it. In a narrow window, the bar has two lines.
    """

    run_pressed = Signal()
    export_pressed = Signal()

    def __init__(self, job: Job, labels: tuple[str, str] = ("Measure", "Measure again")):
        super().__init__()
        self._job, self._labels = job, labels
        self._measured = False
        self.status = label(role="hint", wrap=False)
        # Space pauses the plots, so Enter is the key that presses this button
        self.run = primary(QPushButton(autoDefault=True))
        self.run.clicked.connect(self._press)
        self.export = QPushButton("Export", autoDefault=True, flat=True)
        self.export.setEnabled(False)
        self.export.clicked.connect(self.export_pressed)
        icons.bind(self.export, "export", "ink2", 18)
        self.progress = QProgressBar()
        self.progress.setFixedHeight(4)
        self.progress.setAccessibleName("Progress of the measurement")
        keep_size_when_hidden(self.progress)
        self._left, self._below = hbox(gap=_GAP), hbox()
        self._right = hbox(self.status, self.run, self.export, gap=_GAP)
        self._row, self._second = hbox(self._left, None, self._right, margins=_MARGINS, gap=_GAP), hbox(None)
        vbox(self._row, self._second, self._below, self.progress, rule(), into=self)
        job.running_changed.connect(self._refresh)
        job.preparing.connect(
            lambda: self.show_text("The first measurement is being prepared. This takes up to a minute")
        )
        job.progressed.connect(self._follow)
        job.failed.connect(lambda text: self.show_text(text, danger=True))
        job.finished.connect(self._finish)
        self._refresh()

    def add(self, widget: QWidget) -> None:
        """Add a widget to the right of the others; its width is fixed to its natural width."""
        widget.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)
        for button in (widget, *widget.findChildren(QPushButton)):
            if isinstance(button, QPushButton):
                button.setAutoDefault(True)
        self._left.addWidget(widget)

    def lead(self, widget: QWidget) -> None:
        """Insert a widget to the left of all others; it may come from another bar."""
        widget.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)
        self._left.insertWidget(0, widget)

    def show_text(self, text: str, danger: bool = False) -> None:
        """Show a status beside the button, or on its own line if it is long."""
        self.status.setText(text)
        mark(self.status, "role", "error" if danger else "hint")
        below = len(text) > _BESIDE
        if below == self._below.isEmpty():
            (self._right if below else self._below).removeWidget(self.status)
            self.status.setWordWrap(below)
            if below:
                self._below.addWidget(self.status)
            else:
                self._right.insertWidget(0, self.status)
        self._below.setContentsMargins(14, 0, 14, 6 if below else 0)

    def event(self, event: QEvent) -> bool:
        """Choose between one and two lines after a change of the width or of a text."""
        done = super().event(event)
        if event.type() in (QEvent.Type.Resize, QEvent.Type.LayoutRequest):
            self._break_line()
        return done

    def _break_line(self) -> None:
        wide = self._left.sizeHint().width() + self._right.sizeHint().width()
        narrow = wide + _GAP + _MARGINS[0] + _MARGINS[2] > self.width()
        here, there = (self._row, self._second) if narrow else (self._second, self._row)
        if here.indexOf(self._right) >= 0:
            here.removeItem(self._right)
            there.addLayout(self._right)
            self._second.setContentsMargins(_MARGINS[0], 0, _MARGINS[2], _MARGINS[3] if narrow else 0)

    def set_measured(self, measured: bool) -> None:
        """Choose the button's text: for example "Measure again" if there was a measurement before."""
        self._measured = measured
        self._refresh()

    def _press(self) -> None:
        if self._job.running:
            self._job.cancel()
            self.show_text("The measurement was cancelled")
        else:
            self.run_pressed.emit()

    def _finish(self) -> None:
        self.export.setEnabled(True)
        self.show_text("")
        self.set_measured(True)

    def _follow(self, done: int, of: int) -> None:
        if not self._job.running:  # a cancelled job may still report progress
            return
        self.progress.setRange(0, of)
        self.progress.setValue(done)
        self.show_text(f"{100 * done // max(of, 1)} %")

    def _refresh(self) -> None:
        running = self._job.running
        self.run.setText("Cancel" if running else self._labels[self._measured])
        mark(self.run, "primary", not running)
        self._row.activate()  # at once: while a chart is drawn, the longer text would be cut off
        self.progress.setRange(0, 0 if running else 1)
        self.progress.setValue(0)
        self.progress.setVisible(running)


_FILE_KINDS = "Picture (*.png);;Drawing (*.svg);;Page (*.pdf);;Numbers (*.json)"


Facts = Mapping[str, object]


def loop_facts(studio: "Studio", model: bool = True) -> Facts:
    """Return the facts on which a loop measurement depends: device, hand and loop settings.

    ``model``: the result also depends on the modelled imperfections of the device.
    """
    device = studio.entry.key if studio.entry else ""
    loop = replace(studio.loop, hand=USUAL_LOOP.hand)
    loop = loop if model else replace(loop, model=USUAL_LOOP.model)
    return {"device": device, "loop": loop, "hand": studio.grip}


class Freshness:
    """Detects an outdated result; ``facts()`` returns the facts on which the result depends, by name."""

    def __init__(self, facts: Callable[[], Facts], again: str = "Measure again"):
        self._facts, self._again = facts, again
        self._asked: Facts = {}
        self._then: Facts = {}

    def begin(self) -> None:
        """Store the facts at the start of a measurement."""
        self._asked = dict(self._facts())

    def begin_elsewhere(self) -> None:
        """Store no facts, because the data come from elsewhere, for example from a file."""
        self._asked = {}

    def finish(self) -> None:
        """Note that the result has arrived; it is valid for the facts stored by ``begin``."""
        self._then = self._asked

    @property
    def outdated(self) -> str:
        """Return what has changed and what the user can do; "" if the result is up to date."""
        now = self._facts()
        changed = next((name for name, value in self._then.items() if now.get(name) != value), "")
        return (
            f"The result is out of date, because the {changed} changed. Press {self._again}."
            if changed
            else ""
        )


class MeasuringPage(Page):
    """Base class of measuring views; a subclass declares texts, and measures, shows and exports a result."""

    file = ""
    """Base name of exported files."""
    title = ""
    """Text at the start of the run bar, "" for no text."""
    heading, about = "", ""
    """Title and description of the side panel; without a title the view has its own side panel."""
    begin = ""
    """Text of the answer line before there is an answer; "" if the view has no answer line."""
    read = ""
    """Explanation of how to read the drawing."""
    drawn, listed = "", ""
    """Accessible names of drawing and table; "" if the view has no drawing."""
    buttons = ("Measure", "Measure again")
    needs = "analysis"
    """Name of the group of functions that must be compiled before the measurement; "" for no functions."""
    conditions_title = "Conditions"
    side: SidePanel

    def __init__(self, studio: "Studio", live: "Live"):
        super().__init__()
        self._studio, self._live = studio, live
        self._seen, self.begun = False, set[str]()
        self.job = Job(self, needs=self.needs)
        self.bar = RunBar(self.job, self.buttons)
        if self.title:
            self.bar.add(label(self.title, "headline", wrap=False))
        if self.begin:
            self.answer = AnswerLine(self.begin, margins=(16, 8, 16, 0))
        if self.drawn:
            self.chart = Drawing(self.drawn)
        if self.heading:
            self.table, self.point = Table(self.listed), hint()
            self.side = SidePanel(self.heading, self.about)
        self.bar.run_pressed.connect(self.press)
        self.bar.export_pressed.connect(self.export)
        self.job.finished.connect(self.show_result)
        if self.heading:
            self.job.finished.connect(lambda _result: lay_out(self.side))
        self._saving = Job(self, needs="", must_finish=True)
        self._saving.finished.connect(
            lambda path: self.bar.show_text(f"The file {Path(path).name} was saved")
        )
        self._saving.failed.connect(lambda text: self.bar.show_text(text, danger=True))

    def build(self, body: QWidget | None = None) -> None:
        """Lay out the widgets; ``body`` replaces the drawing below the answer."""
        card = QFrame()
        card.setProperty("card", True)
        answer = (self.answer,) if self.begin else ()
        main = body or self.chart
        # keep the space of the hidden drawing: otherwise bar and answer fill the card until there is a result
        keep_size_when_hidden(main)
        vbox(self.bar, *answer, (main, 1), into=card, margins=(1, 1, 1, 1))
        self.column.addWidget(card)
        if not self.heading:
            return
        self.side.add(self.table, self.point, *self.side_parts())
        if self.read:
            self.side.section("How to read the chart")
            self.side.add(hint(self.read))
        self.conditions = Pairs(self.side.section(self.conditions_title))
        self.side.add(self.conditions)

    def side_parts(self) -> tuple[QWidget, ...]:
        """Return the view's own widgets for the side panel, below the table."""
        return ()

    # methods that a view implements

    def run(self) -> None:
        """Start measuring; raise StudioError if that is not possible."""
        raise NotImplementedError

    def show_result(self, result: Any) -> None:
        """Show the result."""
        raise NotImplementedError

    def exports(self) -> tuple[Callable[[str], object], Callable[[], dict]]:
        """Return a function that writes the result's figure to a path, and one that returns its numbers.

        The figure is written in a thread. The numbers are in SI units.
        """
        raise NotImplementedError

    def first(self) -> str:
        """Return the name of a measurement that starts when the page is first shown; "" for none.

        The measurement must take only seconds and move no motor.
        """
        return ""

    # methods common to all views

    def set_shown(self, on: bool) -> None:
        self._seen = on
        self.measure_first()

    def measure_first(self) -> None:
        """Start the view's first measurement once, if no other measurement is running."""
        what = self.first()
        if self._seen and what and what not in self.begun and not self.job.running:
            self.begun.add(what)
            self.press()

    def press(self) -> None:
        """Start measuring, or show why measuring is not possible."""
        try:
            self.run()
        except StudioError as error:
            self.bar.show_text(str(error), danger=True)

    def export(self) -> None:
        """Ask for a file name in a non-modal dialog, then save a picture or the numbers."""
        figure, numbers = self.exports()

        def save(path: str) -> None:
            self._saving.start(lambda _progress: write(path, figure, numbers))

        choose_file(self, "Export", _FILE_KINDS, save, save_as=f"{self.file}.png")
