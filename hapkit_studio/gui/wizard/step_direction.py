"""Direction: switch the motor's supply on; small pulses say whether force and position agree."""

from hapkit_studio.analysis.calibrate.result import CheckResult
from hapkit_studio.gui.wizard.board_dialog import Recent
from hapkit_studio.gui.wizard.board_thread import BoardThread
from hapkit_studio.gui.wizard.handle_view import HandleView
from hapkit_studio.gui.wizard.kit_drawing import KitDrawing
from hapkit_studio.gui.wizard.step_page import StepPage


class DirectionStep(StepPage):
    """Finished once pulses both ways moved the handle as they should."""

    name = "Direction"
    heading = "Direction: a push to the right goes to the right"
    if_skipped = "the direction that the board has; Strength and Friction wait until it is tried"

    def __init__(self, board: BoardThread) -> None:
        super().__init__(board)
        self.add_text(
            "Now plug in the motor's 12 V supply. Put the handle in the middle, hands off, then press Push: "
            "pulses of 0.1\u00a0N, 0.3\u00a0N at most, 80 ms long. A wrong sign would make a spring run away."
        )
        self.handle = self.with_hand(HandleView())
        self.add_pictures(KitDrawing(supply=True), self.handle)
        self.push = self.button("Push", self.start, primary=True, motor=True)
        self.find_dead_band = self.button("Look for a dead band", self.raise_force, motor=True)
        self.find_dead_band.setToolTip(
            "Raises the force slowly, 1.5 N at most, until the handle moves half a millimetre"
        )
        self.find_dead_band.hide()
        self.add_row(self.push, self.find_dead_band)
        self.box.show_text("The motor is off until you press Push.")

    def show_recent(self, recent: Recent) -> None:
        self.handle.show_handle(float(recent.position[-1]), recent.force)

    def start(self) -> None:
        """Push both ways."""
        self.run_job("Pushing, 0.3 N at most…", lambda work: work.try_direction(), self._judged)

    def raise_force(self) -> None:
        """Raise the force until the handle moves."""
        self.run_job("Raising the force, 1.5 N at most…", lambda work: work.find_dead_band(), self._judged)

    def _judged(self, result: CheckResult) -> None:
        self.find_dead_band.setVisible(result.key == "no motion")
        self.push.setText("Push again")
        self.finish(result)
