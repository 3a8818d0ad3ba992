"""The view Z-width: it finds the stiffest stable wall at each damping, simulated or on the device."""

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

from PySide6.QtCore import QTimer, Signal

from hapkit_studio.analysis.zwidth import DEVICE_DAMPING, DEVICE_FORCE, SIMULATED_DAMPING, simulation
from hapkit_studio.analysis.zwidth.result import COLUMNS, ENDED, Point, Protocol, ZWidth
from hapkit_studio.charts.zwidth import Walls, draw, zwidth_figure
from hapkit_studio.errors import ParameterError
from hapkit_studio.gui.pages.base import View
from hapkit_studio.gui.pages.measuring import Freshness, MeasuringPage, loop_facts
from hapkit_studio.gui.panel.limits import LoopFacts
from hapkit_studio.gui.panel.rows import ParameterRow
from hapkit_studio.gui.state.background import Progress, Work
from hapkit_studio.gui.widgets.parts import hint
from hapkit_studio.gui.widgets.segmented import Segmented

if TYPE_CHECKING:
    from matplotlib.backend_bases import MouseEvent

    from hapkit_studio.gui.live.live import Live
    from hapkit_studio.gui.state.studio import Studio
    from hapkit_studio.haptics.engine import Engine

SIMULATION, DEVICE = range(2)
_WALL = "wall"
_REFRESH_MS = 100
_HIGHEST = {SIMULATION: SIMULATED_DAMPING[-1], DEVICE: DEVICE_DAMPING[-1]}
_HOW_IT_IS_TRIED = (
    "A simulated hand presses into stiffer and stiffer walls, until a wall keeps buzzing. The force, "
    "the speed and the range of the handle are limited. Esc stops the measurement at once. Afterwards your "
    "settings are restored."
)


