"""Direction: motor pulses test whether force and position have the same sign."""

from hapkit_studio.analysis.calibrate.result import CheckResult
from hapkit_studio.gui.wizard.board_thread import BoardThread
from hapkit_studio.gui.wizard.pictures import KitDrawing
from hapkit_studio.gui.wizard.step_page import StepPage


class DirectionStep(StepPage):
    """Switch the motor's supply on; small pulses test whether force and position agree."""

    pushes = True
    name = "Direction"
    heading = "Direction: a push to the right goes to the right"
    words = (
        "Now plug in the motor's 12 V supply. Put the handle in the middle, hands off, then press Push: "
        "pulses of 0.1\u00a0N, 0.3\u00a0N at most, 80 ms long. A wrong sign would make a spring run away."
    )
    begin = "The motor is off until you press Push."
    if_skipped = "the direction that the board has; Strength and Friction wait until it is tried"

    def __init__(self, board: BoardThread) -> None:
        super().__init__(board)
        self.add_handle(KitDrawing(supply=True))
        self.push = self.job_button(
            "Push", "Pushing, 0.3 N at most…", lambda work: work.try_direction(), self._judged,
            primary=True, motor=True,
        )  # fmt: skip
        self.find_dead_band = self.job_button(
            "Look for a dead band", "Raising the force, 1.5 N at most…", lambda work: work.find_dead_band(),
            self._judged, motor=True,
        )  # fmt: skip
        self.find_dead_band.setToolTip(
            "Raises the force slowly, 1.5 N at most, until the handle moves half a millimetre"
        )
        self.find_dead_band.hide()
        self.add_row(self.push, self.find_dead_band)

    def _judged(self, result: CheckResult) -> None:
        self.find_dead_band.setVisible(result.key == "no motion")
        self.push.setText("Push again")
        self.finish(result)
