"""The trigger's settings: the event, single or repeated mode, and the time that is shown before the event."""

from PySide6.QtWidgets import QPushButton, QWidget

from hapkit_studio.gui.live.trigger import EDGE, EVENT, LEVELS, PARAMETERS, Trigger
from hapkit_studio.gui.panel.rows import row_of
from hapkit_studio.gui.widgets.dialogs import FormDialog

_ABOUT = (
    "When the chosen event happens, the time plots stop and show the event. The scene, the loop and the "
    "recording continue. Backspace returns to the live plots."
)


class TriggerDialog(FormDialog):
    """The dialog with the trigger's settings; changes apply at once."""

    def __init__(self, trigger: Trigger, parent: QWidget | None = None):
        super().__init__("Trigger", _ABOUT, parent)
        self._trigger = trigger
        self.rows = {parameter.key: row_of(parameter) for parameter in PARAMETERS}
        for key, row in self.rows.items():
            row.show_value(trigger.values[key])
            row.changed.connect(trigger.set_value)
            self.column.addWidget(row)
        self.arm = QPushButton()
        self.arm.clicked.connect(trigger.toggle)
        self.add_buttons(self.arm)
        trigger.changed.connect(self._follow)
        self._follow()

    def _follow(self) -> None:
        level = self._trigger.level
        self.rows[EVENT.key].show_value(self._trigger.values[EVENT.key])
        for each in LEVELS:
            self.rows[each.parameter.key].setVisible(each is level)
        self.rows[EDGE.key].setVisible(level is not None)
        self.arm.setText("Stop waiting" if self._trigger.armed else "Wait for the event")
