"""The panel at the right: title, parameters, warnings, stability, loop."""

from PySide6.QtCore import QCoreApplication, QEvent, Qt
from PySide6.QtGui import QFont, QFontMetricsF, QResizeEvent
from PySide6.QtWidgets import QFrame, QHBoxLayout, QLabel, QScrollArea, QToolButton, QVBoxLayout, QWidget

from hapkit_studio.errors import ParameterError
from hapkit_studio.gui.gallery import icon_name
from hapkit_studio.gui.panel.loop import LoopPanel
from hapkit_studio.gui.panel.rows import ChoiceRow, ParameterRow
from hapkit_studio.gui.panel.stability_card import StabilityCard
from hapkit_studio.gui.panel.warnings import WarningLines
from hapkit_studio.gui.studio import Studio
from hapkit_studio.gui.widgets import icons
from hapkit_studio.gui.widgets.text import plain, rich
from hapkit_studio.gui.widgets.theme import theme
from hapkit_studio.parameters import AnyParameter, Choice

_SMALLEST = 14  # px: below that a title rather takes two lines
_SIDE, _TOP = 16, 10

Row = ParameterRow | ChoiceRow


class Title(QLabel):
    """Words in the title's font, smaller where the line would be too short for them."""

    def __init__(self, parent: QWidget | None = None):
        super().__init__(parent)
        plain(self).setWordWrap(True)

    def show_words(self, words: str) -> None:
        """Show other words."""
        self.setText(words)
        self._fit()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()

    def _fit(self) -> None:
        font = theme.font("title")
        while font.pixelSize() > _SMALLEST and self._needed(font) > self.width():
            font.setPixelSize(font.pixelSize() - 1)
        if font != self.font():
            self.setFont(font)

    def _needed(self, font: QFont) -> float:
        return QFontMetricsF(font).horizontalAdvance(self.text()) + 1.0


class PanelTitle(QWidget):
    """Icon, title and formula of the environment in force; "?" unfolds the explanation."""

    def __init__(self, studio: Studio, parent: QWidget | None = None):
        super().__init__(parent)
        self._studio = studio
        self.picture = QLabel()
        self.title = Title()
        self.formula = QLabel(textFormat=Qt.TextFormat.RichText)
        self.formula.setWordWrap(True)
        self.explanation = QLabel(textFormat=Qt.TextFormat.RichText)
        self.explanation.setWordWrap(True)
        self.explanation.setProperty("role", "hint")
        self.explanation.hide()
        self.help = QToolButton()
        self.help.setCheckable(True)
        self.help.setAccessibleName("Explain this environment")
        self.help.setToolTip("Explain this environment")
        self.help.toggled.connect(self.explanation.setVisible)
        icons.bind(self.help, "help", "ink2", 18)
        self._arrange()
        studio.environment_changed.connect(self.show_state)
        theme.changed.connect(self.show_state)
        self.show_state()

    def show_state(self) -> None:
        """Show the environment in force."""
        environment = self._studio.environment
        name = icon_name(environment.scene)
        self.picture.setPixmap(icons.pixmap(name, 24, "ink", self.devicePixelRatioF()))
        self.title.show_words(environment.title)
        upright = theme.font("formula")
        upright.setItalic(False)  # the formula itself says what is a symbol, so its words stay upright
        self.formula.setFont(upright)
        self.formula.setText(rich(environment.formula))
        self.explanation.setText(rich(environment.explanation))

    def _arrange(self) -> None:
        head = QHBoxLayout()
        head.setSpacing(6)
        head.addWidget(self.picture)
        head.addWidget(self.title, 1)
        head.addWidget(self.help)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(4)
        column.addLayout(head)
        column.addWidget(self.formula)
        column.addWidget(self.explanation)


class ParameterRows(QWidget):
    """One row per declared parameter of the environment in force."""

    def __init__(self, studio: Studio, anchor: QWidget, parent: QWidget | None = None):
        super().__init__(parent)
        self._studio = studio
        self._anchor = anchor
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
            for stop in row.tab_stops():
                if before.window() is stop.window():
                    QWidget.setTabOrder(before, stop)
                before = stop

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
        column = self._column = QVBoxLayout(body)
        column.setContentsMargins(_SIDE, _TOP, _SIDE, _TOP)
        column.setSpacing(6)
        environment = (self.title, rule(), self.parameters, self.warnings)
        for part in (*environment, rule(), self.stability, rule(), self.loop):
            column.addWidget(part)
        column.addStretch(1)
        self.setWidget(body)
        self.verticalScrollBar().rangeChanged.connect(self._leave_room_for_scroll_bar)
        self.stability.judged.connect(lambda *_: self._lay_out_now())

    def _lay_out_now(self) -> None:
        """Give a longer verdict its room at once: else a frame is painted with all rows squeezed."""
        for part in (self.stability, self._body, self):
            QCoreApplication.sendEvent(part, QEvent(QEvent.Type.LayoutRequest))

    def _leave_room_for_scroll_bar(self, _low: int, high: int) -> None:
        """Let the scroll bar stand in the margin, so that no row moves when it comes and goes."""
        bar = self.verticalScrollBar().sizeHint().width() if high > 0 else 0
        self._column.setContentsMargins(_SIDE, _TOP, max(_SIDE - bar, 0), _TOP)
