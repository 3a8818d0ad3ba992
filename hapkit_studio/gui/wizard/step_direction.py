"""Step 3: switch the motor's supply on; two small pulses say whether force and position agree."""

from hapkit_studio.analysis.calibrate.result import CheckResult
from hapkit_studio.gui.wizard.desk import Desk
from hapkit_studio.gui.wizard.kit_drawing import KitDrawing
from hapkit_studio.gui.wizard.page import Seen, StepPage
from hapkit_studio.gui.wizard.rail import Rail


class DirectionStep(StepPage):
    """Finished once pulses both ways moved the handle as they should."""

    title = "Direction: a push to the right goes to the right"
    assumed = "the direction that the board has; steps 4 and 5 wait until it is tried"

    def __init__(self, desk: Desk):
        super().__init__(desk)
        self.say(
            "Now plug in the motor's 12 V supply. Put the handle in the middle, hands off, then press Push: "
            "pulses of 0.1\u00a0N, 0.3\u00a0N at most, 80 ms long. A wrong sign would make a spring run away."
        )
        self.rail = self.with_hand(Rail())
        self.pictures(KitDrawing(usb=True, supply=True), self.rail)
        self.push = self.button("Push", self.begin, primary=True, motor=True)
        self.search = self.button("Look for a dead band", self.look, motor=True)
        self.search.setToolTip(
            "Raises the force slowly, 1.5 N at most, until the handle moves half a millimetre"
        )
        self.search.hide()
        self.row(self.push, self.search)
        self.column.addWidget(self.box)
        self.box.say("The motor is off until you press Push.")

    def show_seen(self, seen: Seen) -> None:
        self.rail.show_handle(float(seen.position[-1]), seen.force)

    def begin(self) -> None:
        """Push both ways."""
        self.do("Pushing, 0.3 N at most…", lambda work: work.try_direction(), self._judged)

    def look(self) -> None:
        """Raise the force until the handle moves."""
        self.do("Raising the force, 1.5 N at most…", lambda work: work.find_dead_band(), self._judged)

    def _judged(self, verdict: CheckResult) -> None:
        self.search.setVisible(verdict.key == "no motion")
        self.push.setText("Push again")
        self.show_verdict(verdict)
