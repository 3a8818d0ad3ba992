"""A plot of force over position or velocity with the theory behind it, or of energy over time."""

import math
from collections.abc import Mapping

from PySide6.QtCore import QTimer
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QCheckBox, QLabel, QStackedWidget, QWidget

from hapkit_studio.analysis.theory import Curve
from hapkit_studio.environments.base import Environment
from hapkit_studio.formatting import with_unit
from hapkit_studio.gui.live.cursors import CursorCard, Cursors
from hapkit_studio.gui.live.phase_canvas import PhaseCanvas
from hapkit_studio.gui.live.plot_header import Sample
from hapkit_studio.gui.live.plots.declared import PhasePlot, phase_plots, time_plots
from hapkit_studio.gui.live.time_plots import TimePlots
from hapkit_studio.gui.widgets.canvas import RIGHT
from hapkit_studio.gui.widgets.parts import hbox, hint, label, vbox
from hapkit_studio.gui.widgets.segmented import Segmented
from hapkit_studio.gui.widgets.theme import theme

_DEBOUNCE_MS = 30
_CYCLE_FRAMES = 30  # number of frames between updates of the energy per cycle
_GAP = 7
_BESIDE_KEY = 14 + RIGHT + 6 + 3 * _GAP  # px: margins and gaps of the header line
_LOW = 450  # px: below this height either the plot or the cursor table is shown


