"""Step 0: plug in USB only, and say which kit it is."""

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QCheckBox, QComboBox, QLabel

from hapkit_studio.analysis.calibrate.result import passed
from hapkit_studio.devices import profiles
from hapkit_studio.gui.widgets.style import dress
from hapkit_studio.gui.wizard.desk import Desk
from hapkit_studio.gui.wizard.kit_drawing import KitDrawing
from hapkit_studio.gui.wizard.page import BIG, StepPage
from hapkit_studio.protocol.messages import Origin


class ConnectStep(StepPage):
    """Finished once a kit was taken; skipped, the board's own numbers stay."""

    padding_wished = Signal(int)
    title = "Connect, and choose your kit"
    assumed = "the kit that the board takes itself for"

    def __init__(self, desk: Desk):
        super().__init__(desk)
        self._size = 0
        self.say(
            "1. Plug in USB, and hold the board's connector with the other hand: a green light comes on.\n"
            "2. Leave the motor's 12 V supply unplugged until step 3.\n"
            "3. Choose your kit."
        )
        self.column.addWidget(KitDrawing(usb=True, supply=False), 1)
        self.kits = QComboBox()
        self.kits.setProperty("tall", True)
        self.kits.setAccessibleName("Kit")
        for kit in profiles.KITS:
            self.kits.addItem(kit.title, kit.key)
        dress(self.kits, "QComboBox { font-size: 14px; min-width: 260px; }")
        self.take = self.button("Use this kit", self.choose, primary=True)
        self.row(self.kits, self.take)
        self.note = QLabel()
        self.note.setWordWrap(True)
        dress(self.note, BIG)
        self.column.addWidget(self.note)
        self.padded = QCheckBox()
        self.padded.hide()
        dress(self.padded, "QCheckBox { font-size: 14px; }")
        self.column.addWidget(self.padded)
        self.column.addWidget(self.box)
        self.padded.toggled.connect(lambda on: self.padding_wished.emit(self._size if on else 0))
        self.kits.currentIndexChanged.connect(lambda _index: self._note())
        self._note()

    def enter(self) -> None:
        """Show the kit that the board takes itself for."""
        if self.desk.subject is None or self.verdict is not None:
            return
        now = self.subject.original
        kit = profiles.numbered(now.profile)
        self.kits.setCurrentIndex(profiles.KITS.index(kit) if kit else 0)
        stored = "has stored settings" if now.origin == Origin.STORED else "has the usual kit's settings"
        self._offer_padding()
        self.box.say(f"Connected. The board {stored}. Force is zero.", "", "check", "ok")

    def _offer_padding(self) -> None:
        """Offer to fill the frames where that shortens the delay of this computer's USB."""
        found = self.subject.padding
        self._size = found.better if found is not None else 0
        self.padded.setVisible(self._size > 0)
        if found is not None:
            delays = f"{1e3 * found.padded:.1f} ms instead of {1e3 * found.plain:.1f} ms"
            self.padded.setText(f"Fill frames to {self._size} bytes: delay {delays}")

    def withdraw(self) -> None:
        super().withdraw()
        self.enter()

    def choose(self) -> None:
        """Take the kit's numbers."""
        kit = profiles.named(self.kits.currentData())
        if kit is profiles.numbered(self.subject.board.profile):
            self.show_verdict(passed(f"{kit.title}: as the board has it."))
        else:
            self.do("Telling the board…", lambda work: work.use_kit(kit), lambda _none: self._chosen(kit))

    def _chosen(self, kit: profiles.Kit) -> None:
        self.show_verdict(passed(f"The board is set to this kit: {kit.title}."))

    def _note(self) -> None:
        self.note.setText(profiles.named(self.kits.currentData()).note)
