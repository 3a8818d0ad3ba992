"""The step Strength: the motor constant is measured with weights, a kitchen scale, or two springs."""

import threading

from PySide6.QtWidgets import QDoubleSpinBox, QLabel, QPushButton, QWidget

from hapkit_studio.analysis.calibrate.motor import (
    HOOKED,
    SPRING_UNCERTAINTY,
    SPRINGS,
    SPRINGS_DIFFER,
    Strength,
)
from hapkit_studio.analysis.calibrate.result import PASS, passed
from hapkit_studio.devices.board_runner import Track
from hapkit_studio.formatting import number
from hapkit_studio.gui.widgets.parts import hbox
from hapkit_studio.gui.widgets.segmented import Segmented
from hapkit_studio.gui.wizard.board_dialog import SIGNS
from hapkit_studio.gui.wizard.board_thread import BoardThread
from hapkit_studio.gui.wizard.pictures import KitDrawing
from hapkit_studio.gui.wizard.step_page import StepPage, ThousandthsBox

MASSES = (0.0, 0.050, 0.100)
PUSH = 1.0
"""N: force on the kitchen scale."""
PUSH_SECONDS = 20.0
SPRING = 100.0
"""N/m: default stiffness of the first spring."""
_WEIGHTS = (
    "Lay the kit on its left side. Hold the handle in the middle, press Start motor, and let go slowly "
    "after a second. Do this first without a mass, then with 50 g, then with 100 g (for example weighed "
    "coins)."
)
_SCALE = (
    "Stand a kitchen scale on its edge at the right of the handle, so that the handle pushes against it. "
    f"Press Push the scale: the motor pushes with {PUSH:g} N according to the kit's profile. Enter the "
    "reading of the scale."
)
_SPRINGS = (
    f"Attach a spring {HOOKED}. Enter the stiffness of the spring, which must be known to "
    f"{100.0 * SPRING_UNCERTAINTY:g} %, take your hands off and press Pull the spring. Then attach another "
    f"spring, at least {SPRINGS_DIFFER:g} × as stiff."
)


