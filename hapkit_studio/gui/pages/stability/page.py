"""The view of the stability map: all limits of the current loop, with the rendered impedance as a dot."""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QCheckBox, QPushButton, QWidget

from hapkit_studio.analysis.stability.kb_plane import as_json, conditions
from hapkit_studio.analysis.stability.margin import RELEASED, Margin, short
from hapkit_studio.analysis.stability.verdict import VerdictInput
from hapkit_studio.charts.stability import Dot, Map, draw, stability_figure
from hapkit_studio.charts.style import Colors
from hapkit_studio.errors import ParameterError
from hapkit_studio.gui.pages.base import SidePanel
from hapkit_studio.gui.pages.measuring import MeasuringPage
from hapkit_studio.gui.pages.stability.map_data import (
    Lines,
    LinesRequest,
    Measured,
    Results,
    measuring,
    solve,
)
from hapkit_studio.gui.pages.stability.trial import MapParameters, Trial, TrialConditions, map_parameters
from hapkit_studio.gui.pages.stability.verdict import Verdict, VerdictColumn, verdict
from hapkit_studio.gui.panel.limits import JUDGING, LoopFacts
from hapkit_studio.gui.panel.parameter_panel import PanelTitle, ParameterRows
from hapkit_studio.gui.state.background import LatestResult
from hapkit_studio.gui.state.lock import LOOP
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.gui.widgets.parts import hbox, hint, label, lay_out, rule
from hapkit_studio.gui.widgets.segmented import Segmented
from hapkit_studio.gui.widgets.theme import number, theme

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.backend_bases import MouseEvent

    from hapkit_studio.gui.live.live import Live


_COMPUTING = JUDGING, "The map is being computed."
_CONTROLLER = "The controller adds damping only while the scene has given you more energy than you put in."


class StabilitySide(SidePanel):
    """The side panel with the environment's sliders, the trial, and the passivity controller."""

    def __init__(self, studio: Studio):
        super().__init__()
        self.heading.hide()
        self.label.hide()
        self.title = PanelTitle(studio)
        self.rows = ParameterRows(studio, self.title.help)
        self.add(self.title, rule(), self.rows)
        self.section("Try these settings")
        self.try_hint, self.release, self.outcome = hint(), QPushButton(), label()
        self.add(self.try_hint, self.release, self.outcome)
        self.section("Keep the scene stable")
        self.controller = QCheckBox("Passivity controller")
        self.add(self.controller, hint(_CONTROLLER))


HANDS = ("released", "medium", "all")
_HAND_WORDS = ("No hand", "Medium grip", "All hands")
_NAMES = {"Delay": "Measured delay"}
_COLUMN, _COLUMN_FROM = 276, 560


