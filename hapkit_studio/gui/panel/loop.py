"""The loop's settings: rate, delay, estimator, grip, controller, and the modelled terms."""

from collections.abc import Iterable
from functools import partial
from typing import TYPE_CHECKING

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QCheckBox, QPushButton, QWidget

from hapkit_studio.devices.simulated import MODELLED, OPTIONAL, TERMS
from hapkit_studio.dynamics.estimators import ESTIMATORS, parse
from hapkit_studio.dynamics.loop_settings import CONTROLLER, DELAY, ESTIMATOR, GRIP, MODELS, RATE
from hapkit_studio.environments.base import Environment, Values
from hapkit_studio.errors import ParameterError
from hapkit_studio.gui.panel.rendering import RenderingSwitch
from hapkit_studio.gui.panel.rows import ChoiceRow, ParameterRow
from hapkit_studio.gui.state.lock import LOOP
from hapkit_studio.gui.state.stored import StoredSettings
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.gui.widgets.parts import Sign, hbox, hint, label, vbox
from hapkit_studio.gui.widgets.segmented import Segmented
from hapkit_studio.gui.widgets.text import rich

if TYPE_CHECKING:
    from hapkit_studio.haptics.board_plan import BoardPlan

CONTROLLER_NOTE = "The controller adds damping only while the scene gives you more energy than you put in."
UNWATCHED = "The passivity controller is not active while the board computes the force."
_LEAST_TARGET = 24
_MODEL_OPTIONS = ("Needed", "All", "No friction")
_SHORT = {"difference": "Diff.", "butterworth": "Butterw."}


def _text(keys: Iterable[str]) -> str:
    *first, last = (TERMS[key].word for key in keys)
    return f"{', '.join(first)} and {last}" if first else last


class ModelLine(QWidget):
    """Shows which terms are modelled; ``chosen`` is emitted with one of MODELS."""

    chosen = Signal(str)

    def __init__(self) -> None:
        super().__init__()
        self.label, self.switch = hint(), Segmented("Simulated parts", _MODEL_OPTIONS)
        self.switch.chosen.connect(lambda index: self.chosen.emit(MODELS[index]))
        vbox(self.label, self.switch, into=self, gap=4)

    def show_model(self, environment: Environment, values: Values, model: str, modelled: bool) -> None:
        """Show the current model; the line is hidden for real hardware."""
        self.setVisible(modelled)
        needs = environment.needed_at(values)
        # ``needs`` is empty for an environment that was not analysed; then every term is modelled
        spare = [key for key in OPTIONAL if needs and key not in needs]
        left_out = {"everything": [], "frictionless": ["coulomb"]}.get(model, spare)
        terms = [key for key in MODELLED if key not in left_out]
        self.label.setText(
            f"Simulated: {_text(terms)}" if left_out else "All parts of the device are simulated"
        )
        self.switch.show_index(MODELS.index(model))
        self.setToolTip(f"<p>{rich(_model_tip(environment.title, spare, judged=bool(needs)))}</p>")


def _model_tip(title: str, spare: list[str], judged: bool) -> str:
    """Return the tooltip, which says which terms are left out, and why."""
    all_of_it = _text(MODELLED)
    if not judged:
        return (
            f"All parts of the device are simulated ({all_of_it}), because it is not known which of them "
            f"{title} needs with these values."
        )
    if not spare:
        return (
            f"In the scene {title}, the device is simulated with {_text(OPTIONAL)}. If one of these parts "
            "were left out, people would feel a difference."
        )
    return (
        f"In the scene {title}, the device is simulated without {_text(spare)}, because with the default "
        "values nobody would feel a difference. With other values, all parts of the device are simulated."
    )