class StrengthStep(StepPage):
    """This step is complete once a motor constant was measured.

    If the step is skipped, the constant of the kit's profile is used.
    """

    name = "Strength"
    heading = "Strength: the force that the motor really gives"
    begin = "The motor is off until you press a button."
    if_skipped = "The studio uses the motor constant of the kit's profile."
    pushes = needs_direction = True

    def __init__(self, board: BoardThread) -> None:
        super().__init__(board)
        self._pushed_enough = threading.Event()
        self.method = Segmented("Method", ("Weights", "Kitchen scale", "Springs"))
        self.method.show_index(0)
        self.add_row(self.method)
        self.how = self.add_text()
        self.drawing = KitDrawing(supply=True)
        self.add_handle(self.drawing)
        self.mass = ThousandthsBox("Mass", "g", 0.0, 200.0, 1)
        self.carry = self.button("Start motor", self.start_carrying, primary=True, motor=True)
        self.use = self.job_button(
            "Use this result", "Sending the result…", lambda work: work.use_weights(), self._measured,
            ready=lambda: self.calibration.weighed,
        )  # fmt: skip
        self.push = self.button("Push the scale", self.start_pushing, primary=True, motor=True)
        self.enough = QPushButton("Stop pushing")  # this is the only enabled button while the motor pushes
        self.enough.setProperty("tall", True)
        self.enough.clicked.connect(self._pushed_enough.set)
        self.reading = ThousandthsBox("Reading", "g", 0.0, 500.0, 1)
        self.take = self.button(
            "Use this reading", self.use_reading, ready=lambda: self.calibration.pushed is not None
        )
        self.stiffness = QDoubleSpinBox(decimals=0, suffix=" N/m")
        self.stiffness.setRange(*SPRINGS)
        self.stiffness.setValue(SPRING)
        self.stiffness.setAccessibleName("Stiffness in N/m")
        self.stiffness.lineEdit().setTextMargins(7, 0, 0, 0)
        self.pull = self.button("Pull the spring", self.start_pulling, primary=True, motor=True)
        self.use_pulled = self.job_button(
            "Use this result", "Sending the result…", lambda work: work.use_springs(), self._measured,
            ready=lambda: len(self.calibration.pulled) > 1,
        )  # fmt: skip
        weights, scale, springs = QWidget(), QWidget(), QWidget()
        hbox(QLabel("Mass at the handle"), self.mass, self.carry, self.use, None, into=weights)
        hbox(
            self.push, self.enough, QLabel("Reading of the scale"), self.reading, self.take, None, into=scale
        )
        hbox(
            QLabel("Stiffness of the spring"), self.stiffness, self.pull, self.use_pulled, None, into=springs
        )
        for row in (weights, scale, springs):
            self.column.addWidget(row)
        self.carried = self.add_text()
        self.parts = ((weights, self.carried), (scale,), (springs,))
        self.method.chosen.connect(self._show_method)
        self.mass.valueChanged.connect(lambda _grams: self._draw())
        self._show_method(0)

    def enable_buttons(self) -> None:
        super().enable_buttons()
        self.method.setEnabled(not self.board.busy)  # another method would hide the button that ends a push

    def _show_method(self, index: int) -> None:
        self.how.setText((_WEIGHTS, _SCALE, _SPRINGS)[index])
        for method, widgets in enumerate(self.parts):
            for widget in widgets:
                widget.setVisible(method == index)
        self._draw()

    def _draw(self) -> None:
        if self.method.index == 0:
            self.drawing.show_weight(f"{self.mass.value():g}")
        elif self.method.index == 1:
            self.drawing.show_scale()
        else:
            self.drawing.show_spring()

    def show_refusal(self, text: str, remedy: str = "") -> None:
        again = "Hold the handle in the middle again, press Start motor, then let go slowly."
        super().show_refusal(text, remedy or (again if self.method.index == 0 else ""))

    def reset(self) -> None:
        super().reset()
        self.carried.setText("")
        self.mass.show_si(MASSES[0])

    # weights

    def start_carrying(self) -> None:
        """Let the motor carry the mass at the handle."""
        mass = self.mass.si
        self.run_job(
            "The motor holds the handle. Let go slowly. The handle moves up and down for 6 s.",
            lambda work: (mass, work.carry(mass)),
            self._carried,
        )

    def _carried(self, found: tuple[float, float]) -> None:
        mass, force = found
        masses = sorted(mass for mass, _ in self.calibration.carried)
        self.carried.setText(
            "Masses that the motor has held so far: " + ", ".join(f"{1e3 * m:g} g" for m in masses) + "."
        )
        rest = [m for m in MASSES if m not in masses]
        text = (
            f"To carry {1e3 * mass:g} g, the motor gave {number(abs(force), 2)} N according to the "
            f"kit's profile."
        )
        self.box.show_text(text, _hang(rest[0]) if rest else "Now press Use this result.", SIGNS[PASS])
        if rest:
            self.mass.show_si(rest[0])

    # kitchen scale

    def start_pushing(self) -> None:
        """Push on the scale until the user presses Stop pushing."""
        self._pushed_enough.clear()
        text = f"Pushing with {PUSH:g} N. Read the kitchen scale, then press Stop pushing."
        enough = self._pushed_enough.is_set
        self.run_job(text, lambda work: work.push_on_scale(PUSH, PUSH_SECONDS, enough), self._pushed)
        self.enough.setFocus()

    def _pushed(self, _track: Track) -> None:
        self.box.show_text("Enter the reading of the scale, then press Use this reading.")
        self.reading.setFocus()

    def use_reading(self) -> None:
        """Apply the motor constant computed from the reading."""
        reading = self.reading.si
        self.run_job("Sending the result…", lambda work: work.use_reading(reading), self._measured)

    # springs

    def start_pulling(self) -> None:
        """Let the motor pull the attached spring."""
        stiffness = self.stiffness.value()
        self.run_job(
            "Pulling the spring. Keep your hands off…",
            lambda work: (stiffness, work.pull(stiffness)),
            self._pulled,
        )

    def _pulled(self, found: tuple[float, float]) -> None:
        stiffness, felt = found
        springs = [spring for spring, _ in self.calibration.pulled]
        text = (
            f"The spring of {stiffness:g} N/m was measured as {number(felt, 1)} N/m with the present "
            "settings."
        )
        enough = max(springs) >= SPRINGS_DIFFER * min(springs)
        rest = (
            "Now press Use this result."
            if enough
            else "Next: attach another spring, then press Pull the spring."
        )
        self.box.show_text(text, rest, SIGNS[PASS])

    def _measured(self, found: Strength) -> None:
        self.finish(passed(found.text))


def _hang(mass: float) -> str:
    """Return the instruction for the next mass in kg."""
    what = f"hang {1e3 * mass:g} g on the handle" if mass > 0.0 else "remove the mass"
    return f"Next: {what}, hold the handle in the middle, then press Start motor."
