"""Speed and accuracy: the error of each way to render the scene as it is set, and the one to use."""

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QPushButton, QWidget

from hapkit_studio.analysis import chain
from hapkit_studio.analysis.chain import Candidate, Chain, Place, Question
from hapkit_studio.charts.chain import chain_figure, draw, look
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.estimators import parse
from hapkit_studio.errors import ParameterError
from hapkit_studio.gui.background import LatestAnswer
from hapkit_studio.gui.pages.base import Pairs, View
from hapkit_studio.gui.pages.drawing import sign
from hapkit_studio.gui.pages.measuring import MeasuringPage
from hapkit_studio.gui.pages.table import Column
from hapkit_studio.gui.panel.limits import steady_delay
from hapkit_studio.gui.panel.parameter_panel import PanelTitle, ParameterRows
from hapkit_studio.gui.undo import put
from hapkit_studio.gui.widgets.parts import down, hint
from hapkit_studio.haptics.engine import BOARD, COMPUTER

if TYPE_CHECKING:
    from hapkit_studio.gui.live.live import Live
    from hapkit_studio.gui.studio import Studio

REST_MS = 400
"""So long nothing is set before all methods are computed anew."""


def columns(found: Chain) -> tuple[Column, ...]:
    """Return the columns of the candidates: what, where, its error, how stiff it may be."""
    best = [found.recommendation(place).best for place in (COMPUTER, BOARD)]
    return (
        Column(
            "Method", lambda one: f"{one.name}\n{one.place}", right=False,
            sign=lambda one: sign(*look(one, found)), token=lambda one: "accent" if one in best else "ink",
        ),
        Column("JND", lambda one: chain.jnd(one.error).removesuffix(" JND"), lambda one: one.error,
               lambda one: "ok" if one.unfelt else "ink"),
        Column("N/m", lambda one: chain.stiffness_words(one.limit).removesuffix(" N/m"),
               lambda one: one.limit),
    )  # fmt: skip


