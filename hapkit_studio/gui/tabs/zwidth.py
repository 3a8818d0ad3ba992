"""Z-width: the stiffest wall at each virtual damping, simulated, or tried on the device that is connected."""

from typing import TYPE_CHECKING

from PySide6.QtCore import QTimer

from hapkit_studio.analysis.zwidth_limits import DEVICE_DAMPING, SIMULATED_DAMPING
from hapkit_studio.errors import ParameterError
from hapkit_studio.gui.loop_facts import LoopFacts
from hapkit_studio.gui.segmented import Segmented
from hapkit_studio.gui.tabs.bar import RunBar
from hapkit_studio.gui.tabs.base import Page, Tab, filled
from hapkit_studio.gui.tabs.export import Export
from hapkit_studio.gui.tabs.fresh import Fresh, loop_facts
from hapkit_studio.gui.tabs.job import Job
from hapkit_studio.gui.tabs.verdict_line import VerdictLine
from hapkit_studio.gui.tabs.zwidth_chart import Spot, ZWidthChart
from hapkit_studio.gui.tabs.zwidth_side import ZWidthSide
from hapkit_studio.gui.tabs.zwidth_work import ZWidthWork

if TYPE_CHECKING:
    from hapkit_studio.analysis.zwidth_result import ZWidth
    from hapkit_studio.analysis.zwidth_search import Point
    from hapkit_studio.gui.live import Live
    from hapkit_studio.gui.studio import Studio

SIMULATION, DEVICE = range(2)
_WALL = "wall"
_LOOK_MS = 100
_BEGIN = "Measure how stiff a wall this Hapkit renders without buzzing."
_HIGHEST = {SIMULATION: SIMULATED_DAMPING[-1], DEVICE: DEVICE_DAMPING[-1]}


def _sign(result: "ZWidth") -> tuple[str, str]:
    """Return sign and colour: a limit of the motor is neither good nor bad."""
    if not (result.stiffness > 0.0).any():
        return "triangle", "danger"
    return ("info", "ink2") if result.clamped[result.best] else ("check", "ok")


