"""The view Speed and accuracy: cost and error of each method, the best method, and necessary model terms."""

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

from PySide6.QtCore import QTimer, Signal
from PySide6.QtWidgets import QComboBox, QPushButton, QSizePolicy, QStackedWidget, QWidget

from hapkit_studio.analysis import accuracy
from hapkit_studio.analysis.accuracy import Accuracy
from hapkit_studio.analysis.accuracy import scene as this_scene
from hapkit_studio.analysis.accuracy.needs import Effect, Needs
from hapkit_studio.analysis.accuracy.plan import Sheet
from hapkit_studio.analysis.accuracy.scene import Option, Place, SceneRequest, SceneResult, jnd
from hapkit_studio.analysis.perception import FORCE_SHARE, THRESHOLDS
from hapkit_studio.charts import accuracy as charts
from hapkit_studio.charts.experiments import threshold_text
from hapkit_studio.columns import Column
from hapkit_studio.devices.simulated import TERMS, SimulatedHapkit
from hapkit_studio.dynamics.loop_settings import BOARD, COMPUTER, estimator_texts
from hapkit_studio.environments import discover
from hapkit_studio.errors import ParameterError
from hapkit_studio.formatting import number
from hapkit_studio.gui.pages.base import Page, Pairs, SidePanel, View
from hapkit_studio.gui.pages.measuring import MeasuringPage
from hapkit_studio.gui.panel.limits import steady_delay
from hapkit_studio.gui.panel.parameter_panel import PanelTitle, ParameterRows
from hapkit_studio.gui.state.background import Job, LatestResult, Progress
from hapkit_studio.gui.state.undo import put
from hapkit_studio.gui.widgets.parts import choose_file, hint, vbox
from hapkit_studio.gui.widgets.segmented import Segmented
from hapkit_studio.gui.widgets.table import Table
from hapkit_studio.lessons.experiments import own_threshold
from hapkit_studio.sessions.file import SUFFIX

if TYPE_CHECKING:
    from hapkit_studio.analysis.discrimination import Threshold
    from hapkit_studio.gui.live.live import Live
    from hapkit_studio.gui.state.studio import Studio

PARTS = "Methods", "This scene", "What scenes need"
USE_MINE, USE_LITERATURE = "Use my own JND…", "Use published JND"
USE_RECOMMENDED, USE_CHOSEN = "Use recommended method", "Use this method"
REST_MS = 400  # ms: all options are computed again this long after the last change of a setting


class Part(MeasuringPage):
    """Base class of the page's parts; each part shows one kind of result.

    ``board``: the chart shows the errors over the board's cycles instead of the computer's time.
    """

    buttons = ("Run", "Run again")
    board = False

    @property
    def result(self) -> Accuracy:
        """Return the result that this part shows."""
        raise NotImplementedError

    def exports(self) -> tuple[Callable[[str], object], Callable[[], dict]]:
        from hapkit_studio.commands.accuracy import as_json

        found, board = self.result, self.board
        return lambda path: charts.accuracy_figure(found, path, board), lambda: as_json(found)