class ChainPage(MeasuringPage):
    """The newest scene; a slider moves the error of what is set at once, then every way is computed."""

    file = "speed-accuracy"
    heading = "Speed and accuracy"
    about = "How far is each way to render this scene from the scene itself? Shorter is better."
    begin = "Compute to see how far each way to render this scene is from the scene itself."
    drawn, listed = "Error of every way to render the scene, by component", "Ways with error and stiffness"
    buttons = ("Compute", "Compute again")
    use_button: QPushButton
    read = (
        "A bar is the error that a hand feels, split into what causes it. 1 JND is the least that a hand "
        "can tell. A part left of zero makes up for another; the black line is the total then. "
        "Semi-implicit Euler runs half a step ahead, which makes up for part of the delay. "
        "Shaded: recommended. Ring: the default."
    )

    def __init__(self, studio: "Studio", live: "Live"):
        super().__init__(studio, live)
        self.found: Chain | None = None
        self._chosen: Candidate | None = None
        self._worker = LatestAnswer(chain.in_force, self)
        self._rest = QTimer(self, interval=REST_MS, singleShot=True)
        self._rest.timeout.connect(self.press)
        self.reason, body = hint(), QWidget()
        self.reason.setContentsMargins(44, 0, 16, 0)  # below the words of the answer, beside its sign
        down(self.reason, (self.chart, 1), into=body)
        self.build(body)
        self.table.chosen.connect(self._choose)
        self._worker.answered.connect(self.show_in_force)
        for changed in (studio.settings_changed, studio.engine_changed, studio.hidden_changed):
            changed.connect(self.look)

    def side_parts(self) -> tuple[QWidget, ...]:
        self.use_button = QPushButton("Use it", autoDefault=True)
        self.use_button.clicked.connect(self.use)
        self.use_button.setEnabled(False)
        title, self.now = PanelTitle(self._studio), Pairs()
        return self.use_button, self.now, title, ParameterRows(self._studio, title.help)

    def first(self) -> str:
        return "" if self.found else "scene"

    def set_shown(self, on: bool) -> None:
        super().set_shown(on)
        self.look()

    def question(self) -> Question:
        """Return the scene and loop as they are set, on the device in use."""
        studio, engine = self._studio, self._studio.engine
        loop, device = studio.loop, SimulatedHapkit()  # with all that the scene in sight may go without
        here = Place(COMPUTER, loop.rate, loop.delay)
        if engine is not None and not engine.device.simulated:
            kit = engine.device
            device = replace(device, mass=kit.mass, damping=kit.viscous, quantum=kit.quantum)
            here = Place(COMPUTER, engine.loop.rate, steady_delay(engine, COMPUTER))
        places = here, Place(BOARD, loop.board_rate or chain.ON_BOARD.rate)
        return Question(studio.environment, dict(studio.values), loop.spec, places, device)

    def run(self) -> None:
        """Compute every method of the scene as it is set."""
        question = self.question()
        self.job.start(lambda progress: chain.compute(question, progress))

    def look(self) -> None:
        """Follow what is set: another method is known, anything else is computed, first what is in force."""
        if not self._seen or self._studio.hidden:
            return
        question = self.question()
        if self.found is not None and _same_but_method(self.found.question, question):
            if question != self.found.question:
                self.show_result(replace(self.found, question=question))
            return
        if self.found is not None:
            self.chart.fade()
            self.use_button.setEnabled(False)
            self._rest.start()
        self._worker.ask(question)

    def show_result(self, result: Chain) -> None:
        """Show what was computed, unless something else is set by now."""
        self._chosen = None
        self.found = result
        self.chart.show_drawing(lambda figure, colors: draw(figure, colors, result))
        rows = [one for place in (BOARD, COMPUTER) for one in result.compared(place)]
        self.table.show_rows(columns(result), rows)
        places = [place.name for place in result.question.places]
        self._say()
        refused = result.refused.get(result.question.words(result.question.options), "")
        self.show_in_force([result.in_force(name) or refused for name in places])
        pairs = [(place.name.capitalize(), _place_words(place)) for place in result.question.places]
        self.conditions.show_pairs([("Scene", result.question.environment.title), *pairs])
        self.use_button.setEnabled(self.better is not None)
        self.look()

    def _say(self) -> None:
        """Head the chart with what to use where the scene is rendered, and why."""
        assert self.found is not None
        first, why = self.found.sentences(self.place)
        sign = ("check", "ok") if self.found.recommendation(self.place).margin else ("triangle", "warn")
        self.answer.say(first, *sign)
        self.reason.setText(why)
        self.reason.setVisible(bool(why))

    def show_in_force(self, found: Any) -> None:
        """Show what is set, in each place, or why it cannot render that."""
        names = [place.name.capitalize() for place in self.question().places]
        self.now.show_pairs([(f"Set, {n.lower()}", _words(one)) for n, one in zip(names, found, strict=True)])

    @property
    def place(self) -> str:
        """Return where the scene is rendered."""
        engine = self._studio.engine
        return engine.where if engine else COMPUTER

    @property
    def better(self) -> Candidate | None:
        """Return the row that is chosen, else the recommended one where the scene is rendered."""
        if self.found is None or self._chosen is not None:
            return self._chosen
        return self.found.recommendation(self.place).best

    def use(self) -> None:
        """Set method and estimator of the chosen row, or of the answer."""
        one = self.better
        if one is None or not self.use_button.isEnabled():
            return
        key = self._studio.environment.key
        settings: dict = {("value", key, name): value for name, value in one.options}
        if one.estimator != self._studio.loop.estimator:
            settings |= {("loop", "estimator"): one.estimator, ("loop", "options"): ()}
        try:
            put(self._studio, settings)
        except ParameterError as error:
            self.bar.say(str(error), danger=True)

    def _choose(self, one: Candidate | None) -> None:
        self._chosen = one
        self.point.setText("" if one is None else f"{one.label}: {_words(one)}")

    def exports(self) -> tuple[Callable[[str], object], Callable[[], dict]]:
        from hapkit_studio.commands.chain import as_json

        found = self.found
        assert found is not None
        return lambda path: chain_figure([found], path), lambda: as_json(found)

    def end(self) -> None:
        self._rest.stop()
        super().end()
        self._worker.close()


def _same_but_method(one: Question, other: Question) -> bool:
    """Return whether two questions differ in methods and estimator at most."""
    keys = one.spec, other.spec
    estimators = [parse(q.estimator) for q in (one, other)]
    tuned = all(spec(method.key) == method.key for spec, (method, _) in zip(keys, estimators, strict=True))
    alike = tuned or one.estimator == other.estimator
    aligned = replace(other, values=other.with_options(one.options), estimator=one.estimator)
    return one.environment is other.environment and alike and aligned == one


def _words(found: Candidate | str) -> str:
    if isinstance(found, str):
        return found
    numbers = f"{found.rate:,.0f} Hz, {chain.stiffness_words(found.limit)}"
    return f"{chain.jnd(found.error)}, {chain.cost_words(found)}, {numbers}"


def _place_words(place: Place) -> str:
    late = "" if place.delay is None else f", {1e3 * place.delay:.2f} ms late"
    return f"up to {place.rate:,.0f} Hz{late}"


VIEW = View("chain", "Speed and accuracy", 22, ChainPage, scene=False)