class ZWidthPage(Page):
    """Chart and verdict; while a device is tried, the scene shows the wall and what the hand does."""

    side: ZWidthSide

    def __init__(self, studio: "Studio", live: "Live"):
        super().__init__()
        self._studio = studio
        self._facts = LoopFacts(studio, self)
        live.health.connect(self._facts.note_health)
        self._results: dict[int, ZWidth] = {}
        self._fresh = {
            SIMULATION: Fresh(lambda: loop_facts(studio, model=False)),
            DEVICE: Fresh(lambda: loop_facts(studio)),
        }
        self._mode, self._scene, self._asked = SIMULATION, "", False
        self._look = QTimer(self, interval=_LOOK_MS)
        self._look.timeout.connect(self.show_trial)
        self.job, self.work = Job(self), ZWidthWork(self)
        self.bar = RunBar(self.job)
        self.where = Segmented("Where", ("Simulation", "This device"))
        self.where.show_index(SIMULATION)
        self.bar.add(self.where)
        self.verdict, self.chart, self.side = VerdictLine(_BEGIN), ZWidthChart(), ZWidthSide()
        self.column.addWidget(filled(self.bar, self.verdict, self.chart))
        self._export = Export(self, "z-width", self.bar.say)
        self._join()

    @property
    def result(self) -> "ZWidth | None":
        """Return what was found where it was chosen, None before it was measured there."""
        return self._results.get(self.where.index)

    # measuring

    def run(self) -> None:
        """Measure where it was chosen."""
        self._mode = self.where.index
        if self._mode == DEVICE:
            self._run_device()
        else:
            self._run_simulation()

    def _run_simulation(self) -> None:
        setting, engine = self._facts.setting(self._studio.grip), self._studio.engine
        if setting is None or engine is None:
            self.bar.say("There is no device yet to take the numbers from.", danger=True)
            return
        self._begin("Hitting walls…")
        self.job.start(self.work.simulation(setting, float(engine.device.max_force)))

    def _run_device(self) -> None:
        engine = self._studio.engine
        if engine is None:
            self.bar.say("No device is running.", danger=True)
            return
        self._scene = self._studio.environment.key
        self._studio.choose(_WALL)
        self._begin("Trying walls, from soft to stiff…")
        self.job.start(self.work.device(engine, self.side.max_force))

    def _begin(self, words: str) -> None:
        self._asked = False
        self._fresh[self._mode].begin()
        self.side.lock(True)
        self.where.setEnabled(False)
        self.chart.begin(_HIGHEST[self._mode])
        self.verdict.say(words, "hand", "accent")

    def show_point(self, damping: float, point: "Point") -> None:
        """Show a point that has just come."""
        if self.job.running:
            self.chart.add(Spot(damping, point.stiffness, point.clamped))

    def show_step(self, words: str) -> None:
        """Tell a person what to do."""
        self._asked = True
        if self.job.running:
            self.verdict.say(words, "hand", "accent")

    def show_trial(self) -> None:
        """Show which wall is being tried; in words too, unless a person is told what to do."""
        engine = self._studio.engine
        if not self.job.running or self._mode != DEVICE or engine is None or engine.environment.key != _WALL:
            return
        damping, stiffness = engine.values["damping"], engine.values["stiffness"]
        self.chart.show_trial(damping, stiffness)
        if not self._asked:
            self.verdict.say(f"Trying {stiffness:,.0f} N/m at B = {damping:g} N·s/m", "hand", "accent")

    def show_result(self, result: "ZWidth") -> None:
        """Keep and show what was found."""
        self._fresh[self._mode].keep()
        self._results[self._mode] = result
        self.show_found()

    def show_found(self) -> None:
        """Show what was found where it was chosen, and whether it still holds."""
        result = self.result
        self.bar.export.setEnabled(result is not None)
        self.side.show_result(result)
        if result is None:
            self.chart.show_nothing()
            self.verdict.say(_BEGIN)
            return
        self.chart.show_result(result)
        outdated = self._fresh[self.where.index].outdated
        self.chart.outdate(bool(outdated))
        if outdated:
            self.verdict.outdate(outdated)
        else:
            self.verdict.say(result.sentence, *_sign(result))

    def _look_again(self) -> None:
        """See whether what is shown still holds; while something is measured, that is in sight."""
        if not self.job.running:
            self.show_found()

    # ending

    def _give_up(self, why: str) -> None:
        """End what is tried on a device: it, its loop or its scene are others now, or nobody looks."""
        if self.job.running and self._mode == DEVICE:
            self.job.cancel()
            self.bar.say(f"Ended: {why}.", danger=True)

    def _scene_changed(self) -> None:
        if self._studio.environment.key != _WALL:
            self._scene = ""
            self._give_up("another scene was chosen")

    def _running_changed(self, running: bool) -> None:
        if running:
            self._look.start()
            return
        self._look.stop()
        self.side.lock(False)
        self.chart.settle()
        scene, self._scene = self._scene, ""
        if scene and scene != self._studio.environment.key:
            self.job.wait()  # it is putting the wall's own settings back
            self._studio.choose(scene)
        self.where.setEnabled(True)
        self.show_found()

    def set_shown(self, on: bool) -> None:
        if not on:
            self._give_up("the view was left")

    def end(self) -> None:
        self.job.end()

    def export(self) -> None:
        """Save the chart as a picture, or its points and conditions as numbers."""
        result = self.result
        assert result is not None

        def figure(path: str) -> None:
            from hapkit_studio.charts.zwidth import zwidth_figure

            zwidth_figure(result, path)

        self._export.ask(figure, result.as_json)

    def _failed(self, words: str) -> None:
        self.verdict.say(words, "triangle", "danger")
        self.bar.say("")

    def _join(self) -> None:
        self.bar.run_pressed.connect(self._press)
        self.bar.export_pressed.connect(self.export)
        self.job.finished.connect(self.show_result)
        self.job.failed.connect(self._failed)
        self.job.running_changed.connect(self._running_changed)
        self.work.arrived.connect(self.show_point)
        self.work.said.connect(self.show_step)
        self.chart.pointed.connect(self.side.show_point)
        self._studio.environment_changed.connect(self._scene_changed)
        self._studio.loop_changed.connect(lambda: self._give_up("the loop changed"))
        self._studio.engine_changed.connect(lambda: self._give_up("the device changed"))
        for changed in (self._studio.loop_changed, self._studio.engine_changed, self._studio.link_changed):
            changed.connect(self._look_again)
        self.where.chosen.connect(lambda _index: self._look_again())

    def _press(self) -> None:
        try:
            self.run()
        except ParameterError as error:
            self.bar.say(str(error), danger=True)


TAB = Tab("zwidth", "Z-width", 30, ZWidthPage)
