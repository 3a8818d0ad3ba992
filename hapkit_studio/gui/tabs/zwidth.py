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


class ZWidthPage(Page):
    """Chart and verdict; while a device is tried, the scene shows the wall and what the hand does."""

    side: ZWidthSide

    def __init__(self, studio: "Studio", live: "Live"):
        super().__init__()
        self._studio = studio
        self._facts = LoopFacts(studio, self)
        live.health.connect(self._facts.note_health)
        self.result: ZWidth | None = None
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
        self._greet()
        self._join()

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
        self.side.lock(True)
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
        """Show what was found."""
        self.result = result
        self.chart.show_result(result)
        self.side.show_result(result)
        good = bool((result.stiffness > 0.0).any())
        self.verdict.say(result.sentence, *(("check", "ok") if good else ("triangle", "danger")))

    # ending

    def _give_up(self) -> None:
        """End what is tried on a device: it, its loop or its scene are others now, or nobody looks."""
        if self.job.running and self._mode == DEVICE:
            self.job.cancel()
            self.bar.say("Ended: the device's settings changed.", danger=True)

    def _scene_changed(self) -> None:
        if self._studio.environment.key != _WALL:
            self._scene = ""
            self._give_up()

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
        if self.result is None:
            self._greet()
        else:
            self.show_result(self.result)

    def set_shown(self, on: bool) -> None:
        if not on:
            self._give_up()

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

    def _greet(self) -> None:
        self.verdict.say(_BEGIN)

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
        self._studio.loop_changed.connect(self._give_up)
        self._studio.engine_changed.connect(self._give_up)

    def _press(self) -> None:
        try:
            self.run()
        except ParameterError as error:
            self.bar.say(str(error), danger=True)


TAB = Tab("zwidth", "Z-width", 30, ZWidthPage)
