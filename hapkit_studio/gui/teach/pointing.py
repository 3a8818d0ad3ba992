"""The pointing experiment: it shows targets in the scene, hides the friction, and measures movement times."""

import random
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QComboBox, QFrame, QProgressBar, QPushButton, QWidget

from hapkit_studio.analysis import pointing
from hapkit_studio.analysis.pointing import BY_MODEL, CONDITIONS, POINTING, ROUNDS, START_WIDTH, Run
from hapkit_studio.charts.experiments import draw_pointing, pointing_columns
from hapkit_studio.gui.live.live import Live
from hapkit_studio.gui.pages.base import Page, SidePanel
from hapkit_studio.gui.pages.views import Views
from hapkit_studio.gui.scenes import SceneView
from hapkit_studio.gui.scenes.base import Zone
from hapkit_studio.gui.state import permissions
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.gui.teach.experiment import Experiment, RecordedTrials, ResultDialog
from hapkit_studio.gui.widgets.dialogs import FormDialog, text_dialog
from hapkit_studio.gui.widgets.parts import hbox, hint, label, primary, vbox
from hapkit_studio.haptics import rows

if TYPE_CHECKING:
    from hapkit_studio.haptics.rows import RingReader

TITLE = "Pointing with friction"
_ABOUT = (
    "Move the handle to a target as fast as you can, but hit the target. The handle has friction of "
    "different strengths or of different models, in random order and hidden from you. Every trial is "
    "recorded. You can stop at any time: the trials until then are evaluated."
)
_HOW = (
    "Hold the handle in the start range until the target appears. Then move the handle into the "
    "target at once and stop there. A trial ends when the handle is at rest. With the mouse, keep the "
    "button pressed."
)
_SETS = (("Friction: none, low, high", CONDITIONS), ("No friction, and each friction model", BY_MODEL))
_ROUNDS = (1, 2, ROUNDS, 8)


class PointingDialog(FormDialog):
    """Asks for the conditions and the number of rounds; ``begun`` is emitted with the planned targets."""

    begun = Signal(object)

    def __init__(self, parent: QWidget):
        super().__init__(TITLE, _ABOUT, parent)
        self.conditions, self.rounds = QComboBox(), QComboBox()
        for name, found in _SETS:
            self.conditions.addItem(name, found)
        self.add_fields([("Conditions", self.conditions, None), ("Rounds", self.rounds, None)])
        self.start = QPushButton("Start")
        self.start.setDefault(True)
        self.add_buttons(self.start)
        self.conditions.currentIndexChanged.connect(self._fill)
        self.start.clicked.connect(self._start)
        self._fill()

    def _fill(self) -> None:
        """List the number of trials for each number of rounds."""
        chosen = max(self.rounds.currentIndex(), 0) if self.rounds.count() else _ROUNDS.index(ROUNDS)
        cells = len(self.conditions.currentData()) * len(pointing.DISTANCES) * len(pointing.WIDTHS)
        self.rounds.clear()
        for count in _ROUNDS:
            self.rounds.addItem(f"{count} round{'s' * (count != 1)}, {cells * count} trials", count)
        self.rounds.setCurrentIndex(chosen)

    def _start(self) -> None:
        targets = pointing.plan(self.conditions.currentData(), rounds=self.rounds.currentData())
        self.close()
        self.begun.emit(targets)