class MethodsPart(Part):
    """Shows one work-precision chart at a time; measured charts are cached."""

    file = "accuracy-methods"
    heading = "Methods"
    begin = "Which method has the smallest error for its computing time?"
    drawn, listed = (
        "Error of every method over its computing time",
        "Fastest method within each error tolerance",
    )
    read = charts.METHODS_KEY

    def __init__(self, studio: "Studio", live: "Live"):
        super().__init__(studio, live)
        self._found: dict[tuple[str, str], Sheet] = {}
        self.choice, self.where = QComboBox(), Segmented("Computing time on", ("Computer", "Board"))
        self.choice.setAccessibleName("Chart")
        for plan in accuracy.plans().values():
            for one in plan.scenes:
                self.choice.addItem(f"{plan.title}: {one.title}", (plan.key, one.key))
        self.where.show_index(0)
        self.bar.add(self.choice)
        self.choice.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Fixed)
        self.choice.setMinimumWidth(150)  # in a small window the list may be narrower than its text
        self.bar.add(self.where)
        self.build()
        self.choice.currentIndexChanged.connect(lambda _index: self.show_chart())
        self.where.chosen.connect(lambda _index: self.show_chart())
        self.show_chart()

    @property
    def sheet(self) -> Sheet | None:
        """Return the chosen chart's result; None if it has not been measured yet."""
        return self._found.get(self.choice.currentData())

    @property
    def result(self) -> Accuracy:
        return Accuracy(sheets=tuple(filter(None, (self.sheet,))))

    def first(self) -> str:
        return "" if self.sheet else self.choice.currentData()[0]

    def run(self) -> None:
        """Measure the chosen chart with all its scenes."""
        key = self.choice.currentData()[0]
        self.job.start(lambda progress: accuracy.of_methods([key], progress))

    def show_result(self, result: Accuracy) -> None:
        """Store the measured charts and show the chosen one."""
        self._found.update({(sheet.chart, sheet.scene.key): sheet for sheet in result.sheets})
        self.show_chart()

    def show_chart(self) -> None:
        """Show the chosen chart and its points, the answer, the best methods and the conditions."""
        sheet, plan = self.sheet, accuracy.plans()[self.choice.currentData()[0]]
        self.board = board = self.where.index == 1 and sheet is not None and sheet.boarded
        self.side.heading.setText(plan.title)
        self.side.label.setText(plan.question)
        self.where.setEnabled(sheet is None or sheet.boarded)
        self.bar.set_measured(sheet is not None)
        self.bar.export.setEnabled(sheet is not None)
        self.chart.setVisible(sheet is not None)
        if sheet is None:
            self.answer.show_text(plan.question)
            self.table.show_rows((), ())
            self.measure_first()
            return
        self.chart.show_drawing(lambda figure, c: charts.draw_methods(figure, c, sheet, board))
        self.answer.show_text(sheet.sentence(board), "check", "ok")
        self.table.show_rows(charts.winner_columns(sheet, board), sheet.scene.tolerances)
        tolerance = sheet.scene.tolerance_text(sheet.scene.tolerance)
        self.conditions.show_pairs([*sheet.scene.conditions, (tolerance, sheet.scene.reason)])


