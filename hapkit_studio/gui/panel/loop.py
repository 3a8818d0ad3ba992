"""The loop as a student changes it: rate, delay, estimator, grip, controller, and what is modelled."""

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QCheckBox, QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget

from hapkit_studio.devices.simulated import MODELS, OPTIONAL, TERMS
from hapkit_studio.dynamics.estimators import ESTIMATORS, USUAL, parse
from hapkit_studio.dynamics.hand import GRIPS
from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import ParameterError
from hapkit_studio.gui.panel.rendering import RenderingSwitch
from hapkit_studio.gui.panel.rows import ChoiceRow, ParameterRow
from hapkit_studio.gui.studio import Studio
from hapkit_studio.gui.widgets.segmented import Segmented
from hapkit_studio.gui.widgets.text import rich
from hapkit_studio.parameters import Choice, Parameter

RATE = Parameter(
    "rate", "Servo rate", "Hz", 1000.0, 100.0, 10000.0,
    "How often the force is computed anew. Between two ticks it is held, so a wall pushes a little longer "
    "on the way out than it resisted on the way in. A slow loop gives that energy to the handle: the wall "
    "buzzes. Halve the rate and half the stiffness is too much.",
)  # fmt: skip
DELAY = Parameter(
    "delay", "Added delay", "s", 0.0, 0.0, 0.1,
    "Time from sensor to motor, added on purpose. The force answers where the handle was, not where it is, "
    "and pushes after the handle has turned back: the longer, the softer a wall must be not to buzz.",
)  # fmt: skip
ESTIMATOR = Choice(
    "estimator", "Velocity", tuple(ESTIMATORS), USUAL,
    "How speed is made from sensor counts. The plain difference is quick but steps by one count per period, "
    "so damping rattles; the low-pass filters are smooth but late, and late damping feeds a buzz. FOAW fits "
    "the longest line that it can: smooth when slow, quick at an impact. The Kalman filter guesses on.",
    labels=("Difference", "IIR", "Butterworth", "FOAW", "Kalman"),
)  # fmt: skip
GRIP = Choice(
    "grip", "Grip", tuple(GRIPS), "medium",
    "How firmly the simulated hand holds while you drag. A hand takes energy away: what buzzes when "
    "released may be calm in a firm grip.",
)  # fmt: skip
CONTROLLER = "Adds damping only while the scene gives energy."
UNWATCHED = "Silent while the board renders: it watches and damps in the computer's loop only."
_LEAST_TARGET = 24
_MODEL_OPTIONS = ("As needed", "Everything")
_SHORT = {"difference": "Diff.", "butterworth": "Butterw."}


def _show(row: ParameterRow, value: float) -> None:
    """Show a value in force, but leave a refused one in its box while nothing has changed."""
    if row.value != value:
        row.show_value(value)


def modelled(needs: tuple[str, ...], model: str) -> list[str]:
    """Return the keys of the device's terms that are modelled; () was never looked at and gets them all."""
    whole = model == "everything" or not needs
    return ["mass", *(key for key in OPTIONAL if whole or key in needs)]


def _words(keys: list[str]) -> str:
    return ", ".join(TERMS[key].word for key in keys)


class ModelLine(QWidget):
    """Says what is modelled; emits ``chosen`` with "scene" or "everything" when a person switches."""

    chosen = Signal(str)

    def __init__(self, parent: QWidget | None = None):
        super().__init__(parent)
        self.words = QLabel()
        self.words.setWordWrap(True)
        self.words.setProperty("role", "hint")
        self.switch = Segmented("Model", _MODEL_OPTIONS)
        self.switch.chosen.connect(lambda index: self.chosen.emit(MODELS[index]))
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(4)
        column.addWidget(self.words)
        column.addWidget(self.switch)

    def show_model(self, environment: Environment, model: str, simulated: bool) -> None:
        """Show what is in force; a real device is not modelled, and a scene that needs all has no switch."""
        self.setVisible(simulated)
        needs = environment.needs
        spare = [key for key in OPTIONAL if key not in modelled(needs, "scene")]
        keys = modelled(needs, model)
        whole = len(keys) > len(OPTIONAL)
        self.words.setText(f"Modelled: {'everything' if whole else _words(keys)}")
        self.switch.setVisible(bool(spare))
        self.switch.show_index(MODELS.index(model))
        self.setToolTip(f"<p>{rich(_model_tip(environment.title, spare, judged=bool(needs)))}</p>")


def _model_tip(title: str, spare: list[str], judged: bool) -> str:
    """Return what is left out and what it would change."""
    if not judged:
        return f"{title} was not judged yet, so everything is modelled: {_words(modelled((), 'scene'))}."
    if not spare:
        all_of_it = _words(modelled((), "scene"))
        return (
            f"{title} needs {all_of_it}: without any one, a force, place or count differs by more than 2 %."
        )
    return (
        f"{title} does without {_words(spare)}: with the parameters it starts with, no force, place or count "
        "differs by more than about 2 % of its scale. Other parameters may need more."
    )


