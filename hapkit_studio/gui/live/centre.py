"""The middle of the Live view: scene on top, time plots and force–position below."""

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QComboBox,
    QFrame,
    QHBoxLayout,
    QPushButton,
    QStackedWidget,
    QVBoxLayout,
    QWidget,
)

from hapkit_studio.gui.actions import SPANS
from hapkit_studio.gui.live.phase_plot import ForcePosition
from hapkit_studio.gui.live.time_plots import TimePlots
from hapkit_studio.gui.scenes import SceneView
from hapkit_studio.gui.widgets import icons
from hapkit_studio.gui.widgets.segmented import Segmented

GAP = 12
PHASE_WIDTH = 348
NARROW = 720
WIDE = 1240  # room for a law and the force–position plot side by side
_EDGE = 1  # the card's line
_VIEWS = ("Time", "Force–position")


def card(parent: QWidget) -> QFrame:
    """Return an empty card."""
    frame = QFrame(parent)
    frame.setProperty("card", True)
    return frame


def _filled(widget: QWidget, parent: QWidget) -> QFrame:
    frame = card(parent)
    column = QVBoxLayout(frame)
    column.setContentsMargins(0, 0, 0, 0)
    column.addWidget(widget)
    return frame


class Toolbar(QWidget):
    """Time window and axes of the time plots; where room is short it also switches between the plots."""

    span_chosen = Signal(float)
    fit_pressed = Signal()

    def __init__(self, parent: QWidget | None = None):
        super().__init__(parent)
        self.span = QComboBox()
        self.span.addItems([f"{seconds:g} s" for seconds in SPANS])
        self.span.setAccessibleName("Time window")
        self.span.setToolTip("How much of the past is shown")
        self.span.activated.connect(lambda index: self.span_chosen.emit(SPANS[index]))
        self.views = Segmented("Plot", _VIEWS)
        self.views.show_index(0)
        self.views.hide()
        self.fit = QPushButton("Fit axes")
        self.fit.setProperty("flat", True)
        self.fit.setToolTip("Narrow the axes to what is shown (F)")
        self.fit.clicked.connect(self.fit_pressed)
        icons.bind(self.fit, "fit", "ink2", 18)
        row = QHBoxLayout(self)
        row.setContentsMargins(10, 5, 10, 5)
        row.setSpacing(8)
        row.addWidget(self.span)
        row.addWidget(self.views)
        row.addStretch(1)
        row.addWidget(self.fit)

    def show_span(self, seconds: float) -> None:
        """Show the time window in force."""
        self.span.setCurrentIndex(SPANS.index(seconds))


class Centre(QWidget):
    """Scene and plots; ``set_room`` decides what gives way."""

    def __init__(self, parent: QWidget | None = None):
        super().__init__(parent)
        self.scene, self.time, self.phase = SceneView(), TimePlots(), ForcePosition()
        self.toolbar = Toolbar()
        self.scene_card = _filled(self.scene, self)
        self.time_card, self.phase_card = card(self), _filled(self.phase, self)
        self.stack = QStackedWidget(self.time_card)
        self._narrow = False
        self._page: QWidget | None = None
        self._page_wants: tuple[bool, bool] = (True, False)
        self._room = (0, 0)
        self._arrange()
        self.toolbar.views.chosen.connect(self.stack.setCurrentIndex)
        self.time.pointed.connect(self.phase.point)

    def set_room(self, width: int, height: int) -> None:
        """Lay out for the room there is, margins included."""
        self._room = width, height
        narrow = width < NARROW
        if narrow != self._narrow:
            self._narrow = narrow
            self._move_phase()
        free = height - 3 * GAP
        wants_scene, wants_phase = self._page_wants
        scene = self.scene.wanted_height if free >= 680 else 180 if free >= 480 else 150
        if self._page is not None:
            scene = 180 if free >= 680 and wants_phase else 150
        self.scene_card.setFixedHeight(scene + 2 * _EDGE)
        self.scene_card.setVisible(wants_scene)
        self.time_card.setVisible(self._page is None)
        if not narrow:
            self.phase_card.setVisible(self._page is None or (wants_phase and width >= WIDE))

    def refit(self) -> None:
        """Lay out anew: another scene may want another height."""
        self.set_room(*self._room)

    def take_page(self, page: QWidget) -> None:
        """Give a page its place beside the plots', out of sight for now."""
        page.hide()
        self._lower.insertWidget(0, page, 1)

    def show_page(self, page: QWidget | None, scene: bool = True, phase: bool = False) -> None:
        """Show a page that was taken in the plots' place, None for the plots.

        scene, phase: whether the scene, and where there is room the force–position plot, stay in sight.
        """
        if self._page is not None and self._page is not page:
            self._page.hide()
        self._page, self._page_wants = page, (scene, phase)
        if page is not None:
            page.show()
        self.refit()

    def refresh(self) -> None:
        """Draw the newest data into the plots that are seen."""
        if self.time.isVisible():
            self.time.refresh()
        if self.phase.isVisible():
            self.phase.refresh()

    def _move_phase(self) -> None:
        self.toolbar.views.setVisible(self._narrow)
        if self._narrow:
            self.phase_card.setMinimumWidth(0)
            self.phase_card.setMaximumWidth(16777215)
            self.phase_card.setProperty("card", False)
            self.stack.addWidget(self.phase_card)
            self.stack.setCurrentIndex(self.toolbar.views.index)
        else:
            self.stack.removeWidget(self.phase_card)
            self.phase_card.setProperty("card", True)
            self.phase_card.setFixedWidth(PHASE_WIDTH)
            self._lower.addWidget(self.phase_card)
            self.phase_card.show()
        self.phase_card.style().unpolish(self.phase_card)
        self.phase_card.style().polish(self.phase_card)

    def _arrange(self) -> None:
        inside = QVBoxLayout(self.time_card)
        inside.setContentsMargins(1, 1, 1, 1)
        inside.setSpacing(0)
        inside.addWidget(self.toolbar)
        line = QFrame()
        line.setProperty("rule", True)
        line.setFixedHeight(1)
        inside.addWidget(line)
        self.stack.addWidget(self.time)
        inside.addWidget(self.stack, 1)
        self.phase_card.setFixedWidth(PHASE_WIDTH)
        self._lower = QHBoxLayout()
        self._lower.setSpacing(GAP)
        self._lower.addWidget(self.time_card, 1)
        self._lower.addWidget(self.phase_card)
        column = QVBoxLayout(self)
        column.setContentsMargins(GAP, GAP, GAP, GAP)
        column.setSpacing(GAP)
        column.addWidget(self.scene_card)
        column.addLayout(self._lower, 1)
        self.setAutoFillBackground(False)
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.setObjectName("centre")
