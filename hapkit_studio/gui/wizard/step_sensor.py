"""Step 1: move the handle from end to end and see what the sensor says."""

from hapkit_studio.analysis.calibrate.calibration import Calibration
from hapkit_studio.devices.board_runner import Track
from hapkit_studio.gui.wizard.desk import Desk
from hapkit_studio.gui.wizard.page import Seen, StepPage
from hapkit_studio.gui.wizard.rail import Rail
from hapkit_studio.gui.wizard.sensor_plot import SensorPlot
from hapkit_studio.protocol.messages import Sensor

SECONDS = 10.0
_USUAL = (0, 1023)
_SCALES = {Sensor.AS5048A: (0, 16383), Sensor.QUADRATURE: (-100, 100)}


class SensorStep(StepPage):
    """Finished by a track over both ends."""

    title = "Sensor: move the handle from end to end"
    assumed = "the sensor works, and repeats as this kit's usually does"

    def __init__(self, desk: Desk):
        super().__init__(desk)
        self.say(
            "The motor is off. Hold the handle at its left end, press Start, then move it slowly to the "
            "right end and back, twice."
        )
        self.plot, self.rail = SensorPlot(), self.with_hand(Rail())
        self.column.addWidget(self.plot, 1)
        self.column.addWidget(self.rail)
        self.begin = self.button(f"Start ({SECONDS:g} s)", self.start, primary=True)
        self.row(self.begin)
        self.column.addWidget(self.box)
        self.box.say("Waiting for you at the left end.")

    def show_seen(self, seen: Seen) -> None:
        bottom, top = _SCALES.get(Sensor(self.subject.board.sensor), _USUAL)
        most = int(abs(seen.raw).max())  # an encoder goes as far as the handle does
        self.plot.show_readings(seen.time, seen.raw, min(bottom, -most) if bottom else 0, max(top, most))
        self.rail.show_handle(float(seen.position[-1]))

    def start(self) -> None:
        """Record, then judge."""
        self.do(
            "Move the handle: right end, left end, right end, left end…",
            lambda work: work.check_sensor(self._record(work)),
            self.show_verdict,
        )

    @staticmethod
    def _record(work: "Calibration") -> Track:
        return work.runner.record(SECONDS)
