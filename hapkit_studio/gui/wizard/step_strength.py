"""Step 4: the motor constant, from weights that the motor carries or from what a kitchen scale reads."""

from PySide6.QtWidgets import QHBoxLayout, QLabel, QWidget

from hapkit_studio.analysis.calibrate.motor import Strength
from hapkit_studio.analysis.calibrate.result import passed
from hapkit_studio.devices.board_runner import Track
from hapkit_studio.gui.widgets.segmented import Segmented
from hapkit_studio.gui.widgets.style import dress
from hapkit_studio.gui.widgets.theme import number
from hapkit_studio.gui.wizard.desk import Desk
from hapkit_studio.gui.wizard.kit_drawing import KitDrawing
from hapkit_studio.gui.wizard.numbers import Grams
from hapkit_studio.gui.wizard.page import BIG, Seen, StepPage
from hapkit_studio.gui.wizard.rail import Rail

MASSES = (0.0, 0.050, 0.100)
PRESS = 1.0
"""N on the kitchen scale."""
PRESS_SECONDS = 20.0
_WEIGHTS = (
    "Lay the kit on its left side. Hold the handle in the middle and press Carry; after a second let go "
    "slowly. First without a mass, then with 50 g and with 100 g (coins: weigh them)."
)
_SCALE = (
    "Stand a kitchen scale on its edge at the right of the handle, so that the handle pushes on its plate. "
    f"Press Push: the motor pushes with {PRESS:g} N by its profile. Type what the scale reads."
)


class StrengthStep(StepPage):
    """Finished once a motor constant was measured; skipped, the profile's stays."""

    title = "Strength: what the motor really pushes"
    assumed = "the motor constant of the kit's profile"
    needs_direction = True

    def __init__(self, desk: Desk):
        super().__init__(desk)
        self.pressed: Track | None = None
        self._enough = False
        self.way = Segmented("How", ("Weights", "Kitchen scale"))
        self.way.show_index(0)
        self.row(self.way)
        self.words = QLabel()
        self.words.setWordWrap(True)
        dress(self.words, BIG)
        self.column.addWidget(self.words)
        self.rail = self.with_hand(Rail())
        self.drawing = KitDrawing(usb=True, supply=True)
        self.pictures(self.drawing, self.rail)
        self.column.addWidget(self._weights())
        self.column.addWidget(self._scale())
        self.taken = QLabel()
        dress(self.taken, "QLabel { font-size: 14px; }")
        self.column.addWidget(self.taken)
        self.column.addWidget(self.box)
        self.way.chosen.connect(self._show_way)
        self.mass.valueChanged.connect(lambda _grams: self._draw())
        self._show_way(0)
        self.box.say("The motor is off until you press a button.")

    def _weights(self) -> QWidget:
        self.weights = QWidget()
        row = QHBoxLayout(self.weights)
        row.setContentsMargins(0, 0, 0, 0)
        self.mass = Grams("Mass", 0.0, 200.0, 1)
        self.carry = self.button("Carry", self.begin_carry, primary=True, motor=True)
        self.use = self.button("Use these", self.use_weights)
        self.use.setEnabled(False)
        for part in (QLabel("Mass at the handle"), self.mass, self.carry, self.use):
            row.addWidget(part)
        row.addStretch(1)
        return self.weights

    def _scale(self) -> QWidget:
        self.scale = QWidget()
        row = QHBoxLayout(self.scale)
        row.setContentsMargins(0, 0, 0, 0)
        self.press = self.button("Push", self.begin_press, primary=True, motor=True)
        self.enough = self.button("Enough", self._end_press)
        self.enough.setProperty("always", True)
        self.reading = Grams("Reading", 0.0, 500.0, 1)
        self.take = self.button("Use this reading", self.use_reading)
        for part in (self.press, self.enough, QLabel("The scale reads"), self.reading, self.take):
            row.addWidget(part)
        row.addStretch(1)
        return self.scale

    def _show_way(self, index: int) -> None:
        self.words.setText((_WEIGHTS, _SCALE)[index])
        self.weights.setVisible(index == 0)
        self.scale.setVisible(index == 1)
        self._draw()

    def _draw(self) -> None:
        if self.way.index == 0:
            self.drawing.show_weight(f"{self.mass.value():g}")
        else:
            self.drawing.show_scale()

    def show_seen(self, seen: Seen) -> None:
        self.rail.show_handle(float(seen.position[-1]), seen.force)

    # weights

    def begin_carry(self) -> None:
        """Carry the mass that hangs at the handle."""
        mass = self.mass.kilograms
        self.do(
            "Carrying. Let go slowly… it creeps up and down for 6 s.",
            lambda work: (mass, work.carry(mass)),
            self._carried,
        )

    def _carried(self, found: tuple[float, float]) -> None:
        held = sorted(self.subject.carried, key=lambda h: h[0])
        mass, force = found
        self.taken.setText("Carried: " + ", ".join(f"{1e3 * m:g} g" for m, _ in held) + ".")
        rest = [m for m in MASSES if m not in [h[0] for h in held]]
        found_words = f"{1e3 * mass:g} g took {number(abs(force), 2)} N by the profile."
        self.box.say(found_words, _hang(rest[0]) if rest else "Now press Use these.", "check", "ok")
        if rest:
            self.mass.show_kilograms(rest[0])
        self.use.setEnabled(any(m > 0.0 for m, _ in held))

    def use_weights(self) -> None:
        """Take the motor constant that the weights say."""
        self.do("Telling the board…", lambda work: work.use_weights(), self._used)

    # kitchen scale

    def begin_press(self) -> None:
        """Push on the scale until Enough is pressed."""
        self._enough = False
        words = f"Pushing with {PRESS:g} N. Read the scale, then press Enough."
        press = self.do(
            words, lambda work: work.push_on_scale(PRESS, PRESS_SECONDS, lambda: self._enough), self._pressed
        )
        if press:
            self.enough.setFocus()

    def _end_press(self) -> None:
        self._enough = True

    def _pressed(self, track: Track) -> None:
        self.pressed = track
        self.box.say("Type what the scale read, then press Use this reading.")
        self.reading.setFocus()

    def use_reading(self) -> None:
        """Take the motor constant that the reading says."""
        track, reading = self.pressed, self.reading.kilograms
        if track is None:
            self.box.say("Press Push first, and read the scale meanwhile.", "", "triangle", "warn")
            return
        self.do("Telling the board…", lambda work: work.use_reading(reading, track), self._used)

    def _used(self, found: Strength) -> None:
        share, half = 100.0 * found.ratio, 100.0 * found.half
        self.show_verdict(
            passed(
                f"The motor pushes {share:.0f} ± {half:.0f} % of what its profile says: "
                f"motor constant {1e3 * found.motor_constant:.2f} mN·m."
            )
        )

    def show_refusal(self, words: str, remedy: str = "") -> None:
        again = "Hold the handle in the middle again, then press Carry; let go slowly."
        super().show_refusal(words, remedy or (again if self.way.index == 0 else ""))

    def withdraw(self) -> None:
        super().withdraw()
        self.pressed = None
        self.taken.setText("")
        self.mass.show_kilograms(MASSES[0])

    def set_busy(self, busy: bool) -> None:
        super().set_busy(busy)
        if not busy and self.desk.subject is not None:
            self.use.setEnabled(any(m > 0.0 for m, _ in self.subject.carried))


def _hang(mass: float) -> str:
    """Return what to do for the next mass in kg."""
    what = f"hang {1e3 * mass:g} g on it" if mass > 0.0 else "take the mass off"
    return f"Next: {what}, hold the handle in the middle, press Carry."