class ScenePart(Part):
    """Shows every option's error by component for the current scene, and the recommended option."""

    totals = Signal(object)
    file = "accuracy-scene"
    heading, about = "This scene", "The table lists every method for this scene. Choose one and feel it."
    begin = "How close is this scene to the ideal scene, and which method would be closer?"
    drawn, listed = (
        "Error of every method, divided into its causes",
        "Error, rate and stiffness limit of every method",
    )
    read = charts.SCENE_KEY
    use_button: QPushButton

    def __init__(self, studio: "Studio", live: "Live"):
        super().__init__(studio, live)
        self.found: SceneResult | None = None
        # the recommended option for the place (computer or board) where the scene is rendered
        self.better: Option | None = None
        self._chosen: Option | None = None
        self._worker = LatestResult(lambda asked: this_scene.in_force(*asked), self)
        self._worker.answered.connect(self.show_in_force)
        self._rest = QTimer(self, interval=REST_MS, singleShot=True)
        self._rest.timeout.connect(self.press)
        self.reason, body = hint(), QWidget()
        self.reason.setContentsMargins(42, 2, 16, 0)
        vbox(self.reason, (self.chart, 1), into=body)
        self.build(body)
        self.table.chosen.connect(self._choose)
        self.totals.connect(self.show_totals)
        for changed in (studio.settings_changed, studio.engine_changed, studio.hidden_changed):
            changed.connect(self.refresh)

    def side_parts(self) -> tuple[QWidget, ...]:
        self.use_button = QPushButton(USE_RECOMMENDED, autoDefault=True)
        self.use_button.clicked.connect(self.use)
        self.use_button.setEnabled(False)
        title, self.now = PanelTitle(self._studio), Pairs()
        return self.use_button, self.now, title, ParameterRows(self._studio, title.help)

    def first(self) -> str:
        return "" if self.found else "scene"

    def set_shown(self, on: bool) -> None:
        super().set_shown(on)
        self.refresh()

    def question(self) -> SceneRequest:
        """Return the request for the current scene, loop and device."""
        studio, engine = self._studio, self._studio.engine
        # default without a device: the simulated device has every imperfection that an option may leave out
        loop, device = studio.loop, SimulatedHapkit()
        here = Place(COMPUTER, loop.rate, loop.delay)
        if engine is not None:
            kit = engine.device
            device = SimulatedHapkit(kit.mass, kit.viscous, kit.coulomb_force, kit.quantum)
            delay = steady_delay(engine, COMPUTER) if kit.measures_delay else loop.delay
            here = Place(COMPUTER, engine.loop.rate, delay)
        places = here, Place(BOARD, loop.board_rate or this_scene.ON_BOARD.rate)
        return SceneRequest(studio.environment, dict(studio.values), loop.estimator, places, device)

    def run(self) -> None:
        """Compute every option of the current scene: first the total errors, then their components."""
        question = self.question()

        def work(progress: Progress) -> SceneResult:
            found = this_scene.compute(question, progress)
            self.totals.emit(found)
            return this_scene.split(found, progress)

        self.job.start(work)

    def refresh(self) -> None:
        """Handle changed settings.

        A change of the method only selects another option; after any other change all options are computed
        again.
        """
        if not self._seen or self._studio.hidden or self.found is None:
            return
        question = self.question()
        if self.found.knows(question):
            if question != self.found.question:
                self.show_result(replace(self.found, question=question))
            return
        self.chart.fade()
        self.use_button.setEnabled(False)
        self.job.cancel()
        self._worker.ask((question, self.found))
        self._rest.start()

    def show_totals(self, result: SceneResult) -> None:
        """Show total errors before their components are known, unless the settings have changed."""
        if self.job.running and result.question == self.question():
            self.show_result(result)

    def show_result(self, result: SceneResult) -> None:
        """Show the computed options."""
        self.found, self._chosen = result, None
        self._worker.forget()
        where = self._studio.engine.where if self._studio.engine else COMPUTER
        self.chart.show_drawing(lambda figure, colors: charts.draw_scene(figure, colors, result))
        rows = [one for _, options in charts.options_by_location(result) for one in options]
        self.table.show_rows(charts.option_columns(result), rows)
        self.better = result.recommended(where)
        sign = "triangle", "warn"
        if self.better is not None and self.better is result.in_force(where):
            sign = ("check", "ok") if self.better.error < 1.0 else ("info", "ink2")
        self.answer.show_text(result.sentence(where), *sign)
        q = result.question
        refused = result.refused.get(q.options_text(q.options), "")
        others = [result.sentence(place.name) for place in q.places if place.name != where]
        self.reason.setText("\n".join(filter(None, (result.reason(where), *others, refused))))
        self._offer(self.better, USE_RECOMMENDED)
        self.show_in_force([result.in_force(place.name) or refused for place in q.places])
        estimator = estimator_texts(q.estimator)[1]
        self.conditions.show_pairs([
            ("Velocity estimate", estimator), ("Delay", this_scene.delay_text(result.options)),
            ("Ideal scene", f"solved exactly at {this_scene.hertz(result.ideal_rate)}"),
        ])  # fmt: skip

    def show_in_force(self, found: list[Option | str]) -> None:
        """Show the error of the current settings on computer and board, or why one of them cannot render."""
        places = [place.name.capitalize() for place in self.question().places]
        self.now.show_pairs([
            (name, one if isinstance(one, str) else f"{jnd(one.error)}, {this_scene.limit_text(one.limit)}")
            for name, one in zip(places, found, strict=True)
        ])  # fmt: skip

    def use(self) -> None:
        """Apply the methods of the chosen row, or of the recommended option."""
        one = self._chosen or self.better
        if one is None or not self.use_button.isEnabled():
            return
        key = self._studio.environment.key
        try:
            put(self._studio, {("value", key, name): value for name, value in one.options})
        except ParameterError as error:
            self.bar.show_text(str(error), danger=True)

    def _choose(self, one: Option | None) -> None:
        self._chosen, text = one, ""
        if one is not None:
            felt = f"Error: {jnd(one.error)}. Sense: {one.sense}. Motion of the hand: {one.hand}"
            text = f"{felt}. Stiffness without a hand: {this_scene.limit_text(one.limit)}"
        self._offer(one or self.better, USE_CHOSEN if one else USE_RECOMMENDED)
        self.point.setText(text)

    def _offer(self, one: Option | None, text: str) -> None:
        """Offer an option's methods for the loop, unless the loop uses them or the scene has no choice."""
        question = self.question()
        self.use_button.setText(text)
        self.use_button.setEnabled(one is not None and one.options != question.options)
        self.use_button.setVisible(bool(question.choices))

    @property
    def result(self) -> Accuracy:
        return Accuracy(scenes=tuple(filter(None, (self.found,))))

    def end(self) -> None:
        self._rest.stop()
        super().end()


