"""Sensor: move the handle from end to end and see what the sensor says."""

from hapkit_studio.gui.wizard.board_dialog import Recent
from hapkit_studio.gui.wizard.board_thread import BoardThread
from hapkit_studio.gui.wizard.handle_view import HandleView
from hapkit_studio.gui.wizard.recent_plot import SensorPlot
from hapkit_studio.gui.wizard.step_page import StepPage
from hapkit_studio.protocol.messages import Sensor

SECONDS = 10.0
_USUAL = (0, 1023)
_SCALES = {Sensor.AS5048A: (0, 16383), Sensor.QUADRATURE: (-100, 100)}


class SensorStep(StepPage):
    """Finished by a track over both ends."""

    name = "Sensor"
    heading = "Sensor: move the handle from end to end"
    if_skipped = "the sensor works, and repeats as this kit's usually does"

    def __init__(self, board: BoardThread) -> None:
        super().__init__(board)
        self.add_text(
            "The motor is off. Hold the handle at its left end, press Start, then move it slowly to the "
            "right end and back, twice."
        )
        self.plot, self.handle = SensorPlot(), self.with_hand(HandleView())
        self.add_pictures(self.plot, self.handle)
        self.start_button = self.button(f"Start ({SECONDS:g} s)", self.start, primary=True)
        self.add_row(self.start_button)
        self.box.show_text("Waiting for you at the left end.")

    def show_recent(self, recent: Recent) -> None:
        bottom, top = _SCALES.get(Sensor(self.calibration.board.sensor), _USUAL)
        most = int(abs(recent.raw).max())  # an encoder goes as far as the handle does
        self.plot.show_readings(recent.time, recent.raw, min(bottom, -most) if bottom else 0, max(top, most))
        self.handle.show_handle(float(recent.position[-1]))

    def start(self) -> None:
        """Record, then judge."""
        self.run_job(
            "Move the handle: right end, left end, right end, left end…",
            lambda work: work.check_sensor(work.runner.record(SECONDS)),
            self.finish,
        )
