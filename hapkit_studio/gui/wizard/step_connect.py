"""The step Connect: the user connects only the USB cable, and chooses the kit."""

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QComboBox

from hapkit_studio.analysis.calibrate.result import PASS, passed
from hapkit_studio.devices import profiles
from hapkit_studio.devices.padding import Padding
from hapkit_studio.gui.wizard.board_dialog import SIGNS
from hapkit_studio.gui.wizard.board_thread import BoardThread
from hapkit_studio.gui.wizard.pictures import KitDrawing
from hapkit_studio.gui.wizard.step_page import StepPage
from hapkit_studio.protocol.messages import Origin


class ConnectStep(StepPage):
    """The user connects only the USB cable, and chooses the kit.

    If the step is skipped, the board's settings do not change.
    """

    padding_chosen = Signal(int)
    name = "Connect"
    heading = "Connect, and choose your kit"
    intro = (
        "1. Hold the board's connector with one hand and plug in the USB cable: a green light comes on.\n"
        "2. Leave the motor's 12 V supply unplugged until the step Direction.\n"
        "3. Choose your kit."
    )
    if_skipped = "The studio uses the kit that is set on the board."

    def __init__(self, board: BoardThread) -> None:
        super().__init__(board)
        self.column.addWidget(KitDrawing(supply=False), 1)
        self.kits = QComboBox()
        self.kits.setProperty("tall", True)
        self.kits.setAccessibleName("Kit")
        for kit in profiles.KITS:
            self.kits.addItem(kit.title, kit.key)
        self.first = self.take = self.button("Use this kit", self.use_kit, primary=True)
        self.add_row(self.kits, self.take)
        self.note, self.frames = self.add_text(), self.add_text()
        self.frames.hide()
        self.kits.currentIndexChanged.connect(lambda _index: self._show_note())
        self._show_note()

    def enter(self) -> None:
        """Show the board's current kit; from now on pad frames if padding makes them arrive earlier."""
        if self.calibration is None or self.result is not None:
            return
        now, found = self.calibration.original, self.calibration.padding
        kit = profiles.numbered(now.profile)
        self.kits.setCurrentIndex(profiles.KITS.index(kit) if kit else 0)
        self.frames.setVisible(found is not None)
        if found is not None:
            self.padding_chosen.emit(found.better)
            self.frames.setText(frame_text(found))
        stored = (
            "settings that were saved on it" if now.origin == Origin.STORED else "settings of the usual kit"
        )
        self.box.show_text(
            f"The board is connected. It uses the {stored}. The force is zero.", sign=SIGNS[PASS]
        )

    def reset(self) -> None:
        super().reset()
        self.enter()

    def use_kit(self) -> None:
        """Send the parameters of the chosen kit to the board."""
        kit = profiles.named(self.kits.currentData())
        if kit is profiles.numbered(self.calibration.board.profile):
            self.finish(passed(f"The board is already set to this kit: {kit.title}."))
        else:
            found = passed(f"The board is set to this kit: {kit.title}.")
            self.run_job(
                "Sending the settings…", lambda work: work.use_kit(kit), lambda _none: self.finish(found)
            )

    def _show_note(self) -> None:
        self.note.setText(profiles.named(self.kits.currentData()).note)


def frame_text(found: Padding) -> str:
    """Describe how frames are sent from now on, with the measured delays in ms."""
    plain, padded = (f"{1e3 * delay:.1f} ms" for delay in found)
    if found.better:
        return (
            f"Each USB message is filled up to {found.better} bytes, so the delay is {padded} instead "
            f"of {plain}."
        )
    return (
        f"The delay is {plain}. Longer USB messages would make the delay {padded}, so the messages stay "
        "short."
    )
