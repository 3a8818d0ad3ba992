"""Identification: what was set against what was rendered, from the newest piece; and what the handle is."""

import math
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QCheckBox, QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget

from hapkit_studio.errors import StudioError
from hapkit_studio.gui.dress import dress
from hapkit_studio.gui.segmented import Segmented
from hapkit_studio.gui.tabs.bar import RunBar
from hapkit_studio.gui.tabs.base import Page, Tab, filled
from hapkit_studio.gui.tabs.export import Export
from hapkit_studio.gui.tabs.fresh import Fresh, loop_facts
from hapkit_studio.gui.tabs.identify_chart import LeftOver, TermChart
from hapkit_studio.gui.tabs.identify_piece import newest
from hapkit_studio.gui.tabs.identify_shake import Shake
from hapkit_studio.gui.tabs.identify_table import EstimateTable, whole
from hapkit_studio.gui.tabs.job import Job, Progress
from hapkit_studio.gui.tabs.side import SidePanel, hint
from hapkit_studio.gui.tabs.verdict_line import VerdictLine

if TYPE_CHECKING:
    from hapkit_studio.analysis.identify import Identified, Part
    from hapkit_studio.gui.live import Live
    from hapkit_studio.gui.studio import Studio

PIECES = ((2.0, "2 s"), (5.0, "5 s"), (10.0, "10 s"), (math.inf, "All"))
PARTS = ("rendered", "handle")
_MOST_CHARTS = 3
_BEGIN = "Move the handle or press Shake, then identify what was rendered."
# less height than that leaves the upper charts no axis
_BOTH_CHARTS = 340
_HOW = (
    "Touch what the scene renders: push and let go, slowly and fast, both ways.\n"
    "Shake does so with the simulated hand. Then press Identify:\n"
    "here you see the force over position and velocity, with the line that fits it."
)
_READ = (
    "Each dot is the mean over a short, smooth window. Line: what was found; its band: 95 %. Dotted: what "
    "was set. A clamped, stopped or fading force is left out."
)


def how_to() -> QLabel:
    """Return the words in the place of charts that are not there yet."""
    label = QLabel(_HOW)
    label.setAlignment(Qt.AlignmentFlag.AlignCenter)
    label.setWordWrap(True)
    dress(label, "QLabel { color: @ink2; font-size: 14px; }")
    return label