class PointingPage(Page):
    """The page below the scene; it guides the user through the trials.

    ``ended`` is emitted when the values are no longer hidden.
    """

    ended = Signal()

    def __init__(self, studio: Studio, live: Live, scene: SceneView, run: Run):
        super().__init__()
        self._studio, self._live, self._scene = studio, live, scene
        self.run = run
        self.trials: RecordedTrials | None = None
        self._reader: RingReader | None = None
        self.sign, self.count, self.last = label(role="verdict"), label(wrap=False), hint()
        self.bar, self.stop = QProgressBar(maximum=run.count), QPushButton("Stop and evaluate")
        self._arrange()
        self.stop.clicked.connect(self.finish)
        live.frame.connect(self._take)
        for changed in (studio.stop_changed, studio.engine_changed):
            changed.connect(self._restart)
        studio.hidden_changed.connect(self._refresh)

    def begin(self) -> None:
        """Render the first condition and start the recording; raise ParameterError if a setting is locked."""
        self._restart()
        self._render()
        self.trials = RecordedTrials(self._studio.recording)

    def finish(self) -> None:
        """End the experiment, and render the values that the window shows."""
        self._studio.hide_values(None)

    def end(self) -> None:
        self._scene.set_zone(None)

    def _restart(self) -> None:
        """Read the rows of the current device and restart the current trial."""
        engine = self._studio.engine
        self._reader = None if engine is None else engine.reader()
        self.run.restart()
        self._show()

    def _take(self) -> None:
        """Evaluate new samples and show the next instruction."""
        if self._reader is None or self._studio.stopped or self._studio.fault is not None:
            return
        new = self._reader.read()
        bad = rows.STOPPED | rows.FAULT | rows.STALE | rows.GAP
        if len(new) and (new[:, rows.FLAGS].astype(np.int64) & bad).any():
            self.run.restart()
        else:
            found = self.run.feed(new[:, rows.HOST_TIME], new[:, rows.POSITION])
            if found is not None:
                assert self.trials is not None
                self.trials.note(POINTING, pointing.event(found), found.stop)
                hit = "missed" if found.missed else "hit"
                self.last.setText(f"Last trial: {1e3 * found.seconds:.0f} ms, {hit}.")
                if self.run.target is None:
                    self.finish()
                    return
                self._render()
        self._show()

    def _render(self) -> None:
        target = self.run.target
        if target is not None:
            self._studio.hide_values(target.condition.values, permissions.POINTING)

    def _show(self) -> None:
        """Mark the range of the target in the scene."""
        target = self.run.target
        if target is None:
            return
        half = 0.5 * (target.width if self.run.going else START_WIDTH)
        middle = target.middle if self.run.going else target.start
        name, token = ("target", "ok") if self.run.going else ("start", "accent")
        self._scene.set_zone(Zone(middle - half, middle + half, name, token))
        text = "Go!" if self.run.going else "Hold the handle in the start range"
        if self._studio.stopped:
            text = f"{'Press Render' if self._studio.waits_for_render else 'Release the E-stop'} to continue"
        self.sign.setText(text)
        done = len(self.run.done)
        self.count.setText(f"Trial {done + 1} of {self.run.count}")
        self.bar.setValue(done)

    def _refresh(self) -> None:
        if not self._studio.hidden:
            self._live.frame.disconnect(self._take)
            self._studio.hidden_changed.disconnect(self._refresh)
            self.end()
            self.ended.emit()

    def _arrange(self) -> None:
        card = QFrame()
        card.setProperty("card", True)
        self.sign.setAlignment(Qt.AlignmentFlag.AlignHCenter)
        self.last.setAlignment(Qt.AlignmentFlag.AlignHCenter)
        self.bar.setTextVisible(False)
        self.bar.setAccessibleName("Progress of the trials")
        middle = hbox(None, self.count, None)
        vbox(None, self.sign, middle, self.bar, self.last, None, into=card, margins=(40, 16, 40, 16), gap=14)
        self.column.addWidget(card)
        self.side = SidePanel(TITLE, _HOW)
        self.side.add(primary(self.stop))


class PointingExperiment(Experiment):
    """Asks for the conditions, shows the page, and shows the results at the end."""

    def __init__(self, studio: Studio, live: Live, views: Views, scene: SceneView, window: QWidget):
        super().__init__(studio, views, window)
        self._live, self._scene = live, scene
        self._targets: list[pointing.Target] = []
        studio.environment_changed.connect(self._begin_waiting)

    def show_settings(self) -> None:
        """Open the dialog with the conditions."""
        dialog = PointingDialog(self._window)
        dialog.begun.connect(self.begin)
        dialog.show()

    def begin(self, targets: list[pointing.Target]) -> None:
        """Start the experiment with these targets as soon as the environment *Friction* is active."""
        if not self.possible:
            return
        self._targets = list(targets)
        if self._studio.environment.key == pointing.ENVIRONMENT:
            self._begin_waiting()
        else:
            self._studio.choose(pointing.ENVIRONMENT)

    def _begin_waiting(self) -> None:
        targets, self._targets = self._targets, []
        if not targets or self._studio.environment.key != pointing.ENVIRONMENT or not self.possible:
            return
        run = Run(targets, random.randrange(1 << 32))
        self._start(PointingPage(self._studio, self._live, self._scene, run), scene=True)
        if self.page is not None:
            self._live.set_paused(False)

    def show_results(self, page: PointingPage, name: str) -> None:
        if not page.run.done:
            text_dialog(TITLE, ["No trial was completed."], self._window).show()
            return
        lines = pointing.evaluate(page.run.done)
        texts = [
            f"Movement time MT = a + b·ID, where ID says how difficult a target is (index of difficulty). "
            f"The intervals contain the true values with 95 % probability. Trials: {len(page.run.done)}."
        ]
        if name:
            texts.append(
                f"The trials are recorded in {name}. "
                "The command `hapkit-studio experiment pointing` in a terminal evaluates them again."
            )
        chart = partial(draw_pointing, found=lines)
        ResultDialog(TITLE, texts, chart, pointing_columns(), lines, self._window).show()