class ZWidthPage(MeasuringPage):
    """The page *Z-width*: measures the stiffest stable wall for each virtual damping.

    Each measured point appears at once. On a device, the scene shows the wall and the hand meanwhile.
    """

    file = "z-width"
    heading, about = "Z-width", "The stiffest wall without lasting buzzing, for each virtual damping."
    begin = "Press Measure to find the stiffest wall that this Hapkit renders without buzzing."
    drawn, listed = "Stiffness over damping, for walls without buzzing", "Walls without buzzing"
    read = (
        "On every wall below a point, the handle came to rest after a hit and a push. Bar: in this range "
        "some walls buzz and some do not. Hollow point: the motor reached its force limit. Dashed line: the "
        "exact limit from the view Stability for the same hand, without sensor steps and without dry "
        "friction. Dry friction usually helps."
    )
    arrived = Signal(float, object)
    instructed = Signal(str)

    def __init__(self, studio: "Studio", live: "Live"):
        super().__init__(studio, live)
        self._facts = LoopFacts(studio, self)
        live.health.connect(self._facts.note_health)
        self._results: dict[int, ZWidth] = {}
        self._fresh = {
            SIMULATION: Freshness(lambda: loop_facts(studio, model=False)),
            DEVICE: Freshness(lambda: loop_facts(studio)),
        }
        self.walls, self._waits = Walls(), False
        self._mode, self._scene, self._asked = SIMULATION, "", False
        self._refresh = QTimer(self, interval=_REFRESH_MS)
        self._refresh.timeout.connect(self.show_trial)
        self.where = Segmented("Measured on", ("Simulation", "This device"))
        self.where.show_index(SIMULATION)
        self.bar.add(self.where)
        self.force = ParameterRow(DEVICE_FORCE)
        self.force.slider.hide()
        self.build()
        self.side.section("Measurement on this device")
        self.side.add(self.force, hint(_HOW_IT_IS_TRIED))
        self._join()
        self._show(self.walls)

    @property
    def result(self) -> ZWidth | None:
        """Return the result for the chosen place (simulation or device); None if it is not measured yet."""
        return self._results.get(self.where.index)

    # methods that measure

    def first(self) -> str:
        """Return "simulation" if the loop is known; a measurement on the device starts only on request."""
        known = self._studio.engine is not None and self._facts.setting(self._studio.grip) is not None
        return "simulation" if known and self.where.index == SIMULATION and self.result is None else ""

    def run(self) -> None:
        """Measure in the chosen place (simulated or on the device)."""
        self._mode = self.where.index
        engine = self._studio.engine
        if self._mode == DEVICE:
            if engine is None:
                raise ParameterError("No device is running. Connect a device first.")
            self._scene = self._studio.environment.key
            with self._studio.temporarily():
                self._studio.choose(_WALL)
            self._begin("Trying walls, from soft to stiff…")
            self.job.start(self._on_device(engine))
            return
        setting = self._facts.setting(self._studio.grip)
        if setting is None or engine is None:
            raise ParameterError("Connect a device first.")
        self._begin("Simulating hits on walls…")
        protocol, arrived = Protocol(max_force=engine.max_force), self.arrived.emit
        self.job.start(
            lambda progress: simulation.compute(
                setting, protocol=protocol, progress=progress, arrived=arrived
            )
        )

    def _on_device(self, engine: "Engine") -> Work:
        limit = self.force.value

        def work(progress: Progress) -> ZWidth:
            from hapkit_studio.analysis.zwidth import on_device
            from hapkit_studio.analysis.zwidth.guarded_device import TrialLimits

            limits, arrived, instruct = TrialLimits(max_force=limit), self.arrived.emit, self.instructed.emit
            return on_device.measure(
                engine, limits=limits, progress=progress, arrived=arrived, instruct=instruct
            )

        return work

    def _begin(self, text: str) -> None:
        self._asked, self._waits = False, True
        self._fresh[self._mode].begin()
        self.force.setEnabled(False)
        self.where.setEnabled(False)
        self._show(self.walls, pale=bool(self.walls.points))
        self.answer.show_text(text, "hand", "accent")

    def show_point(self, damping: float, point: Point) -> None:
        """Add a new point; the first point of a measurement replaces the previous points."""
        if self.job.running:
            before = () if self._waits else self.walls.points
            self._waits = False
            self._show(Walls([*before, (damping, point)], right=_HIGHEST[self._mode]))

    def show_step(self, text: str) -> None:
        """Show an instruction to the user."""
        self._asked = True
        if self.job.running:
            self.answer.show_text(text, "hand", "accent")

    def show_trial(self) -> None:
        """Show the wall that is being tried; also describe it in words, unless an instruction is shown."""
        engine = self._studio.engine
        if not self.job.running or self._mode != DEVICE or engine is None or engine.environment.key != _WALL:
            return
        damping, stiffness = engine.values["damping"], engine.values["stiffness"]
        if self.walls.tried != (damping, stiffness):
            self._show(replace(self.walls, tried=(damping, stiffness)), self.chart.pale)
        if not self._asked:
            self.answer.show_text(
                f"Trying a wall of {stiffness:,.0f} N/m with a damping of {damping:g} N·s/m", "hand", "accent"
            )

    # methods that show results

    def show_result(self, result: ZWidth) -> None:
        """Store and show a result."""
        self._fresh[self._mode].finish()
        self._results[self._mode] = result
        self.show_found()

    def show_found(self) -> None:
        """Show the result for the chosen place, or say that it is out of date."""
        result, outdated = self.result, self._fresh[self.where.index].outdated
        self.bar.export.setEnabled(result is not None)
        self._list(result)
        if result is None:
            self._show(Walls())
            self.answer.show_text(self.begin)
            return
        self._show(Walls.of(result), bool(outdated))
        if outdated:
            self.answer.show_text(outdated)
        elif not (result.stiffness > 0.0).any():
            self.answer.show_text(result.sentence, "triangle", "danger")
        else:  # reaching the motor's limit is neither a success nor a failure
            sign = ("info", "ink2") if result.points[result.best].clamped else ("check", "ok")
            self.answer.show_text(result.sentence, *sign)

    def _show(self, walls: Walls, pale: bool = False) -> None:
        self.walls = walls
        self.chart.show_drawing(lambda figure, colors: draw(figure, colors, walls), pale)

    def _list(self, result: ZWidth | None) -> None:
        self.point.setText("")
        self.table.show_rows(COLUMNS, result.rows if result else ())
        pairs = (
            [("Measured on", result.place), *((c.name, c.text) for c in result.conditions)] if result else []
        )
        self.conditions.show_pairs(pairs)

    def show_near(self, event: "MouseEvent | None") -> None:
        """Describe the point under the pointer, and say why no stiffer wall was tried at its damping."""
        result = self.result
        index = self.chart.near(event, result.damping, result.stiffness) if event and result else None
        if result is None or index is None:
            self.point.setText("")
        else:
            text = f"{result.at(index)}{result.motor(index)}.{result.band(index)}"
            self.point.setText(f"{text} Above this stiffness {ENDED[result.points[index].ended]}.")

    def exports(self) -> tuple[Callable[[str], object], Callable[[], dict]]:
        result = self.result
        assert result is not None
        return lambda path: zwidth_figure(result, path), result.as_json

    # methods that end a measurement

    def _refresh_found(self) -> None:
        """Show whether the result is out of date, unless a measurement is running."""
        if not self.job.running:
            self.show_found()

    def _give_up(self, why: str) -> None:
        """Cancel a measurement on a device because device, loop, scene or view have changed."""
        if self.job.running and self._mode == DEVICE:
            self.job.cancel()
            self.bar.show_text(f"The measurement ended, because {why}.", danger=True)

    def _scene_changed(self) -> None:
        if self._studio.environment.key != _WALL:
            self._scene = ""  # the previous scene is not restored
            self._give_up("another scene was chosen")

    def _running_changed(self, running: bool) -> None:
        if running:
            self._refresh.start()
            return
        self._refresh.stop()
        self.force.setEnabled(True)
        scene, self._scene = self._scene, ""
        if scene and scene != self._studio.environment.key:
            self.job.wait()  # wait for the job, which is restoring the settings
            with self._studio.temporarily():
                self._studio.choose(scene)
        self.where.setEnabled(True)
        self.show_found()

    def set_shown(self, on: bool) -> None:
        super().set_shown(on)
        if not on:
            self._give_up("the view was left")

    def _failed(self, text: str) -> None:
        self.answer.show_text(text, "triangle", "danger")
        self.bar.show_text("")

    def _join(self) -> None:
        self.job.failed.connect(self._failed)
        self.job.running_changed.connect(self._running_changed)
        self.arrived.connect(self.show_point)
        self.instructed.connect(self.show_step)
        self.chart.pointed.connect(self.show_near)
        studio = self._studio
        studio.environment_changed.connect(self._scene_changed)
        studio.loop_changed.connect(lambda: self._give_up("the loop changed"))
        studio.engine_changed.connect(lambda: self._give_up("the device changed"))
        for changed in (studio.loop_changed, studio.engine_changed, studio.link_changed):
            changed.connect(self._refresh_found)
        self.where.chosen.connect(lambda _index: self._refresh_found())
        self.where.chosen.connect(lambda _index: self.measure_first())
        self._facts.changed.connect(self.measure_first)


VIEW = View("zwidth", "Z-width", 50, ZWidthPage)