class ForcePosition(QWidget):
    """Shows the applied force over position or velocity, fading with age, with the theory behind it.

    A switch selects one of these plots or a time plot such as the energy; the cursor table is below.
    """

    def __init__(self, cursors: Cursors):
        super().__init__()
        self.plots = phase_plots()
        self._environment: Environment | None = None
        self._values: dict[str, float] = {}
        self._max_force = math.inf
        self._found: dict[str, Curve | None] = {}
        self._by_hand = self._hidden = False
        self._frames = 0
        self._unseen = ""
        self.view = cursors.view
        self.canvas = PhaseCanvas(self.plots[0], self.view)
        self.canvas.fit_wanted.connect(self.fit)
        self.beside = [TimePlots(self.view, [plot]) for plot in time_plots(beside=True)]
        titles = [plot.title for plot in self.plots] + [pane.plots[0].title for pane in self.beside]
        self.switch = Segmented("Plot of force or energy", tuple(titles))
        self.switch.show_index(0)
        self.switch.chosen.connect(self.choose)
        title = self.title = label("Force, N", "strong", wrap=False)
        self.theory = [Sample(("edge", 8.8, None), ("theory", 6.4, None)), QLabel("theory")]
        for part in self.theory:
            part.setToolTip("Theory: the force that the law gives while the handle is at rest")
        self.canvas.setToolTip(
            "The applied force is the force sent to the motor, after the force limit. "
            "The Hapkit has no force sensor"
        )
        self.note = hint()
        self.note.setContentsMargins(14, 0, RIGHT, 4)
        self.note.hide()
        self.felt = QCheckBox("Force as felt")
        self.felt.setToolTip(
            "Draw each force at the handle's position while the force acted, not at the earlier position "
            "that the law used. The area of the closed curve is then the energy that you get in each cycle"
        )
        self.felt.toggled.connect(self._show_felt)
        self.cycle = label(role="fact", wrap=False)
        self._felt_row = QWidget()
        hbox(self.felt, None, self.cycle, into=self._felt_row, margins=(14, 0, RIGHT, 2), gap=7)
        self._delay: float | None = None
        self._stack = QStackedWidget()
        self._stack.addWidget(self.canvas)
        for pane in self.beside:
            self._stack.addWidget(pane)
        head = hbox(title, 6, *self.theory, None, self.switch, margins=(14, 6, RIGHT, 5), gap=_GAP)
        self.cursors = CursorCard(cursors)
        self.cursors.fitted.connect(self.canvas.show_line)
        self.cursors.unfolded.connect(lambda: self._stack.setHidden(self.cursors.covers))
        vbox(head, self._felt_row, self.note, (self._stack, 1), self.cursors, into=self, margins=(2, 0, 2, 8))
        self._later = QTimer(self, singleShot=True, interval=_DEBOUNCE_MS)
        self._later.timeout.connect(self._compute)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self.cursors.set_low(self.height() < theme.px(_LOW))
        self._show_key()

    def _show_key(self) -> None:
        """Show the sample of the theory if there is a theory and space for the sample."""
        parts = self.title, *self.theory, self.switch
        fits = sum(part.sizeHint().width() for part in parts) + _BESIDE_KEY <= self.width()
        for part in self.theory:
            part.setVisible(fits and self.pane is None and self.canvas.has_theory)

    def set_environment(self, environment, values: Mapping[str, float], max_force: float) -> None:
        """Compute theory and limits (N) for another environment or other values."""
        for pane in self.beside:
            pane.set_environment(environment, values, max_force)
        other = environment is not self._environment
        if not other and values == self._values and max_force == self._max_force:
            return
        self._found.clear()
        self._environment, self._values = environment, dict(values)
        self._max_force = max_force
        if other:
            self._by_hand = False
            self._show(self.switch.index if self.pane else self._best_plot())
        else:
            self._later.start()

    def set_delay(self, delay: float | None) -> None:
        """Set the delay in s from a sample to its force; None if unknown."""
        if delay != self._delay or self.felt.isEnabled() != (delay is not None):
            self._delay = delay
            self.felt.setEnabled(delay is not None)
            self._show_felt()

    def _show_felt(self) -> None:
        self.canvas.set_felt(self.felt.isChecked(), self._delay)
        self._show_cycle()

    def _show_cycle(self) -> None:
        cycle = self.canvas.cycle() if self.felt.isChecked() and self._over_position else None
        text = ""
        if cycle is not None:
            way = "gives" if cycle.energy >= 0.0 else "takes"
            text = f"The scene {way} {with_unit(abs(1e3 * cycle.energy), 'mJ', 2)} per cycle"
        self.cycle.setText(text)

    @property
    def _over_position(self) -> bool:
        return self.pane is None and self.canvas.plot_of.channel == "position"

    def hide_theory(self, on: bool) -> None:
        """Hide the theory while the rendered values are hidden; otherwise show it."""
        self._hidden = on
        if self.pane is None:
            self._take_theory()

    def set_note(self, text: str) -> None:
        """Set the text that explains why a time plot in place of a force plot is empty; "" shows none."""
        self._unseen = text
        self._show_note()

    def _show_note(self) -> None:
        self.note.setText(self._unseen if self.pane else "")
        self.note.setVisible(bool(self.note.text()))

    def choose_channel(self, channel: str) -> None:
        """Show the plot of force over a channel, "position" or "velocity"."""
        self.choose(next(at for at, plot in enumerate(self.plots) if plot.channel == channel))

    def choose(self, index: int) -> None:
        """Show the chosen plot.

        A force plot stays until the environment changes. The energy stays until the user switches.
        """
        self._by_hand = True
        self._show(index)

    def _show(self, index: int) -> None:
        self.switch.show_index(index)
        self._stack.setCurrentWidget(self.pane or self.canvas)
        self.title.setVisible(self.pane is None)
        self._show_note()
        if self.pane is None:
            other = self.plots[index] is not self.canvas.plot_of
            self.canvas.set_plot(self.plots[index])
            self._take_theory()
            if other or not self.view.locked:
                self.canvas.fit_theory()
        self._felt_row.setVisible(self._over_position)
        self._show_key()

    @property
    def pane(self) -> TimePlots | None:
        """Return the time plot that is shown in place of a force plot; None if a force plot is shown."""
        index = self.switch.index - len(self.plots)
        return self.beside[index] if index >= 0 else None

    def fit(self) -> None:
        """Fit the axes to the shown data."""
        shown = self.pane or self.canvas
        shown.fit()
        shown.refresh()

    def point(self, time: float | None) -> None:
        """Mark the sample at a time in s, the time of the pointer in the time plots.

        None removes the mark.
        """
        self.canvas.point(time)

    def refresh(self) -> None:
        """Draw the newest data on every second call; call once per frame."""
        self._frames += 1
        if self._frames % 2:
            (self.pane or self.canvas).refresh()
        if self._frames % _CYCLE_FRAMES == 0:
            self._show_cycle()

    def _best_plot(self) -> int:
        """Return the index of the first plot in which the law has a curve.

        The plot over position is tried first, unless the law declares a curve over velocity.
        """
        order = list(range(len(self.plots)))
        if self._environment is not None and self._environment.over_velocity is not None:
            order.reverse()
        return next((index for index in order if self._theory(self.plots[index]) is not None), 0)

    def _theory(self, plot: PhasePlot) -> Curve | None:
        """Return a plot's theory for the current values, cached."""
        if plot.key not in self._found and self._environment is not None:
            self._found[plot.key] = plot.theory_of(self._environment, self._values)
        return self._found[plot.key]

    def _compute(self) -> None:
        """Apply changed values; if only the other plot has a theory now, switch to it."""
        if self.pane is not None:
            return
        best = self._best_plot()
        gone = self._theory(self.canvas.plot_of) is None and self._theory(self.plots[best]) is not None
        if gone and not self._by_hand:
            self._show(best)
        else:
            self._take_theory()
            self.canvas.widen_theory()

    def _take_theory(self) -> None:
        if self._environment is not None:
            plot = self.canvas.plot_of
            curve = None if self._hidden else self._theory(plot)
            self.canvas.set_theory(curve, self._max_force)
            self._show_key()