class IdentifyPage(Page):
    """Charts of one part at a time, its numbers beside them; both parts come from one piece."""

    side: SidePanel

    def __init__(self, studio: "Studio", live: "Live"):
        super().__init__()
        self._studio, self._live = studio, live
        self.found: Identified | None = None
        self.job = Job(self, needs="")
        self.shake = Shake(studio, self)
        self.bar = RunBar(self.job, "Identify", "Identify again")
        self.pieces = Segmented("Newest piece", tuple(words for _, words in PIECES))
        self.pieces.show_index(1)
        self.parts = Segmented("What", ("Rendered", "Handle"))
        self.parts.show_index(0)
        self.shaking = QPushButton("Shake")
        self.shaking.setToolTip("The simulated hand moves so that every term shows, then it is identified")
        for widget in (self.pieces, self.shaking, self.parts):
            self.bar.add(widget)
        self._fresh = Fresh(self._facts, "Identify again")
        self.verdict, self.how = VerdictLine(_BEGIN), how_to()
        self.charts = tuple(TermChart() for _ in range(_MOST_CHARTS))
        self.left_over = LeftOver()
        self.table, self.words = EstimateTable(), hint()
        self.released = QCheckBox("No hand on the handle")
        self.side = self._side()
        self.column.addWidget(filled(self.bar, self.verdict, self._body()))
        self._export = Export(self, "identify", self.bar.say)
        self._join()
        self.show_part()
        self._look()

    @property
    def part(self) -> "Part | None":
        """Return the part in sight, None before anything was identified."""
        return getattr(self.found, PARTS[self.parts.index]) if self.found else None

    def run(self) -> None:
        """Identify the newest piece."""
        released = self.released.isChecked() and not self.released.isHidden()
        try:
            take = newest(self._studio, self._live, PIECES[self.pieces.index][0])
        except StudioError as error:
            self.bar.say(str(error), danger=True)
            return

        def work(_progress: Progress) -> "Identified":
            from hapkit_studio.analysis.identify import identify

            return identify(take(), released=released)

        self._fresh.begin()
        self.job.start(work)

    def _facts(self) -> dict[str, object]:
        """Return what a result is for."""
        scene = {"scene": self._studio.environment, "values": dict(self._studio.values)}
        return {**scene, **loop_facts(self._studio)}

    def show_found(self, found: "Identified") -> None:
        """Show what was found."""
        self.found = found
        self._fresh.keep()
        self.show_part()
        self.bar.export.setEnabled(bool(found.rendered.estimates or found.handle.estimates))
        self.bar.say(f"{found.end - found.begin:.1f} s, {found.samples:,} samples")

    def show_part(self) -> None:
        """Show the chosen part: charts, numbers, words."""
        part = self.part
        self.table.show_part(part)
        points = part.points if part else None
        names = [n for n in points.names if n != "offset"] if points else []
        for index, chart in enumerate(self.charts):
            chart.setVisible(index < len(names))
            if part is not None and index < len(names):
                chart.show_term(part, names[index])
        if points is not None and self.found is not None:
            self.left_over.show_points(points, self.found.end)
        self.how.setVisible(points is None)
        self._give_room()
        self._say(part)

    def _say(self, part: "Part | None") -> None:
        if part is None or self.found is None:
            self.verdict.say(_BEGIN)
            self.words.setText("")
            return
        lines = self.found.sentences(part)
        self.words.setText(whole("\n\n".join(self.found.notes(part))))
        outdated = self._fresh.outdated
        for chart in (*self.charts, self.left_over):
            chart.outdate(bool(outdated))
        if outdated:
            self.verdict.outdate(outdated)
            return
        good = bool(part.estimates) and part.estimates[0].told and not self.found.surprises(part)
        self.verdict.say(lines[0], *(("check", "ok") if good else ("triangle", "warn")))

    def _look_again(self) -> None:
        """See whether what is shown still holds."""
        self._say(self.part)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._give_room()

    def _give_room(self) -> None:
        """Let what is left over give way where there is room for the upper charts only."""
        part = self.part
        self.left_over.setVisible(
            part is not None and part.points is not None and self.height() >= _BOTH_CHARTS
        )

    def export(self) -> None:
        """Save both parts as a picture, or as numbers."""
        found = self.found
        assert found is not None

        def figure(path: str) -> None:
            from hapkit_studio.charts.identify import identify_figure

            identify_figure(found, path)

        self._export.ask(figure, found.as_json)

    def set_shown(self, on: bool) -> None:
        if not on:
            self.shake.end()

    def end(self) -> None:
        self.shake.end()
        self.job.end()

    # shaking

    def _press_shake(self) -> None:
        if self.shake.running:
            self.shake.end()
            return
        seconds = PIECES[self.pieces.index][0]
        self.shake.start(seconds if math.isfinite(seconds) else PIECES[-2][0])
        self.bar.say("Shaking…")
        self._look()

    def _shaken(self, whole: bool) -> None:
        self._look()
        if whole:
            self.run()
        else:
            self.bar.say("Let go")

    def _look(self) -> None:
        """Offer only what the device allows."""
        ours = self._studio.hand_is_ours and self._studio.grip != "released"
        self.shaking.setEnabled(ours or self.shake.running)
        self.shaking.setText("Let go" if self.shake.running else "Shake")
        self.released.setVisible(self._studio.engine is not None and not self._studio.simulated)

    def _join(self) -> None:
        self.bar.run_pressed.connect(self.run)
        self.bar.export_pressed.connect(self.export)
        self.job.finished.connect(self.show_found)
        self.parts.chosen.connect(lambda _index: self.show_part())
        self.shaking.clicked.connect(self._press_shake)
        self.shake.finished.connect(self._shaken)
        self._studio.engine_changed.connect(self._look)
        self._studio.loop_changed.connect(self._look)
        self._studio.stop_changed.connect(self.shake.end)
        studio = self._studio
        for changed in (studio.environment_changed, studio.values_changed, studio.loop_changed,
                        studio.engine_changed, studio.link_changed):  # fmt: skip
            changed.connect(self._look_again)

    def _body(self) -> QWidget:
        body = QWidget()
        column, row = QVBoxLayout(body), QHBoxLayout()
        column.setContentsMargins(4, 0, 4, 0)
        column.setSpacing(0)
        row.setSpacing(4)
        for chart in self.charts:
            row.addWidget(chart, 1)
        column.addWidget(self.how, 1000)  # all of it: the row of charts is empty then
        column.addLayout(row, 1)
        column.addWidget(self.left_over)
        return body

    def _side(self) -> SidePanel:
        side = SidePanel("Set and rendered", "From the newest piece with the settings in force.")
        side.add(self.table)
        side.add(self.words)
        side.add(self.released)
        side.section("Read the charts")
        side.add(hint(whole(_READ)))
        return side


TAB = Tab("identify", "Identify", 50, IdentifyPage)
