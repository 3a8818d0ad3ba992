"""The button for the E-stop."""

from PySide6.QtWidgets import QWidget

from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.gui.widgets.shortcut_button import ShortcutButton
from hapkit_studio.gui.widgets.style import mark


class StopButton(ShortcutButton):
    """The E-stop button. It stops the motor when pressed down, not when released.

    While the motor is stopped, the button has no effect.
    """

    word_role = "stop"

    def __init__(self, studio: Studio, parent: QWidget | None = None):
        super().__init__("octagon", "E-STOP", "Esc", parent)
        self._studio = studio
        self.setProperty("stop", True)
        self.setAccessibleName("E-stop")
        self._row.insertStretch(0)
        self._row.addStretch()
        self.pressed.connect(studio.stop)
        self.clicked.connect(studio.stop)
        studio.stop_changed.connect(self.show_state)
        self.show_state()

    def show_state(self) -> None:
        """Show a red button while the motor may give a force, and only a red outline while it is stopped."""
        stopped = self._studio.stopped
        mark(self, "latched", stopped)
        self.set_appearance(
            "octagon", *(("STOPPED", "danger") if stopped else ("E-STOP", "onstop")), "onstop"
        )
        self.set_cap(not stopped)
        released = "Set the force to zero at once (Esc)"
        self.setToolTip("The force is off. Release the E-stop in the banner below." if stopped else released)
