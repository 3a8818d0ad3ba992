"""The step Direction: motor pulses test whether force and position have the same sign."""

from hapkit_studio.analysis.calibrate.result import CheckResult
from hapkit_studio.gui.wizard.board_thread import BoardThread
from hapkit_studio.gui.wizard.pictures import KitDrawing
from hapkit_studio.gui.wizard.step_page import StepPage


class DirectionStep(StepPage):
    """The user switches on the motor's supply; small pulses test whether force and position agree."""

    pushes = True
    name = "Direction"
    heading = "Direction: a push to the right moves the handle to the right"
    intro = (
        "Plug in the motor's 12 V supply. Put the handle in the middle, take your hands off, then press "
        "Push the handle. "
        "The motor gives short pulses of at most 0.3\u00a0N. With the wrong direction, a spring would push "
        "the handle away."
    )
    begin = "The motor is off until you press Push the handle."
    if_skipped = (
        "The studio uses the board's present direction, but you cannot do the steps Strength and Friction."
    )

    def __init__(self, board: BoardThread) -> None:
        super().__init__(board)
        self.add_handle(KitDrawing(supply=True))
        self.push = self.job_button(
            "Push the handle", "Pushing with at most 0.3 N…", lambda work: work.try_direction(), self._judged,
            primary=True, motor=True,
        )  # fmt: skip
        self.find_dead_band = self.job_button(
            "Look for a dead band", "Raising the force to at most 1.5 N…", lambda work: work.find_dead_band(),
            self._judged, motor=True,
        )  # fmt: skip
        self.find_dead_band.setToolTip(
            "A dead band is a range of small forces that do not move the handle. The force rises slowly, "
            "to at most 1.5 N, until the handle moves half a millimetre"
        )
        self.find_dead_band.hide()
        self.add_row(self.push, self.find_dead_band)

    def _judged(self, result: CheckResult) -> None:
        self.find_dead_band.setVisible(result.key == "no motion")
        self.push.setText("Push the handle again")
        self.finish(result)