class LoopPanel(QWidget):
    """Shows the loop's rows. One button folds them into a line; another button hides rarely changed rows.

    Both states are stored in the settings. ``opened(part)`` is emitted when a part was unfolded.
    """

    opened = Signal(QWidget)

    def __init__(self, studio: Studio, settings: StoredSettings):
        super().__init__()
        self._studio, self._settings = studio, settings
        self.fold, self.more = QPushButton(autoDefault=True), QPushButton(autoDefault=True)
        for link in (self.fold, self.more):  # Enter presses these buttons, because Space pauses the plots
            link.setProperty("link", True)
        self.where, self.model = RenderingSwitch(studio), ModelLine()
        self.rate, self.delay = ParameterRow(RATE), ParameterRow(DELAY)
        self.estimator, self.grip = ChoiceRow(ESTIMATOR), ChoiceRow(GRIP)
        self.options = {
            key: [ParameterRow(parameter) for parameter in entry.parameters]
            for key, entry in ESTIMATORS.items()
        }
        self.controller = QCheckBox(CONTROLLER.label)
        self.controller.setToolTip(CONTROLLER_NOTE)
        self.controller.setFixedHeight(_LEAST_TARGET)
        self.controller_hint = hint(CONTROLLER_NOTE)
        self._body, self._rare = QWidget(), QWidget()
        vbox(*(row for rows in self.options.values() for row in rows), self.model, into=self._rare)
        usual = (self.rate, self.delay, self.estimator, self.grip, self.controller, self.controller_hint)
        vbox(*usual, hbox(None, self.more, gap=0), self._rare, into=self._body)
        self.padlock = Sign(16, "lock")
        head = hbox(label("Loop", "section"), 6, self.padlock, None, self.fold, gap=0)
        vbox(head, self.where, self._body, into=self)
        self._connect()
        self.set_folded(settings.flag("loop_folded", True))
        self.set_more(settings.flag("loop_more", False))

    def set_folded(self, folded: bool) -> None:
        """Fold the rows into one line, or unfold them."""
        self.folded = folded
        self._settings.setValue("loop_folded", folded)
        self._body.setVisible(not folded)
        self.where.set_folded(folded)
        self.show_state()

    def set_more(self, on: bool) -> None:
        """Show or hide the rarely changed rows."""
        self._settings.setValue("loop_more", on)
        self._rare.setVisible(on)
        self.more.setText("Fewer settings" if on else "More settings")
        self.more.setAccessibleName(f"{self.more.text()} of the loop")

    def show_state(self) -> None:
        """Show the current loop; a real board has its own rate."""
        studio, loop, engine = self._studio, self._studio.loop, self._studio.engine
        fixed = studio.why_fixed(*LOOP)
        self.padlock.setVisible(bool(fixed))
        for part in (self._body, self.where):
            part.setEnabled(not fixed)
            part.setToolTip(fixed)
        self.rate.show_value(self._rate())
        self.delay.show_value(loop.delay)
        self.estimator.show_value(ESTIMATOR.options.index(loop.method))
        for key, rows in self.options.items():
            given = loop.options if key == loop.method else {}
            for row in rows:
                row.setVisible(key == loop.method)
                row.show_value(given.get(row.parameter.key, row.parameter.default))
        self.grip.show_value(GRIP.options.index(studio.grip))
        self.controller.setChecked(loop.controller)
        self.fold.setText(self.summary() if self.folded else "Hide the loop")
        self.fold.setAccessibleName(f"Loop: {self.summary()}")
        self._show_model()
        self.more.setVisible(studio.models_handle or bool(self.options[loop.method]))
        own_clock = engine is not None and engine.device.own_clock
        self.rate.set_locked(
            "The device has its own clock, so the servo rate cannot be changed." if own_clock else ""
        )
        self.controller_hint.setText(UNWATCHED if self._plan() else CONTROLLER_NOTE)
        own_hand = engine is not None and not studio.hand_is_ours
        self.grip.set_locked(
            "Your own hand holds this device, so the grip cannot be set." if own_hand else ""
        )

    def summary(self) -> str:
        """Return a short line that describes the loop; it omits the estimator's options to fit the panel."""
        spec, rate, board = self._studio.loop.estimator, f"{self._rate():,.0f} Hz", self._plan() is not None
        if board:
            from hapkit_studio.haptics.board_plan import spec_on_board  # imported late to keep start-up fast

            spec = spec_on_board(spec)
        key = parse(spec)[0].key
        name = _SHORT.get(key) or ESTIMATOR.option_label(ESTIMATOR.check(key))
        delay = self.delay.box.text().removesuffix(".0")
        return f"Board {rate} · {name}" if board else f"{rate} · {delay} ms · {name}"

    def _plan(self) -> "BoardPlan | None":
        """Return the plan of the board's rendering; None if the computer renders."""
        engine = self._studio.engine
        return engine.decision().in_force if engine is not None else None

    def _rate(self) -> float:
        """Return the rate in Hz that the panel shows; a board's rate is rounded to whole hertz."""
        engine, plan = self._studio.engine, self._plan()
        return float(round(plan.rate)) if plan is not None else (engine or self._studio).loop.rate

    def _note_values(self) -> None:
        """Update the shown model, and the shown rate if a more expensive law has slowed down the board."""
        if self._rate() != self.rate.value:
            self.show_state()
        self._show_model()

    def _show_model(self) -> None:
        studio = self._studio
        self.model.show_model(studio.environment, studio.values, studio.loop.model, studio.models_handle)

    def _connect(self) -> None:
        studio = self._studio
        for signal in (
            studio.loop_changed, studio.engine_changed, studio.environment_changed, studio.lock_changed
        ):  # fmt: skip
            signal.connect(self.show_state)
        studio.values_changed.connect(self._note_values)
        self.fold.clicked.connect(self._toggle_folded)
        self.more.clicked.connect(self._toggle_more)
        self.model.chosen.connect(lambda name: studio.set_loop(model=name))
        self.rate.changed.connect(lambda _key, value: self._apply(self.rate, rate=value))
        self.delay.changed.connect(lambda _key, value: self._apply(self.delay, delay=value))
        self.estimator.changed.connect(
            lambda _key, index: studio.set_loop(estimator=ESTIMATOR.options[int(index)])
        )
        self.grip.changed.connect(lambda _key, index: studio.set_loop(hand=GRIP.options[int(index)]))
        self.controller.clicked.connect(lambda on: studio.set_loop(controller=on))
        for rows in self.options.values():
            for row in rows:
                row.changed.connect(partial(self._apply_option, row))

    def _toggle_folded(self) -> None:
        self.set_folded(not self.folded)
        if not self.folded:
            self.opened.emit(self)

    def _toggle_more(self) -> None:
        self.set_more(self._rare.isHidden())
        if not self._rare.isHidden():
            self.opened.emit(self._rare)

    def _apply_option(self, row: ParameterRow, key: str, value: float) -> None:
        loop = self._studio.loop
        self._apply(row, estimator=(loop.method, loop.options | {key: value}))

    def _apply(self, row: ParameterRow, **change: object) -> None:
        try:
            self._studio.set_loop(**change)
        except ParameterError as error:
            row.show_error(str(error))
