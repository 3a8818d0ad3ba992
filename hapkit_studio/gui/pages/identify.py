"""The view Identification: it compares the set parameters with estimates, and identifies the handle."""

import math
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from PySide6.QtCore import Qt, QTimer
from PySide6.QtWidgets import QCheckBox, QPushButton, QWidget

from hapkit_studio.columns import Column
from hapkit_studio.dynamics.hand import grip_named
from hapkit_studio.errors import StudioError
from hapkit_studio.gui.pages.base import View
from hapkit_studio.gui.pages.measuring import Freshness, MeasuringPage, loop_facts
from hapkit_studio.gui.pages.open_recording import RecordingOpener
from hapkit_studio.gui.state.background import Job, Progress
from hapkit_studio.gui.widgets.parts import label, vbox
from hapkit_studio.gui.widgets.segmented import Segmented
from hapkit_studio.haptics import rows

if TYPE_CHECKING:
    from hapkit_studio.analysis.identify import Estimate, Identified, Part, Recording
    from hapkit_studio.gui.live.live import Live
    from hapkit_studio.gui.state.studio import Studio


# s: samples in this time after a change are ignored, because numbers and forces fade for 30 ms
_SETTLED = 0.05
_LEAST = 0.2
_ALL = 1 << 30


def newest_samples(studio: "Studio", live: "Live", seconds: float) -> "Callable[[], Recording]":
    """Read the rows of the newest ``seconds`` (inf: all rows), and return a function.

    That function makes a recording of these rows; call it in a thread. Rows that arrive later are not
    included. Raise StudioError without a device or with too few samples.
    """
    engine = studio.engine
    if engine is None:
        raise StudioError("Connect a device first.")
    reader = engine.reader()
    reader.rewind(_ALL if math.isinf(seconds) else math.ceil(1.1 * seconds * engine.loop.rate) + 1)
    table = reader.read()
    times = table[:, rows.HOST_TIME]
    newest = float(times[-1]) if len(times) else 0.0
    table = table[times >= max(live.history.changes[-1] + _SETTLED, newest - seconds)]
    kept = newest - float(table[0, rows.HOST_TIME]) if len(table) else 0.0
    if kept < _LEAST:
        raise StudioError(
            f"The settings changed {kept:.1f} s ago. Move the handle for a longer time, then press Identify."
        )

    from hapkit_studio.analysis.identify import Handle, Setup, of_rows

    device = engine.modelled
    setup = Setup(
        studio.environment,
        dict(studio.values),
        engine.loop.rate,
        engine.health().delay or 0.0,
        float((device or engine.device).quantum),
        Handle(device.mass, device.viscous, device.coulomb_force) if device else None,
        grip_named(studio.grip) if device and np.isfinite(table[:, rows.HAND_TARGET]).any() else None,
    )
    return lambda: of_rows(table, setup)


_STEP_MS = 8
# Amplitude in m, frequency in Hz and phase in rad of the sines of the hand's motion. The sines have no short
# common period, so that the motion does not repeat relative to the sensor's steps.
_SINES = ((0.0085, 0.83, 0.0), (0.0045, 2.37, 1.0), (0.0020, 4.91, 2.0))
_INTO_SURFACE = 0.003


PIECES = ((2.0, "2 s"), (5.0, "5 s"), (10.0, "10 s"), (math.inf, "All"))
PARTS = ("rendered", "handle")
_HOW = "Push against the scene and let go, slowly and fast, in both directions."
_EXAMPLE = "The chart below is only an example."


def example(_progress: Progress) -> "Identified":
    """Identify a simulated spring that is shaken by a hand."""
    from hapkit_studio import api  # imported late to keep start-up fast
    from hapkit_studio.analysis.identify import from_run, identify

    return identify(from_run(api.simulate("spring", {"damping": 2.0}, hand="shake", seconds=3.0)))


def columns(part: "Part") -> tuple[Column, ...]:
    """Return the columns of a part's table: the term with its unit, its set value, its identified value."""
    from hapkit_studio.analysis.identify import texts

    heads = ("Model value", "Identified") if part.key == "handle" else ("Chosen", "Rendered")

    def found(estimate: "Estimate") -> str:
        return texts.measured(estimate) if estimate.determined else "unknown"

    return (
        Column("Term", lambda e: f"{e.term.label}\n{texts.unit_of(e)}", right=False),
        Column(heads[0], lambda e: texts.plain(e.asked, e), lambda e: e.asked or 0.0, lambda e: "ink2"),
        Column(heads[1], found, lambda e: e.value, lambda e: "ink" if e.determined else "warn"),
    )


