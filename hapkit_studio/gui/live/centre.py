"""The middle of the Live view: the scene at the top, time plots and force–position plot below it."""

from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QComboBox, QFrame, QPushButton, QSplitter, QStackedWidget, QWidget

from hapkit_studio.formatting import compact
from hapkit_studio.gui.live.kept_curves import KeptCurveList, KeptCurves
from hapkit_studio.gui.live.phase_plot import ForcePosition
from hapkit_studio.gui.live.time_plots import TimePlots
from hapkit_studio.gui.live.time_view import SPANS, TimeView
from hapkit_studio.gui.live.trigger import Trigger
from hapkit_studio.gui.scenes import SceneView
from hapkit_studio.gui.state.stored import StoredSettings
from hapkit_studio.gui.widgets import breakpoints, icons
from hapkit_studio.gui.widgets.breakpoints import GAP
from hapkit_studio.gui.widgets.parts import hbox, vbox
from hapkit_studio.gui.widgets.segmented import Segmented
from hapkit_studio.gui.widgets.theme import theme

_EDGE = 1  # px: width of the card's border
_VIEWS = ("Time plots", "Force plot")


def card(parent: QWidget, *widgets: QWidget, edge: int = 0) -> QFrame:
    """Return a card with widgets stacked vertically; the last widget takes the extra height."""
    frame = QFrame(parent)
    frame.setProperty("card", True)
    if widgets:
        vbox(*widgets[:-1], (widgets[-1], 1), into=frame, margins=(edge,) * 4)
    return frame


def fill(splitter: QSplitter, gap: int, stretched: int, *parts: QWidget) -> None:
    """Fill a splitter with parts ``gap`` px apart; only the part with index ``stretched`` grows."""
    splitter.setHandleWidth(gap)
    splitter.setChildrenCollapsible(False)
    for part in parts:
        splitter.addWidget(part)
    splitter.setStretchFactor(stretched, 1)


def _flat(icon: str, tip: str) -> QPushButton:
    """Return a flat toolbar button whose label can be hidden."""
    button = QPushButton()
    button.setProperty("flat", True)
    button.setProperty("tool", True)
    button.setToolTip(tip)
    icons.bind(button, icon, "ink2", 18)
    return button


class Toolbar(QWidget):
    """The time plots' toolbar: time window, cursors, kept curves, fit, release of the simulated hand."""

    def __init__(self) -> None:
        super().__init__()
        self.span = QComboBox()
        self.span.addItems([f"{seconds:g} s" for seconds in SPANS])
        self.span.setMinimumContentsLength(5)
        self.span.setAccessibleName("Time shown in the plots")
        self.span.setToolTip("How many seconds of the past the plots show")
        self.views = Segmented("Plots shown", _VIEWS)
        self.views.show_index(0)
        self.cursors = _flat("cursors", "Measure between two moments: drag the cursors A and B (keys A, B)")
        self.cursors.setCheckable(True)
        self.keep = _flat("hold", "Keep these curves in the background, to compare them with new ones (H)")
        self.release = _flat("hand", "Release the simulated handle where it is now, with zero speed (L)")
        self.fit = _flat("fit", "Fit the axes to the data and to the nearest object (F)")
        self._names = {self.fit: "Fit axes", self.release: "Release handle"}
        self._names |= {self.cursors: "Cursors", self.keep: "Keep curves"}
        for button, name in self._names.items():
            button.setAccessibleName(name)
        self._hand = True
        self.set_narrow(False)
        left, right = (self.span, self.views, self.cursors, self.keep), (self.release, self.fit)
        hbox(*left, None, *right, into=self, margins=(8, 5, 4, 5), gap=1)

    def set_narrow(self, narrow: bool) -> None:
        """Show the switch between the plots if ``narrow``; otherwise hide it, because both plots fit."""
        self.views.setVisible(narrow)
        self._fit_buttons()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit_buttons()

    def minimumSizeHint(self) -> QSize:
        """Return only the minimum height, because labels and buttons that do not fit are hidden."""
        return QSize(0, super().minimumSizeHint().height())

    def _fit_buttons(self) -> None:
        """Show all labels if they fit, otherwise icons; if these do not fit, hide less important buttons."""
        extra, used = (self.keep, self.release), self.layout()
        for labelled, more in ((True, True), (False, True), (False, False)):
            for button, name in self._names.items():
                button.setText(name if labelled else "")
                button.setVisible(
                    (more or button not in extra) and (button is not self.release or self._hand)
                )
            if used is None or used.totalSizeHint().width() <= self.width():
                return

    def show_span(self, seconds: float) -> None:
        """Show the time window in s; its length need not be one of SPANS."""
        self.span.setPlaceholderText(f"{compact(seconds, 2)} s")
        self.span.setCurrentIndex(SPANS.index(seconds) if seconds in SPANS else -1)

    def show_release(self, on: bool) -> None:
        """Show or hide the button that releases the simulated hand."""
        self._hand = on
        self._fit_buttons()