class LoopPanel(QWidget):
    """Rows for the loop under a heading; folded into one line until a person wants them."""

    def __init__(self, studio: Studio, parent: QWidget | None = None):
        super().__init__(parent)
        self._studio = studio
        self.heading = QLabel("Loop")
        self.heading.setProperty("role", "section")
        self.fold = QPushButton("Fold")
        self.fold.setProperty("link", True)
        self.fold.clicked.connect(lambda: self.set_folded(not self.folded))
        self.where = RenderingSwitch(studio)
        self.rate = ParameterRow(RATE)
        self.delay = ParameterRow(DELAY)
        self.estimator = ChoiceRow(ESTIMATOR)
        self.options = {
            key: [ParameterRow(parameter) for parameter in entry.parameters]
            for key, entry in ESTIMATORS.items()
        }
        self.grip = ChoiceRow(GRIP)
        self.controller = QCheckBox("Passivity controller")
        self.controller.setToolTip(CONTROLLER)
        self.controller.setFixedHeight(_LEAST_TARGET)
        self.controller_words = QLabel(CONTROLLER)
        self.controller_words.setProperty("role", "hint")
        self.controller_words.setWordWrap(True)
        self.model = ModelLine()
        self._arrange()
        self._connect()
        self.set_folded(True)

    def set_folded(self, folded: bool) -> None:
        """Fold the rows into one line, or unfold them."""
        self.folded = folded
        self._body.setVisible(not folded)
        self.where.set_folded(folded)
        self.show_state()

    def show_state(self) -> None:
        """Show the loop as the studio has it; a real board's rate is its own."""
        loop = self._studio.loop
        _show(self.rate, self._rate())
        _show(self.delay, loop.delay)
        self.estimator.show_value(ESTIMATOR.options.index(loop.estimator))
        for key, rows in self.options.items():
            given = dict(loop.options) if key == loop.estimator else {}
            for row in rows:
                row.setVisible(key == loop.estimator)
                _show(row, given.get(row.parameter.key, row.parameter.default))
        self.grip.show_value(GRIP.options.index(self._studio.grip))
        self.controller.setChecked(loop.controller)
        self.fold.setText(self.summary() if self.folded else "Fold")
        self.fold.setAccessibleName(f"Loop: {self.summary()}")
        self.model.show_model(self._studio.environment, loop.model, self._studio.simulated)
        self._allow()

    def summary(self) -> str:
        """Return the loop in one line that fits the panel: the estimator without its options."""
        engine, spec, rate = self._studio.engine, self._studio.loop.spec, f"{self._rate():,.0f} Hz"
        board = engine is not None and engine.board_plan is not None
        if board:
            from hapkit_studio.haptics.board_plan import spec_on_board  # late: keeps start-up fast

            spec = spec_on_board(spec)
        key = parse(spec)[0].key
        name = _SHORT.get(key) or ESTIMATOR.word(ESTIMATOR.check(key))
        delay = self.delay.box.text().removesuffix(".0")
        return f"Board {rate} · {name}" if board else f"{rate} · {delay} ms · {name}"

    def _note_rate(self) -> None:
        """Follow a board that renders another law, or the same by a dearer method, at another rate."""
        if self._rate() != self.rate.value:
            self.show_state()

    def _rate(self) -> float:
        engine = self._studio.engine
        if engine is None:
            return self._studio.loop.rate
        return engine.loop.rate if engine.board_plan is None else float(engine.board_plan.rate)

    def _allow(self) -> None:
        engine = self._studio.engine
        own_clock = engine is not None and not engine.device.simulated
        reason = "The board samples by its own clock. Its rate is fixed."
        self.rate.set_locked(reason if own_clock else "")
        board = engine is not None and engine.board_plan is not None
        self.controller_words.setText(UNWATCHED if board else CONTROLLER)
        own_hand = engine is not None and not self._studio.hand_is_ours
        self.grip.set_locked("The hand on this device is your own." if own_hand else "")

    def _arrange(self) -> None:
        head = QHBoxLayout()
        head.setSpacing(0)
        head.addWidget(self.heading)
        head.addStretch(1)
        head.addWidget(self.fold)
        self._body = QWidget(self)
        body = QVBoxLayout(self._body)
        body.setContentsMargins(0, 0, 0, 0)
        body.setSpacing(0)
        filters = [row for rows in self.options.values() for row in rows]
        last = (self.grip, self.controller, self.controller_words, self.model)
        for row in (self.rate, self.delay, self.estimator, *filters, *last):
            body.addWidget(row)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addLayout(head)
        column.addWidget(self.where)
        column.addWidget(self._body)

    def _connect(self) -> None:
        studio = self._studio
        for signal in (studio.loop_changed, studio.engine_changed, studio.environment_changed):
            signal.connect(self.show_state)
        studio.values_changed.connect(self._note_rate)
        self.model.chosen.connect(lambda name: studio.set_loop(model=name))
        self.rate.changed.connect(lambda _key, value: self._apply(self.rate, rate=value))
        self.delay.changed.connect(lambda _key, value: self._apply(self.delay, delay=value))
        self.estimator.changed.connect(
            lambda _key, index: self._studio.set_loop(estimator=ESTIMATOR.options[int(index)], options=())
        )
        self.grip.changed.connect(lambda _key, index: self._studio.set_grip(GRIP.options[int(index)]))
        self.controller.clicked.connect(lambda on: self._studio.set_loop(controller=on))
        for rows in self.options.values():
            for row in rows:
                row.changed.connect(self._apply_option)

    def _apply_option(self, key: str, value: float) -> None:
        options = dict(self._studio.loop.options) | {key: value}
        row = next(r for r in self.options[self._studio.loop.estimator] if r.parameter.key == key)
        self._apply(row, options=tuple(options.items()))

    def _apply(self, row: ParameterRow, **change: object) -> None:
        try:
            self._studio.set_loop(**change)
        except ParameterError as error:
            row.show_error(str(error))
