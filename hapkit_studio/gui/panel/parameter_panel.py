"""The panel on the right: title, parameters, loop, warnings and stability."""

import re

from PySide6.QtCore import QCoreApplication, QEvent, QObject, QPoint, QRect, Qt, QTimer
from PySide6.QtGui import QFontMetricsF, QHideEvent, QResizeEvent, QShowEvent
from PySide6.QtWidgets import QFrame, QLabel, QToolButton, QWidget

from hapkit_studio.errors import ParameterError
from hapkit_studio.gui.panel.loop import LoopPanel
from hapkit_studio.gui.panel.preset_row import PresetRow, Presets
from hapkit_studio.gui.panel.rows import ParameterRow, Row, row_of
from hapkit_studio.gui.panel.stability_card import StabilityCard
from hapkit_studio.gui.panel.two_settings import TwoSettings, TwoSettingsRow
from hapkit_studio.gui.panel.warnings import WarningLines
from hapkit_studio.gui.state.stored import StoredSettings
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.gui.widgets import icons
from hapkit_studio.gui.widgets.gallery_row import icon_name
from hapkit_studio.gui.widgets.parts import SIDE, ScrollColumn, Sign, hbox, label, refill, rule, vbox
from hapkit_studio.gui.widgets.text import rich, show_formula
from hapkit_studio.gui.widgets.theme import theme

_SMALLEST = 14  # px: smallest font of a title; a longer title is wrapped
# px: minimum height of title and first parameters; if less height is left, the stability map is hidden
_UPPER = 200
# px: size and gap of the card with the whole explanation, which is shown beside the panel
_CARD_WIDE, _CARD_GAP = 320, 8


class Title(QLabel):
    """A title whose font becomes smaller if the line is too long."""

    def __init__(self) -> None:
        super().__init__(textFormat=Qt.TextFormat.PlainText, wordWrap=True)

    def show_text(self, text: str) -> None:
        """Change the title."""
        self.setText(text)
        self._fit()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()

    def _fit(self) -> None:
        font = theme.font("title")
        while (
            font.pixelSize() > theme.px(_SMALLEST)
            and QFontMetricsF(font).horizontalAdvance(self.text()) + 1.0 > self.width()
        ):
            font.setPixelSize(font.pixelSize() - 1)
        if font != self.font():
            self.setFont(font)


class PanelTitle(QWidget):
    """Shows icon, title, formula and first sentence of the explanation of the current environment.

    The button "?" shows the whole explanation on a card beside the panel, so that the controls do not move.
    """

    def __init__(self, studio: Studio):
        super().__init__()
        self._studio = studio
        self.picture, self.title = Sign(24), Title()
        self.formula, self.explanation = label(), label(role="hint")
        for part in (self.formula, self.explanation):
            part.setTextFormat(Qt.TextFormat.RichText)
        self.help = QToolButton()
        self.help.setCheckable(True)
        self.help.setToolTip("Explain this environment")
        self.help.setAccessibleName("Explain this environment")
        self.help.toggled.connect(self.show_explanation)
        self.card, self.whole = QFrame(self), label()
        self.card.setProperty("card", True)
        self.card.hide()
        self.whole.setTextFormat(Qt.TextFormat.RichText)
        vbox(self.whole, into=self.card, margins=(14, 10, 14, 12))
        icons.bind(self.help, "help", "ink2", 18)
        head = hbox(self.picture, (self.title, 1), self.help, gap=6)
        vbox(head, self.formula, self.explanation, into=self, gap=4)
        studio.environment_changed.connect(self.show_state)
        theme.changed.connect(self.show_state)
        self.show_state()

    def show_state(self) -> None:
        """Show the current environment."""
        environment = self._studio.environment
        self.picture.show_sign(icon_name(environment.scene), "ink")
        self.title.show_text(environment.title)
        show_formula(self.formula, environment.formula)
        self.formula.setToolTip(rich(environment.explained_formula))
        self.show_explanation()

    def show_explanation(self) -> None:
        """Show the first sentence, or the whole explanation while "?" is pressed."""
        environment = self._studio.environment
        text = environment.explanation or environment.summary
        first, *more = re.split(r"(?<=[.!?])\s+", text, maxsplit=1)
        self.explanation.setText(rich(first))
        self.explanation.setVisible(bool(text))
        self.help.setEnabled(bool(more))
        self.whole.setText(rich(text))
        self._place_card()

    def _place_card(self) -> None:
        """Show the card at the left of the panel if "?" is pressed."""
        card, window = self.card, self.window()
        shown = self.help.isChecked() and self.isVisible() and self.help.isEnabled()
        if shown:
            if card.parent() is not window:
                card.setParent(window)
                window.installEventFilter(self)
            wide = theme.px(_CARD_WIDE)
            place = self.mapTo(window, QPoint(-theme.px(SIDE) - wide - theme.px(_CARD_GAP), 0))
            card.setGeometry(QRect(max(place.x(), 0), place.y(), wide, card.heightForWidth(wide)))
            card.raise_()
        card.setVisible(shown)

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        self._place_card()

    def hideEvent(self, event: QHideEvent) -> None:
        super().hideEvent(event)
        self.card.hide()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Move the card with the panel when the window's size has changed and the layout is done."""
        if event.type() == QEvent.Type.Resize and self.help.isChecked():
            QTimer.singleShot(0, self, self._place_card)
        return super().eventFilter(watched, event)