class Centre(QWidget):
    """Shows the scene above the plots, and saves the positions of the splitters."""

    def __init__(self, settings: StoredSettings, parent: QWidget | None = None):
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        # set this first, because the children are styled by this name when they are created
        self.setObjectName("centre")
        self.view = TimeView(self)
        self.trigger = Trigger(self.view, self)
        self.scene, self.time = SceneView(), TimePlots(self.view)
        self.phase = ForcePosition(self.time.cursors)
        self.toolbar = Toolbar()
        self.rows = QSplitter(Qt.Orientation.Vertical, self)
        self.stack, line = QStackedWidget(), QFrame()
        self.stack.addWidget(self.time)
        line.setProperty("rule", True)
        line.setFixedHeight(1)
        self.scene_card, self.columns = card(self.rows, self.scene), QSplitter(self.rows)
        self.phase_card = card(self.columns, self.phase)
        self.kept_curves = KeptCurves(self)
        self.time_card = card(
            self.columns, self.toolbar, line, KeptCurveList(self.kept_curves), self.stack, edge=_EDGE
        )
        self._line, self.values_card = line, card(self.columns)
        self._narrow, self._settings, self._projected = False, settings, False
        self._page: QWidget | None = None
        self._shows_scene, self._is_law = True, False
        self._scene_height = settings.pixels("scene_height", 0.0)  # 0 means the default height
        self._phase_width = settings.pixels("phase_width", 0.0)
        fill(self.columns, GAP, 0, self.time_card, self.phase_card, self.values_card)
        fill(self.rows, GAP, 1, self.scene_card, self.columns)
        vbox(self.rows, into=self, margins=(GAP,) * 4)
        self.scene.set_hint(not settings.flag("dragged", False))
        self.scene.grabbed.connect(lambda: settings.setValue("dragged", True))
        self.toolbar.views.chosen.connect(self.stack.setCurrentIndex)
        self.time.pointed.connect(self.phase.point)
        for plots in (self.time, self.phase.canvas):
            self.kept_curves.changed.connect(plots.set_kept_curves)
        self.toolbar.cursors.toggled.connect(lambda on: self.time.cursors.show(on))
        self.time.cursors.changed.connect(lambda: self.toolbar.cursors.setChecked(self.time.cursors.on))
        self.toolbar.span.activated.connect(lambda index: self.view.set_span(SPANS[index]))
        self.view.changed.connect(lambda: self.toolbar.show_span(self.view.span))
        self.toolbar.show_span(self.view.span)
        self.rows.splitterMoved.connect(self._scene_dragged)
        self.columns.splitterMoved.connect(self._phase_dragged)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        # a theme change resizes single widgets; the window is laid out once afterwards
        if not theme.refreshing:
            self.lay_out()

    def lay_out(self) -> None:
        """Distribute height and width among the cards.

        This is also called when another scene needs a different height.
        """
        px, page = theme.px, self._page is not None
        width = round(self.width() / theme.scale)
        narrow = width < breakpoints.PLOTS_BESIDE
        if narrow != self._narrow:
            self._narrow = narrow
            self._move_phase()
        free = self.height() - 3 * GAP
        law = self._is_law if page else None
        usual = breakpoints.scene_height(self.scene.wanted_height, width, round(free / theme.scale), law)
        height = px(usual if page or not self._scene_height else self._scene_height)
        if self._projected and not page:
            window = round(self.window().height() / theme.scale)
            height = px(breakpoints.projected_scene(window, round(free / theme.scale)))
        self.scene_card.setMinimumHeight(px(breakpoints.SCENE_LEAST) + 2 * _EDGE)
        self.scene_card.setVisible(self._shows_scene)
        self.time_card.setVisible(not page)
        self.values_card.setVisible(self._projected and not page)
        if not narrow:
            self.phase_card.setVisible(not page or (self._is_law and width >= breakpoints.LAW_BESIDE))
        self.rows.setSizes([height + 2 * _EDGE, free - height - 2 * _EDGE])
        if not narrow:
            self._share_columns(width)

    def _share_columns(self, width: int) -> None:
        """Distribute the width among the cards below the scene; a page takes the width of the time plots."""
        phase, values = self._phase_width or breakpoints.phase_width(width), 0.0
        if self._projected:
            phase, values = breakpoints.PROJECTED_PHASE * width, breakpoints.PROJECTED_VALUES * width
        widths: dict[QWidget | None, int] = {
            self.phase_card: theme.px(phase),
            self.values_card: theme.px(values),
        }
        rest = self.columns.width() - sum(widths.values()) - GAP * (2 if self._projected else 1)
        columns = map(self.columns.widget, range(self.columns.count()))
        self.columns.setSizes([widths.get(part, rest) for part in columns])

    def add_values_card(self, values: QWidget) -> None:
        """Add the widget that a projector shows beside the plots; it is hidden by default."""
        vbox(values, into=self.values_card)

    def project(self, on: bool) -> None:
        """Show only the parts that can be read from a distance (for a projector), or all parts."""
        self._projected = on
        for part in (self.toolbar, self._line):
            part.setHidden(on)
        self.time.set_folded(on)
        self.lay_out()

    def add_page(self, page: QWidget) -> None:
        """Insert a hidden page at the position of the time plots."""
        page.hide()
        self.columns.insertWidget(0, page)
        self.columns.setStretchFactor(0, 1)

    def show_page(self, page: QWidget | None, scene: bool = True, law: bool = False) -> None:
        """Show an added page in place of the plots; None shows the plots.

        With ``scene``, the scene stays visible. With ``law``, the force–position plot also stays visible if
        it fits.
        """
        if self._page is not None and self._page is not page:
            self._page.hide()
        self._page, self._shows_scene, self._is_law = page, scene, law
        if page is not None:
            page.show()
        self.lay_out()

    def refresh(self) -> None:
        """Check the trigger, then draw the newest data into the visible plots."""
        self.trigger.refresh()
        for plots in (self.time, self.phase):
            if plots.isVisible():
                plots.refresh()

    def _scene_dragged(self) -> None:
        if self._page is None and not self._projected:
            self._scene_height = (self.scene_card.height() - 2 * _EDGE) / theme.scale
            self._settings.setValue("scene_height", self._scene_height)

    def _phase_dragged(self) -> None:
        if self._projected:
            return
        self._phase_width = self.phase_card.width() / theme.scale
        self._settings.setValue("phase_width", self._phase_width)

    def _move_phase(self) -> None:
        """Show the force–position plot beside the time plots, or in their place if the window is narrow."""
        self.toolbar.set_narrow(self._narrow)
        self.phase_card.setProperty("card", not self._narrow)
        if self._narrow:
            self.stack.addWidget(self.phase_card)
            self.stack.setCurrentIndex(self.toolbar.views.index)
        else:
            self.stack.removeWidget(self.phase_card)
            self.columns.insertWidget(self.columns.indexOf(self.values_card), self.phase_card)
            self.phase_card.show()
        self.phase_card.style().unpolish(self.phase_card)
        self.phase_card.style().polish(self.phase_card)
