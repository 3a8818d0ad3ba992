"""The loop as a student changes it: servo rate, added delay, velocity estimator, grip, controller."""

from PySide6.QtWidgets import QCheckBox, QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget

from hapkit_studio.dynamics.estimators import ESTIMATORS, USUAL, parse
from hapkit_studio.dynamics.hand import GRIPS
from hapkit_studio.errors import ParameterError
from hapkit_studio.gui import breakpoints
from hapkit_studio.gui.panel.rendering import RenderingSwitch
from hapkit_studio.gui.panel.rows import ChoiceRow, ParameterRow
from hapkit_studio.gui.studio import Studio
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
_SHORT = {"difference": "Diff.", "butterworth": "Butterw."}


def _show(row: ParameterRow, value: float) -> None:
    """Show a value in force, but leave a refused one in its box while nothing has changed."""
    if row.value != value:
        row.show_value(value)


class LoopPanel(QWidget):
    """Rows for the loop under a heading that folds them into one line where the window is low."""

    def __init__(self, studio: Studio, parent: QWidget | None = None):
        super().__init__(parent)
        self._studio = studio
        self.heading = QLabel("Loop")
        self.heading.setProperty("role", "section")
        self.fold = QPushButton("Fold")
        self.fold.setProperty("link", True)
        self.fold.clicked.connect(self._turn)
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
        self.folded = False
        self._by_hand = self._low = False
        self._height, self._board = breakpoints.LOOP_SLIDERS, False
        self._arrange()
        self._connect()
        self.show_state()

    def set_folded(self, folded: bool) -> None:
        """Fold the rows into one line, or unfold them."""
        self.folded = folded
        self._body.setVisible(not folded)
        self.where.set_folded(self._low and (folded or not self._by_hand))
        self.show_state()

    def give_way(self, narrow: bool, height: int) -> None:
        """Give way in a low panel: first the sliders, then all rows until a person unfolds them."""
        filters = [row for rows in self.options.values() for row in rows]
        for row in (self.rate, self.delay, *filters):
            row.set_narrow(narrow)
            row.set_compact(height < breakpoints.LOOP_SLIDERS)
        for choice in (self.estimator, self.grip):
            choice.set_compact(height < breakpoints.LOOP_SLIDERS)
        self._low, self._height = height < breakpoints.LOOP_SLIDERS, height
        self._fold_or_unfold()

    def _fold_or_unfold(self) -> None:
        """Fold by the room there is, until a person does; a device that is away changes nothing."""
        engine = self._studio.engine
        if engine is not None:
            self._board = not engine.device.simulated
        if not self._by_hand:
            self.set_folded(
                self._height < breakpoints.LOOP_ROWS + (breakpoints.RENDERING_ROWS if self._board else 0)
            )

    def _turn(self) -> None:
        self._by_hand = True
        self.set_folded(not self.folded)

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
        self.controller_words.setVisible(board or not self._low)
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
        last = (self.grip, self.controller, self.controller_words)
        for row in (self.rate, self.delay, self.estimator, *filters, *last):
            body.addWidget(row)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addLayout(head)
        column.addWidget(self.where)
        column.addWidget(self._body)

    def _connect(self) -> None:
        self._studio.loop_changed.connect(self.show_state)
        self._studio.engine_changed.connect(self._fold_or_unfold)
        self._studio.engine_changed.connect(self.show_state)
        for signal in (self._studio.environment_changed, self._studio.values_changed):
            signal.connect(self._note_rate)
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