class StabilityPage(MeasuringPage):
    """Computes the map's lines while visible, and measures on demand."""

    file = "stability"
    drawn = "Stability map: damping on the horizontal axis, stiffness on the vertical axis"
    side: StabilitySide

    def __init__(self, studio: "Studio", live: "Live"):
        super().__init__(studio, live)
        self.facts = LoopFacts(studio, self)
        self.trial = Trial(studio, live, self)
        self._worker = LatestResult(solve, self)
        self.lines: Lines | None = None
        self.results = Results()
        self._wanted = False
        self._map: Map | None = None
        self._dot: Dot | None = None
        self.hands = Segmented("Hand", _HAND_WORDS)
        self.hands.show_index(0)
        self.hands.setMinimumWidth(self.hands.sizeHint().width())
        self.real = QCheckBox("With friction and sensor steps")
        self.real.setToolTip(
            "Measure with the friction and the sensor steps of the device. If this box is not checked, "
            "measure an ideal device"
        )
        self.bar.add(self.hands)
        self.bar.add(self.real)
        self.verdict_column, self.side = VerdictColumn(), StabilitySide(studio)
        body = QWidget()
        hbox((self.chart, 1), self.verdict_column, into=body, gap=0)
        self.build(body)
        self._join(live)
        self._forget_lines()

    # actions of the user

    def go(self, damping: float, stiffness: float) -> None:
        """Set the parameters to a point of the map."""
        parameters = self.map_parameters
        if parameters is None:
            return
        try:
            self._studio.set_values(parameters.values(stiffness, damping))
        except ParameterError as error:
            self.bar.show_text(str(error), danger=True)

    def try_it(self) -> None:
        """Pull the handle away and release it."""
        if (conditions := self.trial_conditions) is not None:
            self.trial.begin(conditions)

    def run(self) -> None:
        """Measure the map and the boundary for the settings shown."""
        self._wanted = self.lines is None
        if self.lines is None:
            self.bar.show_text(
                "Waiting until the map is computed" if self._studio.engine else "Connect a device first."
            )
            return
        plane = self.lines.plane
        self.job.start(measuring(plane.setting, self.real.isChecked(), (plane.width, plane.top)))

    def exports(self) -> tuple[Callable[[str], object], Callable[[], dict]]:
        assert self.lines is not None
        plane = self.lines.plane if self.outdated else self.results.put_into(self.lines.plane)
        dampings = self.lines.dampings
        engine = self._studio.engine
        device = engine.device.title if engine is not None else ""

        return lambda path: stability_figure(plane, path, device, dampings), lambda: as_json(plane)

    # requests and answers

    @property
    def map_parameters(self) -> MapParameters | None:
        """Return the parameters that a click on the map sets; None if the environment has no impedance."""
        environment = self._studio.environment
        return map_parameters(environment, self._studio.values) if environment.impedance else None

    @property
    def trial_conditions(self) -> TrialConditions | None:
        """Return the predicted behaviour and the release position for a trial.

        Return None before the lines are known.
        """
        asked = self.lines.question.asked if self.lines else None
        if self.lines is None or asked is None or self.lines.plane.verdict is None:
            return None
        plane, does = self.lines.plane, self.lines.plane.verdict.does[RELEASED]
        stiffness, quantum = plane.margin.stiffness, plane.setting.quantum
        return TrialConditions(does, asked.centre, stiffness, asked.max_force, quantum)

    def question(self) -> LinesRequest | None:
        """Return the request for the current settings; None without a device or a known delay."""
        hand, studio = HANDS[self.hands.index], self._studio
        setting = self.facts.setting("released" if hand == "all" else hand)
        if setting is None or studio.engine is None:
            return None
        held = replace(setting, hand=studio.grip if setting.grip is None else hand)
        asked = VerdictInput(studio.environment, dict(studio.values), held, studio.engine.max_force)
        stiffness, damping = asked.impedance or (0.0, 0.0)
        last, every = self.lines, hand == "all"
        same = last is not None and (last.question.setting, last.question.every_hand) == (setting, every)
        keep = (last.plane.width, last.plane.top) if last and same else None
        return LinesRequest(setting, stiffness, damping, keep, every, asked)

    def ask(self) -> None:
        """Request the lines if the page is visible."""
        if not self._seen:
            return
        question = self.question()
        if question is None:
            self._worker.forget()
            self._forget_lines()
        else:
            self._worker.ask(question)

    def show_lines(self, lines: Lines) -> None:
        """Show the computed lines."""
        self.lines = lines
        self._show_studio()
        self.verdict_column.show_limits(lines)
        self.bar.export.setEnabled(True)
        self._show_all()
        if self._wanted:
            self.run()

    def show_result(self, measured: Measured) -> None:
        """Store a measurement; keep a measurement with the opposite setting of the passivity controller."""
        self.results.add(measured)
        self._show_all()

    # reactions to being shown, hidden and resized

    def set_shown(self, on: bool) -> None:
        super().set_shown(on)
        if on:
            self._show_studio()
            self.ask()
        else:
            self.trial.let_go()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self.verdict_column.setFixedWidth(theme.px(_COLUMN))
        self.verdict_column.setVisible(event.size().width() >= theme.px(_COLUMN_FROM))

    def wait(self) -> None:
        """Wait until the lines are computed (tests only); Qt delivers them with the next events."""
        self._worker.wait()

    # methods that update the page

    @property
    def outdated(self) -> bool:
        """Return whether the measurement that is shown was made under other conditions than the map's."""
        return self.lines is not None and self.results.outdated(
            self.lines.plane.setting, self.real.isChecked()
        )

    def _show_all(self) -> None:
        """Show verdict, map and conditions.

        Also show how long the measurement took, or that it is out of date.
        """
        if self.lines is None:
            return
        plane, real = self.lines.plane, self.real.isChecked()
        self.results.prefer(plane.setting, real)
        newest, column = self.results.last, self.verdict_column
        column.show_verdict(verdict(plane, None if self.outdated else newest))
        self._show_map(self.lines)
        pairs = dict(conditions(plane.setting, real)) | ({"Hand": "all hands"} if self.lines.hands else {})
        column.conditions.show_pairs([(_NAMES.get(name, name), value) for name, value in pairs.items()])
        lay_out(column)  # lay out now, because the first drawing of the map takes a second
        if newest is not None and not self.job.running:
            self.bar.show_text(
                "Measurement out of date" if self.outdated else newest.text((plane.width, plane.top))
            )

    def _show_map(self, lines: Lines) -> None:
        """Redraw the map, or move only the dot if nothing else changed."""
        dotted = self._studio.environment.impedance is not None
        outdated = bool(self.results.all) and (self.job.running or self.outdated)
        others = tuple(measured.points for measured in self.results.all[:-1])
        plane = self.results.put_into(lines.plane)
        shown, before = Map(plane, others, lines.hands, outdated, dotted), self._map
        self._map = shown
        there = self._dot is not None and self.chart.moving and not self.chart.pale
        if there and self._dot is not None and before is not None and _same(shown, before):
            self._dot.place(plane, dotted)
            self.chart.follow()
            return
        self.verdict_column.show_lines(shown.lines())

        def paint(figure: Any, colors: Colors) -> "tuple[Artist, ...]":
            assert self._map is not None
            self._dot = draw(figure, colors, self._map)
            return self._dot.artists

        self.chart.show_drawing(paint)

    def show_near(self, event: "MouseEvent | None") -> None:
        """Show the limit and the margin at the pointer."""
        if event is None or self.lines is None or self.chart.pale:
            self.chart.read(None)
        else:
            text = reading(self.lines, float(event.xdata or 0.0), float(event.ydata or 0.0))
            self.chart.read(event, "\n".join(text))

    def _forget_lines(self) -> None:
        self.lines = None
        self.chart.fade()
        self.verdict_column.show_lines({})
        self.verdict_column.conditions.show_pairs([])
        self.verdict_column.show_limits(None)
        self.bar.export.setEnabled(False)
        missing = self.facts.why_unknown() if self.facts.setting() is None else _COMPUTING
        self.verdict_column.show_verdict(Verdict(*missing))
        self._show_studio()

    def _show_studio(self) -> None:
        """Update the description of a click's effect, the release button, and the controller's check box."""
        side, trial, parameters = self.side, self.trial, self.map_parameters
        text = parameters.text if parameters else "This environment has no stiffness or damping to set."
        if self._studio.engine is not None and not trial.possible:
            text += " On a real Hapkit, let go of the handle with your hand."
        side.try_hint.setText(text)
        side.release.setText("Holding the handle…" if trial.holding else "Release the handle here")
        side.release.setEnabled(trial.possible and not trial.holding and self.lines is not None)
        side.outcome.setText(trial.report)
        side.outcome.setVisible(bool(trial.report))
        side.controller.setEnabled(not self._studio.why_fixed(*LOOP))
        side.controller.setChecked(self._studio.loop.controller)

    def _join(self, live: "Live") -> None:
        studio, side = self._studio, self.side
        live.health.connect(self.facts.note_health)
        self.facts.changed.connect(self.ask)
        self._worker.answered.connect(self.show_lines)
        self._worker.late.connect(self._forget_lines)
        self.hands.chosen.connect(lambda _index: self.ask())
        self.real.toggled.connect(self._show_all)
        self.job.running_changed.connect(self._show_all)
        for signal in (studio.environment_changed, studio.values_changed):
            signal.connect(self.ask)
        for signal in (studio.environment_changed, studio.values_changed, studio.engine_changed,
                       studio.loop_changed, studio.lock_changed, self.trial.changed):  # fmt: skip
            signal.connect(self._show_studio)
        side.release.clicked.connect(self.try_it)
        side.controller.clicked.connect(lambda on: studio.set_loop(controller=on))
        self.chart.clicked.connect(self.go)
        self.chart.dragged.connect(self.go)
        self.chart.pointed.connect(self.show_near)


def _same(one: Map, other: Map) -> bool:
    """Return whether two maps are equal, apart from the position of the dot."""
    parts = ("damping", "exact", "simple", "edge", "top", "setting", "pushes", "points", "cells")
    same = all(getattr(one.plane, part) is getattr(other.plane, part) for part in parts)
    rest = [
        (m.outdated, list(map(id, m.others)), {k: id(v) for k, v in m.hands.items()}) for m in (one, other)
    ]
    return same and rest[0] == rest[1]


def reading(lines: Lines, damping: float, stiffness: float) -> tuple[str, str]:
    """Return the tooltip of a point: its values, the limit, and the margin at the point."""
    plane = lines.plane
    values = f"{stiffness:,.0f} N/m, {number(damping, 1)} N·s/m"
    limit = float(np.interp(damping, plane.damping, plane.exact))
    again = tuple(plane.again[:, np.abs(plane.damping - damping).argmin()])
    text = short(Margin(stiffness, damping, limit, plane.setting.hand, (again,)))
    if not math.isfinite(limit) or limit <= 0.0:
        return values, text
    bound = f"{limit:,.0f} N/m"
    return values, f"{text} of {bound}" if text.endswith("limit") else f"{text}; the limit is {bound}"