class IdentifyPage(MeasuringPage):
    """Shows the chart and the numbers of one part at a time; both parts come from the same samples."""

    file = "identify"
    heading, about = (
        "Values: set and rendered",
        "The values are identified from the newest samples, recorded with the present settings.",
    )
    begin = (
        "Move the handle or press Shake handle. Then press Identify to compare the rendered values "
        "with those you set."
    )
    drawn, listed = "Force over position, velocity or acceleration", "Chosen values and identified values"
    buttons = ("Identify", "Identify again")
    needs = ""
    read = (
        "Each dot is the mean of the samples in a short time. Line with band: the identified value with its "
        "95 % interval. Dotted line: the value that was set. Left out: samples whose force is at its limit, "
        "switched off or still fading in."
    )

    def __init__(self, studio: "Studio", live: "Live"):
        super().__init__(studio, live)
        self.found: Identified | None = None
        self._source = ("Device", "")
        self._file: tuple[Recording, Path] | None = None
        self._began, self._seconds = 0.0, 0.0
        self.shake = QTimer(self, interval=_STEP_MS, timerType=Qt.TimerType.PreciseTimer)
        self.pieces = Segmented("Newest samples", tuple(text for _, text in PIECES))
        self.pieces.show_index(1)
        self.parts = Segmented("Show values of", ("Scene", "Handle"))
        self.parts.show_index(0)
        self.shaking = QPushButton("Shake handle")
        self.shaking.setToolTip(
            "The simulated hand moves the handle so that stiffness, damping and friction can be identified"
        )
        self.opening, self.opener = QPushButton("Open…"), RecordingOpener(self)
        self.opening.setToolTip(
            "Identify a recording from a file: a session, a CSV file, or a table of another program"
        )
        for widget in (self.pieces, self.shaking, self.opening, self.parts):
            self.bar.add(widget)
        scene = lambda: {"scene": studio.environment, "values": dict(studio.values)}  # noqa: E731
        self._fresh = Freshness(lambda: {**scene(), **loop_facts(studio)}, self.buttons[1])
        self.released = QCheckBox("No hand held the handle")
        self.how, body = label(_HOW), QWidget()
        self.how.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self.how.setContentsMargins(16, 0, 16, 0)
        vbox(self.how, (self.chart, 1), into=body, margins=(0, 6, 0, 0), gap=6)
        self.build(body)
        self._example: Identified | None = None
        self._exemplify = Job(self)
        self._exemplify.finished.connect(self._take_example)
        self.parts.chosen.connect(lambda _index: self.show_part())
        self.shaking.clicked.connect(self._press_shake)
        self.opening.clicked.connect(self.opener.ask)
        self.opener.opened.connect(self._identify_file)
        self.opener.failed.connect(partial(self.bar.show_text, danger=True))
        self.released.toggled.connect(lambda _on: self._file and self._identify_file(*self._file))
        self.shake.timeout.connect(self._shake)
        studio.stop_changed.connect(self.let_go)
        for changed in (studio.settings_changed, studio.engine_changed, studio.link_changed):
            changed.connect(self._refresh)
        self.show_part()
        self._refresh()

    def side_parts(self) -> tuple[QWidget, ...]:
        return (self.released,)

    @property
    def part(self) -> "Part | None":
        """Return the visible part; None if no samples have been identified yet."""
        return getattr(self.found, PARTS[self.parts.index]) if self.found else None

    def run(self) -> None:
        """Identify the newest samples."""
        take = newest_samples(self._studio, self._live, PIECES[self.pieces.index][0])
        self._file = None
        self._source = "Device", self._studio.engine.device.title if self._studio.engine else ""
        self._refresh()
        self._fresh.begin()
        self._start(take)

    def _identify_file(self, recording: "Recording", path: Path) -> None:
        """Identify a whole recording from a file, or its longest interval with constant settings."""
        self.let_go()
        self._file, self._source = (recording, path), ("File", path.name)
        self._refresh()
        self._fresh.begin_elsewhere()
        self._start(lambda: recording)

    def _start(self, take: "Callable[[], Recording]") -> None:
        released = self.released.isChecked() and not self.released.isHidden()

        def work(_progress: Progress) -> "Identified":
            from hapkit_studio.analysis.identify import identify

            return identify(take(), released=released)

        self.job.start(work)

    def show_result(self, found: "Identified") -> None:
        """Store and show a result."""
        from hapkit_studio.analysis.identify.texts import conditions

        self.found = found
        self._fresh.finish()
        self.show_part()
        self.side.label.setText(
            f"The values are identified from the file “{self._source[1]}”." if self._file else self.about
        )
        used = ("Samples", f"{found.samples:,} in {found.end - found.begin:.1f} s")
        pairs = [used, *conditions(found.setup, found.handle.released)]
        self.conditions.show_pairs([self._source, *pairs] if self._file else pairs)
        self.bar.export.setEnabled(bool(found.rendered.estimates or found.handle.estimates))
        self.bar.show_text("")

    def show_part(self) -> None:
        """Show the chosen part with its chart, numbers and text."""
        part = self.part
        self.table.show_rows(columns(part) if part else (), part.estimates if part else ())
        found = part is not None and part.points is not None
        self.how.setHidden(found)
        example = self._example if self.found is None else None
        self.chart.setVisible(found or example is not None)
        self._show_answer(part)
        if example is not None:
            self._draw(example, pale=True)

    def _take_example(self, found: "Identified") -> None:
        self._example = found
        self.how.setText(f"{_HOW} {_EXAMPLE}")
        self.show_part()

    def _draw(self, found: "Identified", pale: bool) -> None:
        from hapkit_studio.charts.identify import draw

        part = getattr(found, PARTS[self.parts.index])
        self.chart.show_drawing(lambda figure, colors: draw(figure, colors, part, found.end), pale)

    def _show_answer(self, part: "Part | None") -> None:
        from hapkit_studio.analysis.identify import texts

        if part is None or self.found is None:
            self.answer.show_text(self.begin)
            self.point.setText("")
            return
        self.point.setText("\n\n".join([*self.found.notes(part), self.found.force_known]))
        outdated = self._fresh.outdated
        self._draw(self.found, pale=bool(outdated))
        if outdated:
            self.answer.show_text(outdated)
            return
        determined = bool(part.estimates) and part.estimates[0].determined and not self.found.surprises(part)
        sign = ("triangle", "warn") if not determined else ("info", "ink2")
        if determined and texts.confirms(part.estimates[0]):
            sign = ("check", "ok")
        self.answer.show_text(self.found.sentences(part)[0], *sign)

    def exports(self) -> tuple[Callable[[str], object], Callable[[], dict]]:
        from hapkit_studio.charts.identify import identify_figure

        found, source = self.found, self._source
        assert found is not None
        numbers = {**found.as_json(), source[0].lower(): source[1]}
        return lambda path: identify_figure(found, path, [source] if source[1] else []), lambda: numbers

    def set_shown(self, on: bool) -> None:
        super().set_shown(on)
        if not on:
            self.let_go()
        elif self.found is self._example is None:
            self._exemplify.start(example)

    def end(self) -> None:
        self.let_go()
        super().end()

    # shaking: the hand moves for some seconds, then the samples are identified

    def hand_target(self, t: float) -> float:
        """Return the hand's position in m at t s. If the scene has a surface, the hand moves around it."""
        place = self._studio.environment.touched_at(self._studio.values, _INTO_SURFACE)
        soft = min(t / 0.3, 1.0)
        return place + soft * sum(a * math.sin(2.0 * math.pi * f * t + p) for a, f, p in _SINES)

    def let_go(self) -> None:
        """Stop shaking and release the handle."""
        if self.shake.isActive():
            self.shake.stop()
            self._studio.move_hand(None)
            self.bar.show_text("The hand let go")
            self._refresh()

    def _press_shake(self) -> None:
        if self.shake.isActive():
            self.let_go()
            return
        seconds = PIECES[self.pieces.index][0]
        self._began, self._seconds = time.perf_counter(), min(seconds, PIECES[-2][0])
        self.shake.start()
        self.bar.show_text("Shaking the handle…")
        self._refresh()

    def _shake(self) -> None:
        t = time.perf_counter() - self._began
        if t < self._seconds:
            self._studio.move_hand(self.hand_target(t))
        else:
            self.let_go()
            self.press()

    def _refresh(self) -> None:
        """Enable the buttons that the device supports; show whether the result is out of date."""
        ours = self._studio.hand_is_ours and self._studio.grip != "released"
        self.shaking.setEnabled(ours or self.shake.isActive())
        self.shaking.setText("Let go" if self.shake.isActive() else "Shake handle")
        hardware = self._studio.engine is not None and not self._studio.models_handle
        unknown = self._file is not None and not np.isfinite(self._file[0].hand_force).all()
        self.released.setVisible(unknown if self._file else hardware)
        self._show_answer(self.part)


VIEW = View("identify", "Identify", 60, IdentifyPage)
