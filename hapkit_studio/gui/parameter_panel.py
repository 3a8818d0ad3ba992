"""The right-hand panel: environment's words and parameters, the loop, how far from instability."""

from PySide6.QtCore import QCoreApplication, QEvent, Qt
from PySide6.QtWidgets import QFrame, QScrollArea, QVBoxLayout, QWidget

from hapkit_studio.errors import ParameterError
from hapkit_studio.gui.choice_row import ChoiceRow
from hapkit_studio.gui.dress import dress
from hapkit_studio.gui.loop_panel import LoopPanel
from hapkit_studio.gui.model_line import ModelLine
from hapkit_studio.gui.panel_title import PanelTitle
from hapkit_studio.gui.parameter_row import ParameterRow
from hapkit_studio.gui.stability_card import StabilityCard
from hapkit_studio.gui.studio import Studio
from hapkit_studio.gui.warning_lines import WarningLines
from hapkit_studio.parameters import AnyParameter, Choice

WIDE, NARROW = 300, 272
_SIDE, _TOP = 16, 10
_ROW_HIGH, _CHOICE_HIGH, _WORDS_HIGH = 53, 34, 34
_USUAL_ROWS, _USUAL_HEIGHT = 3 * _ROW_HIGH + 2 * _CHOICE_HIGH, 900
"""The rows of the wall, for which the loop's own heights are; a window to begin with."""

Row = ParameterRow | ChoiceRow


class ParameterRows(QWidget):
    """One row per declared parameter of the environment in force."""

    def __init__(self, studio: Studio, anchor: QWidget, parent: QWidget | None = None):
        super().__init__(parent)
        self._studio = studio
        self._anchor = anchor
        self._narrow = False
        self.rows: dict[str, Row] = {}
        self._column = QVBoxLayout(self)
        self._column.setContentsMargins(0, 0, 0, 0)
        self._column.setSpacing(0)
        studio.environment_changed.connect(self.rebuild)
        studio.values_changed.connect(self.show_values)
        self.rebuild()

    def rebuild(self) -> None:
        """Make the rows anew for another environment."""
        for row in self.rows.values():
            self._column.removeWidget(row)
            row.hide()
            row.deleteLater()
        environment = self._studio.environment
        self.rows = {p.key: self._row(p, environment.formula) for p in environment.parameters}
        for row in self.rows.values():
            self._column.addWidget(row)
        self.set_narrow(self._narrow)
        self.show_values()
        self.order()

    def show_values(self) -> None:
        """Show the values in force, except in a box that holds a refused one; lock what has no effect."""
        unused = self._studio.environment.unused(self._studio.values)
        for key, row in self.rows.items():
            value = self._studio.values[key]
            if value != row.value:
                row.show_value(value)
            row.set_locked(unused.get(key, ""))

    def order(self) -> None:
        """Let Tab go through the rows in their order, right after the anchor."""
        before = self._anchor
        for row in self.rows.values():
            for stop in row.stops():
                if before.window() is stop.window():
                    QWidget.setTabOrder(before, stop)
                before = stop

    def set_narrow(self, narrow: bool) -> None:
        """Make do with a narrow panel, now and for rows to come."""
        self._narrow = narrow
        for row in self.rows.values():
            if isinstance(row, ParameterRow):
                row.set_narrow(narrow)

    def _row(self, parameter: AnyParameter, formula: str) -> Row:
        row: Row = (
            ChoiceRow(parameter, formula)
            if isinstance(parameter, Choice)
            else ParameterRow(parameter, formula)
        )
        row.changed.connect(self._apply)
        return row

    def _apply(self, key: str, value: float) -> None:
        try:
            self._studio.set_value(key, value)
        except ParameterError as error:
            row = self.rows[key]
            if isinstance(row, ParameterRow):
                row.show_error(str(error))


def rule() -> QFrame:
    """Return a hairline between two parts of the panel."""
    line = QFrame()
    line.setProperty("rule", True)
    line.setFixedHeight(1)
    return line


class ParameterPanel(QScrollArea):
    """The panel as a whole; scrolls inside itself where the window is low."""

    def __init__(self, studio: Studio, parent: QWidget | None = None):
        super().__init__(parent)
        self.setObjectName("panel")
        self.setWidgetResizable(True)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.title = PanelTitle(studio)
        self.parameters = ParameterRows(studio, self.title.help)
        self.warnings = WarningLines(studio)
        self.loop, self.stability = LoopPanel(studio), StabilityCard(studio)
        body = self._body = QWidget(self.viewport())
        body.setObjectName("panelBody")
        dress(body, "QLabel:disabled { color: @ink3; }")
        column = self._column = QVBoxLayout(body)
        column.setContentsMargins(_SIDE, _TOP, _SIDE, _TOP)
        column.setSpacing(6)
        self.model = ModelLine()
        self.model.chosen.connect(lambda name: studio.set_loop(model=name))
        self._studio = studio
        for signal in (studio.environment_changed, studio.engine_changed, studio.loop_changed):
            signal.connect(self._show_model)
        self._show_model()
        self._room = False, _USUAL_HEIGHT
        studio.environment_changed.connect(self._share_room)
        environment = (self.title, rule(), self.parameters, self.warnings)
        for part in (*environment, rule(), self.loop, self.model, rule(), self.stability):
            column.addWidget(part)
        column.addStretch(1)
        self.setWidget(body)
        self.verticalScrollBar().rangeChanged.connect(self._make_way)
        self.stability.judged.connect(lambda *_: self._settle())

    def _show_model(self) -> None:
        studio = self._studio
        self.model.show_model(studio.environment, studio.loop.model, studio.simulated)

    def _settle(self) -> None:
        """Give a longer verdict its room at once: else a frame is painted with all rows squeezed."""
        for part in (self.stability, self._body, self):
            QCoreApplication.sendEvent(part, QEvent(QEvent.Type.LayoutRequest))

    def _make_way(self, _low: int, high: int) -> None:
        """Let the scroll bar stand in the margin, so that no row moves when it comes and goes."""
        bar = self.verticalScrollBar().sizeHint().width() if high > 0 else 0
        self._column.setContentsMargins(_SIDE, _TOP, max(_SIDE - bar, 0), _TOP)

    def set_room(self, narrow: bool, height: int) -> None:
        """Give way in a narrow or low window."""
        self._room = narrow, height
        self.setFixedWidth(NARROW if narrow else WIDE)
        self.parameters.set_narrow(narrow)
        self._share_room()

    def _share_room(self) -> None:
        """Let the loop give way to an environment of many rows, so that the map stays in sight."""
        narrow, height = self._room
        environment = self._studio.environment
        rows = sum(_CHOICE_HIGH if isinstance(p, Choice) else _ROW_HIGH for p in environment.parameters)
        words = _WORDS_HIGH if environment.drives else 0
        self.loop.set_room(narrow, height - max(rows + words - _USUAL_ROWS, 0))
