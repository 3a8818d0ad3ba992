"""The dialog that exports the current environment as an Arduino sketch; it asks for kit, rate and file."""

from pathlib import Path

from PySide6.QtWidgets import QComboBox, QPushButton, QWidget

from hapkit_studio.analysis.stability import on_board
from hapkit_studio.devices import profiles
from hapkit_studio.dynamics import estimators
from hapkit_studio.errors import StudioError
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.gui.widgets.dialogs import FormDialog
from hapkit_studio.gui.widgets.parts import choose_file, label
from hapkit_studio.haptics.board_plan import spec_on_board
from hapkit_studio.protocol.messages import Origin
from hapkit_studio.workshop import sketch
from hapkit_studio.workshop.sketch import Kit

_ABOUT = (
    "Writes the environment with its present values as one readable Arduino sketch. The sketch "
    "runs on a Hapkit without the studio and needs no library."
)
_PRINTS = (("10 lines a second", 10), ("50 lines a second", 50), ("Nothing", 0))
_SAVED = {True: ("check", "ok"), False: ("triangle", "warn")}


class ExportDialog(FormDialog):
    """Asks for kit, rate and file without blocking the window.

    The sketch contains the parameters that are set when the user saves it.
    """

    def __init__(self, studio: Studio, parent: QWidget | None = None):
        super().__init__("Export for Arduino", _ABOUT, parent)
        self._studio = studio
        self.what, self.velocity = label(), label()
        self.kits, self.rates, self.prints = QComboBox(), QComboBox(), QComboBox()
        self.save = QPushButton("Save…")
        self._arrange()
        self.save.clicked.connect(self.ask)
        studio.settings_changed.connect(self.refresh)
        for box in (self.kits, self.rates):
            box.currentIndexChanged.connect(self.show_limit)
        self.refresh()

    def refresh(self) -> None:
        """Show the current settings of the sketch."""
        studio = self._studio
        self.what.setText(f"{studio.environment.title}, with the values of the panel")
        usual = sketch.usual_rate(studio.environment, studio.values)
        self.rates.setItemText(0, f"{usual:,} Hz, the usual rate of this environment")
        other = spec_on_board(studio.loop.estimator) != studio.loop.estimator
        name = estimators.parse(spec_on_board(studio.loop.estimator))[0].label
        self.velocity.setText(
            f"{name}, instead of the loop's velocity filter" if other else f"{name}, the same as in the loop"
        )
        self.show_limit()

    def show_limit(self) -> None:
        """Show the sketch's stiffness limit on its kit, and remarks on drift in single precision."""
        text, safe = self._limit()
        remarks = list(map(str, self._studio.environment.force.remarks))
        text = " ".join(["The sketch is not saved yet.", *filter(None, [text]), *remarks])
        self.verdict.show_text(text, *(() if safe and not remarks else ("triangle", "warn")))

    def _limit(self) -> tuple[str, bool]:
        """Return a text with limit and verdict, and whether the handle comes to rest."""
        studio = self._studio
        kit, spec = self.kits.currentData(), spec_on_board(studio.loop.estimator)
        rate = self.rates.currentData() or sketch.usual_rate(studio.environment, studio.values)
        found = on_board.sketch_verdict(studio.environment, studio.values, kit.board, rate, spec)
        return on_board.sketch_text(found, rate), found.calm

    def text(self) -> str:
        """Return the sketch's text; raise ParameterError or LawError if the sketch cannot be made."""
        studio = self._studio
        return sketch.text(
            studio.environment,
            studio.values,
            self.kits.currentData(),
            self.rates.currentData() or None,
            spec_on_board(studio.loop.estimator),
            self.prints.currentData(),
            self._limit()[0],
        )

    def write(self, wanted: str) -> None:
        """Write the sketch into a folder of the same name, as the Arduino IDE requires."""
        try:
            path = sketch.write_sketch(wanted, self.text(), over=True)
        except StudioError as error:
            self.verdict.show_text(str(error), "triangle", "danger")
            return
        except OSError as error:
            text = f"{Path(wanted).name} cannot be written: {error.strerror}."
            self.verdict.show_text(text, "triangle", "danger")
            return
        where = path.parent.parent
        saved = f"Saved {path.parent.name}/{path.name} in {where}."
        text = f"{saved} Open the sketch in the Arduino IDE and upload it."
        limit, safe = self._limit()
        self.verdict.show_text(text if safe else f"{text} {limit}", *_SAVED[safe])

    def ask(self) -> None:
        """Ask for the file in a non-modal dialog."""
        name = f"{self._studio.environment.key}.ino"
        choose_file(self, "Save the sketch", "Arduino sketch (*.ino)", self.write, save_as=name)

    # layout

    def _arrange(self) -> None:
        own = connected_kit(self._studio)
        if own is not None:
            state = "calibrated" if own.calibrated else "not calibrated"
            self.kits.addItem(f"Connected kit: {own.board.label}, {state}", own)
        for kit in profiles.KITS:
            self.kits.addItem(kit.title, Kit(kit.board))
        for text, rate in (("", 0), *((f"{rate:,} Hz", rate) for rate in sketch.RATES)):
            self.rates.addItem(text, rate)
        for text, number in _PRINTS:
            self.prints.addItem(text, number)
        self.add_fields(
            (
                ("Environment", self.what, None),
                ("Kit", self.kits, None),
                ("Servo rate", self.rates, None),
                ("Velocity estimate", self.velocity, None),
                ("Serial monitor", self.prints, None),
            )
        )
        self.add_verdict(3)
        self.add_buttons(self.save)


def connected_kit(studio: Studio) -> Kit | None:
    """Return the kit of the connected board with its settings; None if they are unknown."""
    driver = studio.engine.driver if studio.engine is not None else None
    settings = driver.planner.settings if driver is not None and driver.planner is not None else None
    if settings is None:
        return None
    return Kit(profiles.of_settings(settings), settings.origin in (Origin.STORED, Origin.UNSAVED))
