"""Strength: the motor constant, from weights that the motor carries or from what a kitchen scale reads."""

import threading

from PySide6.QtWidgets import QLabel, QPushButton, QWidget

from hapkit_studio.analysis.calibrate.motor import Strength
from hapkit_studio.analysis.calibrate.result import PASS, passed
from hapkit_studio.devices.board_runner import Track
from hapkit_studio.formatting import number
from hapkit_studio.gui.widgets.parts import across
from hapkit_studio.gui.widgets.segmented import Segmented
from hapkit_studio.gui.wizard.board_dialog import SIGNS
from hapkit_studio.gui.wizard.board_thread import BoardThread
from hapkit_studio.gui.wizard.pictures import KitDrawing
from hapkit_studio.gui.wizard.step_page import StepPage, ThousandthsBox

MASSES = (0.0, 0.050, 0.100)
PUSH = 1.0
"""N on the kitchen scale."""
PUSH_SECONDS = 20.0
_WEIGHTS = (
    "Lay the kit on its left side. Hold the handle in the middle and press Carry; after a second let go "
    "slowly. First without a mass, then with 50 g and with 100 g (coins: weigh them)."
)
_SCALE = (
    "Stand a kitchen scale on its edge at the right of the handle, so that the handle pushes on its plate. "
    f"Press Push: the motor pushes with {PUSH:g} N by its profile. Type what the scale reads."
)


class StrengthStep(StepPage):
    """Complete once a motor constant was measured; skipped, the profile's stays."""

    name = "Strength"
    heading = "Strength: what the motor really pushes"
    begin = "The motor is off until you press a button."
    if_skipped = "the motor constant of the kit's profile"
    pushes = needs_direction = True

    def __init__(self, board: BoardThread) -> None:
        super().__init__(board)
        self._pushed_enough = threading.Event()
        self.method = Segmented("How", ("Weights", "Kitchen scale"))
        self.method.show_index(0)
        self.add_row(self.method)
        self.how = self.add_text()
        self.drawing = KitDrawing(supply=True)
        self.add_handle(self.drawing)
        self.mass = ThousandthsBox("Mass", "g", 0.0, 200.0, 1)
        self.carry = self.button("Carry", self.start_carrying, primary=True, motor=True)
        self.use = self.job_button(
            "Use these", "Sending…", lambda work: work.use_weights(), self._measured,
            ready=lambda: self.calibration.weighed,
        )  # fmt: skip
        self.push = self.button("Push", self.start_pushing, primary=True, motor=True)
        self.enough = QPushButton("Enough")  # the only one that is of use while the motor pushes
        self.enough.setProperty("tall", True)
        self.enough.clicked.connect(self._pushed_enough.set)
        self.reading = ThousandthsBox("Reading", "g", 0.0, 500.0, 1)
        self.take = self.button(
            "Use this reading", self.use_reading, ready=lambda: self.calibration.pushed is not None
        )
        self.weights, self.scale = QWidget(), QWidget()
        across(QLabel("Mass at the handle"), self.mass, self.carry, self.use, None, into=self.weights)
        across(
            self.push, self.enough, QLabel("The scale reads"), self.reading, self.take, None, into=self.scale
        )
        self.column.addWidget(self.weights)
        self.column.addWidget(self.scale)
        self.carried = self.add_text()
        self.method.chosen.connect(self._show_method)
        self.mass.valueChanged.connect(lambda _grams: self._draw())
        self._show_method(0)

    def offer_buttons(self) -> None:
        super().offer_buttons()
        self.method.setEnabled(not self.board.busy)  # the button that ends a push stays in sight

    def _show_method(self, index: int) -> None:
        self.how.setText((_WEIGHTS, _SCALE)[index])
        self.weights.setVisible(index == 0)
        self.scale.setVisible(index == 1)
        self._draw()

    def _draw(self) -> None:
        if self.method.index == 0:
            self.drawing.show_weight(f"{self.mass.value():g}")
        else:
            self.drawing.show_scale()

    def show_refusal(self, words: str, remedy: str = "") -> None:
        again = "Hold the handle in the middle again, then press Carry; let go slowly."
        super().show_refusal(words, remedy or (again if self.method.index == 0 else ""))

    def reset(self) -> None:
        super().reset()
        self.carried.setText("")
        self.mass.show_si(MASSES[0])

    # weights

    def start_carrying(self) -> None:
        """Carry the mass that hangs at the handle."""
        mass = self.mass.si
        self.run_job(
            "Carrying. Let go slowly… it creeps up and down for 6 s.",
            lambda work: (mass, work.carry(mass)),
            self._carried,
        )

    def _carried(self, found: tuple[float, float]) -> None:
        mass, force = found
        masses = sorted(mass for mass, _ in self.calibration.carried)
        self.carried.setText("Carried: " + ", ".join(f"{1e3 * m:g} g" for m in masses) + ".")
        rest = [m for m in MASSES if m not in masses]
        words = f"{1e3 * mass:g} g took {number(abs(force), 2)} N by the profile."
        self.box.show_text(words, _hang(rest[0]) if rest else "Now press Use these.", SIGNS[PASS])
        if rest:
            self.mass.show_si(rest[0])

    # kitchen scale

    def start_pushing(self) -> None:
        """Push on the scale until Enough is pressed."""
        self._pushed_enough.clear()
        words = f"Pushing with {PUSH:g} N. Read the scale, then press Enough."
        enough = self._pushed_enough.is_set
        self.run_job(words, lambda work: work.push_on_scale(PUSH, PUSH_SECONDS, enough), self._pushed)
        self.enough.setFocus()

    def _pushed(self, _track: Track) -> None:
        self.box.show_text("Type what the scale read, then press Use this reading.")
        self.reading.setFocus()

    def use_reading(self) -> None:
        """Take the motor constant that the reading tells."""
        reading = self.reading.si
        self.run_job("Sending…", lambda work: work.use_reading(reading), self._measured)

    def _measured(self, found: Strength) -> None:
        share, half = 100.0 * found.ratio, 100.0 * found.half
        self.finish(
            passed(
                f"The motor pushes {share:.0f} ± {half:.0f} % of what its profile says: "
                f"motor constant {1e3 * found.motor_constant:.2f} mN·m."
            )
        )


def _hang(mass: float) -> str:
    """Return what to do for the next mass in kg."""
    what = f"hang {1e3 * mass:g} g on it" if mass > 0.0 else "take the mass off"
    return f"Next: {what}, hold the handle in the middle, press Carry."
