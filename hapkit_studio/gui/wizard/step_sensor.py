"""The step Sensor: the user moves the handle from end to end, and the sensor is checked."""

from hapkit_studio.gui.wizard.board_dialog import Recent
from hapkit_studio.gui.wizard.board_thread import BoardThread
from hapkit_studio.gui.wizard.pictures import SensorPlot
from hapkit_studio.gui.wizard.step_page import StepPage
from hapkit_studio.protocol.messages import Sensor

RECORD_SECONDS = 10.0
_USUAL = (0, 1023)
_SCALES = {Sensor.AS5048A: (0, 16383), Sensor.QUADRATURE: (-100, 100)}


class SensorStep(StepPage):
    """The user moves the handle from end to end, and the sensor is checked."""

    name = "Sensor"
    heading = "Sensor: move the handle from end to end"
    intro = (
        "The motor is off. Hold the handle at its left end, press Start recording, then move it slowly to "
        "the right end and back, twice."
    )
    begin = "Hold the handle at the left end, then press Start recording."
    if_skipped = "The studio assumes that the sensor works and has the usual range of this kit."

    def __init__(self, board: BoardThread) -> None:
        super().__init__(board)
        self.plot = SensorPlot()
        self.add_handle(self.plot)
        self.first = self.start_button = self.job_button(
            f"Start recording ({RECORD_SECONDS:g} s)",
            "Move the handle to the right end, the left end, the right end and the left end…",
            lambda work: work.check_sensor(work.runner.record(RECORD_SECONDS)),
            self.finish,
            primary=True,
        )
        self.add_row(self.start_button)

    def show_recent(self, recent: Recent) -> None:
        super().show_recent(recent)
        bottom, top = _SCALES.get(Sensor(self.calibration.board.sensor), _USUAL)
        most = int(abs(recent.raw).max())  # an encoder's range depends on how far the handle was moved
        self.plot.show_readings(recent.time, recent.raw, min(bottom, -most) if bottom else 0, max(top, most))