class ParameterRows(QWidget):
    """Shows one row for each parameter of the current environment."""

    def __init__(self, studio: Studio, anchor: QWidget):
        super().__init__()
        self._studio, self._anchor = studio, anchor
        self.rows: dict[str, Row] = {}
        self._column = vbox(into=self)
        studio.environment_changed.connect(self.rebuild)
        for signal in (studio.values_changed, studio.lock_changed):
            signal.connect(self.show_values)
        studio.ranges_changed.connect(self.show_ranges)
        self.rebuild()

    def rebuild(self) -> None:
        """Create the rows of the current environment after a change of environment."""
        environment = self._studio.environment
        formula = (
            f"{environment.formula}, with {environment.symbols}."
            if environment.symbols
            else environment.formula
        )
        self.rows = {p.key: row_of(p, formula) for p in environment.parameters}
        for row in self.rows.values():
            row.changed.connect(self._apply)
        refill(self._column, self.rows.values())
        self.show_values()
        self.show_ranges()
        self.order()

    def show_values(self) -> None:
        """Show the current values; lock the rows that have no effect."""
        unused = self._studio.environment.unused(self._studio.values)
        for key, row in self.rows.items():
            row.show_value(self._studio.values[key])
            fixed = self._studio.why_fixed("value", self._studio.environment.key, key)
            row.set_locked(fixed or unused.get(key, ""), padlock=bool(fixed))

    def show_ranges(self) -> None:
        """Hatch the unstable ranges of the sliders."""
        for key, row in self.rows.items():
            if isinstance(row, ParameterRow):
                row.show_ranges(self._studio.unstable_ranges.get(key, ()))

    def order(self) -> None:
        """Set the tab order: the anchor, then the rows."""
        before = self._anchor
        for row in self.rows.values():
            for stop in row.tab_stops():
                if before.window() is stop.window():
                    QWidget.setTabOrder(before, stop)
                before = stop

    def _apply(self, key: str, value: float) -> None:
        try:
            self._studio.set_value(key, value)
        except ParameterError as error:
            row = self.rows[key]
            if isinstance(row, ParameterRow):
                row.show_error(str(error))


class ParameterPanel(QWidget):
    """The whole panel.

    The settings A and B, warnings and verdict stay visible at the bottom; the rest scrolls.

    If the panel is not high enough, the map below the verdict is hidden.
    """

    def __init__(
        self, studio: Studio, presets: Presets, two: TwoSettings, settings: StoredSettings, parent: QWidget
    ):
        super().__init__(parent)
        self.setObjectName("panelBody")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.upper, self._foot = ScrollColumn(top=10, gap=6), QWidget(self)
        vbox((self.upper, 1), self._foot, into=self)
        self.title = PanelTitle(studio)
        self.parameters = ParameterRows(studio, self.title.help)
        self.preset, self.two = PresetRow(studio, presets), TwoSettingsRow(two)
        self.loop, self.stability = LoopPanel(studio, settings), StabilityCard(studio)
        self.warnings = WarningLines(studio, self.stability.facts)
        self._rule = rule()
        self.upper.add(self.title, self._rule, self.parameters, self.preset, rule(), self.loop)
        foot = self.two, rule(), self.warnings, self.stability
        vbox(*foot, into=self._foot, margins=(SIDE, 0, SIDE, 10), gap=6)
        self.stability.judged.connect(lambda *_: self._lay_out_now())
        self.warnings.changed.connect(self._lay_out_now)
        self.loop.opened.connect(self.upper.reveal)
        studio.environment_changed.connect(self._show_top)
        studio.lock_changed.connect(lambda: self._hide_values("values" in studio.permissions.left_out))
        self._show_top()

    def _hide_values(self, on: bool) -> None:
        for part in (self.parameters, self.preset):
            part.setHidden(on)

    def _show_top(self) -> None:
        """Scroll to the top for a new environment; hide the horizontal line if it has no parameters."""
        self.upper.verticalScrollBar().setValue(0)
        self._rule.setVisible(bool(self.parameters.rows))

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._lay_out_now()

    def _lay_out_now(self) -> None:
        """Lay out immediately: otherwise one frame would show only a part of a verdict that became longer."""
        self.stability.show_map(True)
        upper = self.height() - self._foot.heightForWidth(self.width())
        if self.two.isHidden():  # reserve the row's height, so that the map stays visible when it appears
            upper -= self.two.sizeHint().height()
        self.stability.show_map(upper >= theme.px(_UPPER))
        for part in (*self.stability.verdict.lines, self.stability.verdict, self.stability, self._foot, self):
            QCoreApplication.sendEvent(part, QEvent(QEvent.Type.LayoutRequest))