Row = tuple[str, Needs | None]  # a row of the table: a scene's title, and its result if it was measured


def _threshold_line(sense: str, typical: str, strict: str, source: str) -> str:
    return (
        f"{sense}: most people notice {typical}. The most sensitive people notice {strict}. Source: {source}."
    )


class NeedsPart(Part):
    """Shows a table with a row per scene and a column per model term; the side explains the chosen cell."""

    file = "accuracy-needs"
    begin = (
        "Which properties must a simulation contain? The scene is simulated several times, each "
        "time without one property."
    )
    buttons = ("Run this scene", "Run all scenes")

    def __init__(self, studio: "Studio", live: "Live"):
        super().__init__(studio, live)
        self._results: dict[str, Needs] = {}
        self.table = Table("One row for each scene, one column for each property of the device", cells=True)
        self.details, self.law = Pairs(), hint()
        self.side = SidePanel("What a scene needs", "Press Run this scene, then choose a cell of the table.")
        self.side.section("Computing time of each law term")
        self.side.add(self.law)
        self.side.section("Chosen cell")
        self.side.add(self.details)
        self.side.section("How to read the table")
        self.side.add(hint(charts.NEEDS_KEY))
        self.side.section("One just-noticeable difference (JND)")
        self.own: Threshold | None = None
        self.choose_own, self.force = QPushButton(USE_MINE), hint()
        self.choose_own.setToolTip(
            "Use your own threshold of force, from a session in which you compared forces"
        )
        self.side.add(self.force)
        for row in THRESHOLDS[1:]:
            self.side.add(hint(_threshold_line(*row)))
        self._reading = Job(self, needs="")
        self._reading.finished.connect(self.use_own)
        self._reading.failed.connect(lambda why: self.bar.show_text(why, danger=True))
        self.bar.add(self.choose_own)
        self.build(self.table)
        self.table.cell_chosen.connect(self._choose)
        self.choose_own.clicked.connect(self._change_threshold)
        self.use_own(None)

    def _change_threshold(self) -> None:
        """Ask for a session with force comparisons, or return to the threshold from the literature."""
        if self.own is None:
            choose_file(
                self,
                "Choose a session in which you measured your just-noticeable difference",
                f"Sessions (*{SUFFIX})",
                self.open_own,
            )
        else:
            self.use_own(None)

    def open_own(self, path: str) -> None:
        """Read the user's threshold from a session."""
        self._reading.start(lambda _progress: own_threshold(path))

    def use_own(self, found: "Threshold | None") -> None:
        """Use the user's measured threshold for the forces; None uses the threshold from the literature."""
        self.job.cancel()
        self.own = found
        self.choose_own.setText(USE_MINE if found is None else USE_LITERATURE)
        text = _threshold_line(*THRESHOLDS[0])
        if found is not None:
            share = number(100.0 * found.weber.value, 0)
            text = f"Force: you notice a difference of {share} %. {threshold_text(found)}"
        self.force.setText(text)
        self._results.clear()
        self.bar.set_measured(False)
        self._list()

    def first(self) -> str:
        key = self._studio.environment.key
        return key if key in discover() and key not in self._results else ""

    def run(self) -> None:
        """Determine the necessary terms of the current scene first; in the next run, those of all scenes."""
        library, key = discover(), self.first()
        wanted = [library[key]] if key else list(library.values())
        share = FORCE_SHARE if self.own is None else self.own.weber.value
        self.job.start(lambda progress: accuracy.of_needs(wanted, progress, share))

    def show_result(self, result: Accuracy) -> None:
        """Show the results, with the current scene selected."""
        self._results.update({one.scene: one for one in result.needs})
        self._list()
        keys, key = list(discover()), self._studio.environment.key
        self.table.setCurrentIndex(self.table.model().index(keys.index(key) if key in keys else 0, 1))
        found = self._results.get(key)
        if found is not None:
            terms = ", ".join(TERMS[term].word for term in found.needs)
            title = discover()[key].title
            who = "most people" if self.own is None else "you"
            self.answer.show_text(
                f"A simulation of {title} needs {terms}. Without the other properties, {who} would feel "
                "no difference.",
                "check",
                "ok",
            )

    def _list(self) -> None:
        rows = [(one.title, self._results.get(key)) for key, one in discover().items()]
        heads = [term.word.replace(" ", "\n") for term in TERMS.values()]
        terms = map(_term_column, heads, range(len(heads)))
        scene = Column(
            "Scene", lambda row: row[0] if row[1] else f"{row[0]}\nnot run yet", right=False,
            token=lambda row: "ink" if row[1] else "ink3",
        )  # fmt: skip
        self.table.show_rows((scene, *terms), rows)

    def _choose(self, row: Row, column: int) -> None:
        if row[1] is not None:
            self.show_effect(row[1], row[1].effects[max(column - 1, 0)])

    def show_effect(self, found: Needs, effect: Effect) -> None:
        """Explain the effect of leaving out one term in one scene."""
        self.side.heading.setText(f"{discover()[found.scene].title} without {TERMS[effect.term].word}")
        self.law.setText(
            "\n".join(one.text for one in found.law)
            or "Leaving out a part of this law saves no computing time."
        )
        self.side.label.setText(need_text(found, effect))
        pairs = [(c.title, f"{c.text(effect)} {c.unit}".strip()) for c in charts.EFFECT_COLUMNS]
        self.details.show_pairs(pairs)

    @property
    def result(self) -> Accuracy:
        return Accuracy(needs=tuple(self._results.values()))


