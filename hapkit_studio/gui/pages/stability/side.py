"""The side of the stability page: the environment's sliders, a trial, the controller, other hands."""

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QCheckBox, QLabel, QPushButton, QWidget

from hapkit_studio.gui.pages.base import Pairs, SidePanel, hint
from hapkit_studio.gui.panel.parameter_panel import PanelTitle, ParameterRows, rule
from hapkit_studio.gui.studio import Studio
from hapkit_studio.gui.widgets.text import plain
from hapkit_studio.gui.widgets.theme import number

_HANDS = {"released": "Released", "light": "Light grip", "medium": "Medium grip", "firm": "Firm grip"}
_CONTROLLER = "Adds damping only while the scene gives more energy than it may."


class StabilitySide(SidePanel):
    """Emits ``release_pressed`` and ``controller_chosen(on)``."""

    release_pressed = Signal()
    controller_chosen = Signal(bool)

    def __init__(self, studio: Studio):
        super().__init__("")
        self._studio = studio
        self.heading.hide()
        self.words.hide()
        self.title = PanelTitle(studio)
        self.rows = ParameterRows(studio, self.title.help)
        self._put(self.title, rule(), self.rows)
        self.verticalScrollBar().rangeChanged.connect(self._make_way)
        self._trial()
        self._keep_stable()
        self.hands_heading = QLabel("Other hands")
        self.hands_heading.setProperty("role", "section")
        self.hands = Pairs()
        self._hands_line = rule()
        self._put(self._hands_line, self.hands_heading, self.hands)

    def show_hands(self, limits: dict[str, float], damping: float) -> None:
        """Show every hand's limit at the rendered damping."""
        self.hands_heading.setText(f"Limit by hand, at B = {number(damping, 1)} N·s/m")
        pairs = [(_HANDS[hand], f"{limit:,.0f} N/m") for hand, limit in limits.items() if limit == limit]
        none = [("Velocity filter", "not linear")] if limits else []
        self.hands.show_pairs(pairs or none)
        for part in (self._hands_line, self.hands_heading, self.hands):
            part.setVisible(bool(limits))

    def show_controller(self, on: bool) -> None:
        """Show whether the controller is on."""
        blocked = self.controller.blockSignals(True)
        self.controller.setChecked(on)
        self.controller.blockSignals(blocked)

    def show_trial(self, words: str, button: str, enabled: bool, said: str = "") -> None:
        """Say what a click on the map and the button do; said: what the last release showed."""
        self.try_words.setText(words)
        self.release.setText(button)
        self.release.setEnabled(enabled)
        self.outcome.setText(said)
        self.outcome.setVisible(bool(said))

    def set_room(self, narrow: bool) -> None:
        """Adapt the rows to a narrow panel."""
        self.rows.set_narrow(narrow)

    def _trial(self) -> None:
        self.section("Try it")
        self.try_words = hint()
        self.release = QPushButton("Release the handle here")
        self.release.clicked.connect(self.release_pressed)
        self.add(self.try_words)
        self.outcome = plain(QLabel())
        self.outcome.setWordWrap(True)
        self.add(self.release)
        self.add(self.outcome)

    def _keep_stable(self) -> None:
        self.section("Keep it stable")
        self.controller = QCheckBox("Passivity controller")
        self.controller.toggled.connect(self.controller_chosen)
        self._put(self.controller, hint(_CONTROLLER))

    def _make_way(self, _low: int, high: int) -> None:
        """Give the scroll bar the margin's place, so that rows keep their width."""
        margins = self._column.contentsMargins()
        bar = self.verticalScrollBar().sizeHint().width() if high > 0 else 0
        margins.setRight(max(margins.left() - bar, 0))
        self._column.setContentsMargins(margins)

    def _put(self, *parts: QWidget) -> None:
        for part in parts:
            self.add(part)
