"""The dialog that flashes the firmware and shows progress and the board's answer."""

from functools import partial

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QComboBox, QLabel, QProgressBar, QPushButton, QWidget

from hapkit_studio.devices import DeviceEntry, avrdude, flash, serial_ports
from hapkit_studio.devices.avrdude import CONNECTING, VERIFYING, WRITING
from hapkit_studio.devices.flash import Flashed
from hapkit_studio.devices.hapkit import HapkitBoard
from hapkit_studio.errors import AvrdudeMissingError, ParameterError
from hapkit_studio.gui.state.background import Job, Progress
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.gui.widgets.dialogs import FormDialog
from hapkit_studio.gui.widgets.parts import choose_file

STAGES = (CONNECTING, WRITING, VERIFYING)
_WORDS = ("Looking for the board's boot loader…", "Writing the firmware…", "Verifying the firmware…")
_WHOLE = 100
PATIENCE = 5.0
"""s: maximum wait until the application's own loop has released the port."""
_ABOUT = (
    "Writes the firmware to the board and verifies it. The calibration of the kit is kept. First "
    "close other programs that use the port. The motor is off while this is done."
)


class FlashDialog(FormDialog):
    """A non-modal dialog that flashes a board.

    It cannot be closed while it writes. During this time the window does not use the port.
    """

    def __init__(self, studio: Studio, parent: QWidget | None = None):
        super().__init__("Flash firmware", _ABOUT, parent)
        self._studio = studio
        self._program: str | None = None
        self._flashed: Flashed | None = None
        self.job = Job(self, needs="", must_finish=True)
        self.ports, self.where, self.choose = QComboBox(), QLabel(), QPushButton("Choose a file…")
        self.ports.setPlaceholderText("No serial port found")
        self.bar = QProgressBar()
        self.again, self.write = QPushButton("Search ports again"), QPushButton("Flash firmware")
        self._arrange()
        self._join()
        self.refresh()

    # actions of the user

    def refresh(self) -> None:
        """List the ports and select the one in use; find avrdude."""
        self.ports.clear()
        self.write.setText("Flash firmware")
        own = self._own_port()
        for port in serial_ports.ports():
            self.ports.addItem(port.title, port.path)
        if own and self.ports.findData(own) < 0:
            self.ports.insertItem(0, serial_ports.port_name(own), own)
        self.ports.setCurrentIndex(max(self.ports.findData(own), 0) if self.ports.count() else -1)
        self._find()

    def begin(self) -> None:
        """Release the port and write the firmware."""
        port, program = self.ports.currentData(), self._program
        self._flashed = None
        if self._own_port() == port:
            self._studio.device.release_port("flashing firmware")

        def work(progress: Progress) -> Flashed:
            def follow(stage: str, part: float) -> None:
                progress(round(_WHOLE * (STAGES.index(stage) + part)), _WHOLE * len(STAGES))

            return flash.flash(port, program=program, progress=follow, patience=PATIENCE)

        self.verdict.show_text(_WORDS[0])
        self.job.start(work)

    def use(self, program: str) -> None:
        """Use the avrdude program at the path that the user has chosen."""
        self._program = program
        self._find()

    # events

    def _find(self) -> None:
        """Show where avrdude is, or how to get it; enable the button if all requirements are met."""
        try:
            found = str(avrdude.find(self._program).program)
        except AvrdudeMissingError as error:
            text = str(error).replace("give its path with --avrdude", "choose it here")
            self.verdict.show_text(text, "triangle", "warn")
            found = ""
        able, there = bool(found), self.ports.count() > 0
        if able:
            self.verdict.show_text(
                "Ready to flash the firmware."
                if there
                else "No serial port was found. Plug in the board, then press Search ports again."
            )
            try:
                flash.image_of()
            except ParameterError as error:
                self.verdict.show_text(str(error), "triangle", "danger")
                able = False
        self.where.setText(found or "This program was not found")
        self.write.setEnabled(able and there)
        self.ports.setEnabled(there)
        self.bar.setVisible(self.job.running or self._flashed is not None)

    def _follow(self, done: int, of: int) -> None:
        self.verdict.show_text(_WORDS[min(done // _WHOLE, len(_WORDS) - 1)])
        self.bar.setValue(max(done - _WHOLE, 0))

    def _written(self, result: Flashed) -> None:
        """Open the board again. Its answer is shown as soon as the board is connected."""
        self._flashed = result
        self.write.setText("Flash firmware")
        self._show_busy(False)
        port = self.ports.currentData()
        self.verdict.show_text(
            f"{result.size:,} bytes of firmware were written and verified. Starting the board…"
        )
        entry = next((e for e in self._studio.device.entries() if e.key == port), None)
        self._studio.device.open(
            entry or DeviceEntry(port, serial_ports.port_name(port), partial(HapkitBoard, port))
        )

    def _show_answer(self) -> None:
        """Show the flashed board's answer, or the reason why the board does not answer."""
        link, engine = self._studio.link, self._studio.engine
        if self._flashed is None or link.state in ("connecting", "idle", "preparing"):
            return
        flashed = self._flashed
        wrote = f"{flashed.size:,} bytes of firmware were written and verified in {flashed.seconds:.0f} s."
        if link.state != "running":
            self.verdict.show_text(f"{wrote} {link.text}", "triangle", "warn")
        elif engine is None:
            return  # this method is called again when there is an engine
        else:
            found = engine.device.about()
            text = (
                f"The board answers with firmware {found['firmware']}, protocol version {found['protocol']}."
            )
            self.verdict.show_text(f"{wrote} {text}", "check", "ok")
        self._flashed = None
        self._show_busy(False)

    def _failed(self, text: str) -> None:
        self.verdict.show_text(text, "triangle", "danger")
        self.write.setText("Flash firmware again")
        if self._studio.link.state == "idle":
            self._studio.device.reconnect()

    def _show_busy(self, running: bool) -> None:
        busy = running or self._flashed is not None
        for widget in (self.write, self.ports, self.choose, self.again, self.leave):
            widget.setEnabled(not busy)
        if running:
            self.bar.setValue(0)
            self.bar.show()

    def _own_port(self) -> str:
        """Return the port of the current device; "" if the device is not a board on a port."""
        engine, entry = self._studio.engine, self._studio.entry
        key = entry.key if entry is not None else ""
        path = engine.device.flash_port if engine is not None else key
        return path if serial_ports.is_path(path) else ""

    def reject(self) -> None:
        """Refuse to close while writing, because incomplete firmware would not work."""
        if not self.job.running:
            super().reject()

    # layout and connections

    def _join(self) -> None:
        self.write.clicked.connect(self.begin)
        self.again.clicked.connect(self.refresh)
        self.choose.clicked.connect(lambda: choose_file(self, "Choose the program avrdude", "", self.use))
        self.job.progressed.connect(self._follow)
        self.job.running_changed.connect(self._show_busy)
        self.job.finished.connect(self._written)
        self.job.failed.connect(self._failed)
        self._studio.link_changed.connect(self._show_answer)
        self._studio.engine_changed.connect(self._show_answer)

    def _arrange(self) -> None:
        self.add_fields((("Serial port", self.ports, None), ("Path of avrdude", self.where, self.choose)))
        self.add_verdict(3)
        self.verdict.label.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.bar.setRange(0, _WHOLE * (len(STAGES) - 1))
        self.bar.setTextVisible(False)
        self.bar.setFixedHeight(6)
        self.bar.setAccessibleName("Progress of flashing")
        self.column.addWidget(self.bar)
        self.add_buttons(self.write, (self.again,))