def need_text(found: Needs, effect: Effect) -> str:
    """Describe whether a scene needs a term."""
    if effect.felt is None:
        return "In this scene, no hand holds the handle, so the mass of the handle cannot be left out."
    if effect.needed:
        return "The scene needs this property."
    if effect.term in found.needs:
        return (
            "If only this property is left out, you feel no difference. If this property and others are left "
            "out, you feel a difference."
        )
    if effect.differs:
        return "Only the most sensitive people notice if this property is missing."
    return "The scene does not need this property."


def _term_column(head: str, index: int) -> Column:
    def text(row: Row) -> str:
        if row[1] is None:
            return ""
        found = row[1].effects[index]
        return charts.felt_text(found.felt) + " †" * found.differs + f"\n{found.sense}" * needed(row)

    def needed(row: Row) -> bool:
        return row[1] is not None and tuple(TERMS)[index] in row[1].needs

    return Column(
        head, text, lambda row: (row[1].effects[index].felt or 0.0) if row[1] else -1.0,
        lambda row: "accent" if needed(row) else "ink3",
        ground=lambda row: "accentsoft" if needed(row) else "surface",
    )  # fmt: skip


class AccuracyPage(Page):
    """Shows one of three parts, each with its own run bar, answer and side panel."""

    side: QStackedWidget
    scene: ScenePart

    def __init__(self, studio: "Studio", live: "Live"):
        super().__init__()
        self.methods, self.scene = MethodsPart(studio, live), ScenePart(studio, live)
        self.needs = NeedsPart(studio, live)
        self.pages: tuple[MeasuringPage, ...] = self.methods, self.scene, self.needs
        self.parts = Segmented("Part of this view", PARTS)
        self._stack, self.side = QStackedWidget(), QStackedWidget()
        for page in self.pages:
            self._stack.addWidget(page)
            self.side.addWidget(page.side)
        self.column.addWidget(self._stack)
        self._seen = False
        self.parts.chosen.connect(self._show)
        self.parts.show_index(PARTS.index("This scene"))
        self._show(self.parts.index)

    @property
    def part(self) -> MeasuringPage:
        """Return the visible part."""
        return self.pages[self.parts.index]

    def _show(self, index: int) -> None:
        for page in self.pages:
            if page is not self.part:
                page.set_shown(False)
        self.part.bar.lead(self.parts)
        self._stack.setCurrentIndex(index)
        self.side.setCurrentIndex(index)
        self.part.set_shown(self._seen)

    def set_shown(self, on: bool) -> None:
        self._seen = on
        self.part.set_shown(on)

    def end(self) -> None:
        for page in self.pages:
            page.end()


VIEW = View("accuracy", "Speed and accuracy", 20, AccuracyPage, scene=False)
