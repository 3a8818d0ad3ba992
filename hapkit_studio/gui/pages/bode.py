"""The view Bode: the frequency response of the scene in the current loop or on the virtual board."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from hapkit_studio.analysis.bode import AMPLITUDE, CURVE_COLUMNS
from hapkit_studio.devices import virtual_board
from hapkit_studio.errors import ParameterError
from hapkit_studio.formatting import compact, on_screen, with_unit
from hapkit_studio.gui.pages.base import View
from hapkit_studio.gui.pages.measuring import Freshness, MeasuringPage, loop_facts
from hapkit_studio.gui.panel.limits import LoopFacts
from hapkit_studio.gui.panel.rows import ParameterRow
from hapkit_studio.gui.state.background import Progress
from hapkit_studio.gui.widgets.parts import hint
from hapkit_studio.gui.widgets.segmented import Segmented

if TYPE_CHECKING:
    from hapkit_studio.analysis.bode.result import Bode
    from hapkit_studio.gui.live.live import Live
    from hapkit_studio.gui.state.studio import Studio

SIMULATION, VIRTUAL = range(2)
_HOW = (
    "The measurement moves a simulated handle at many frequencies at once. Your own handle does not move. "
    "For a real Hapkit, the loop is simulated with the measured rate and delay. The choice Virtual board "
    "runs the real firmware twice: one time the computer computes the force, the other time the board does."
)


class BodePage(MeasuringPage):
    """Shows the scene's Bode diagram; the diagram is out of date after a change of scene, values or loop."""

    file = "bode"
    heading, about = "Bode", "How much force the scene gives for a motion, at each frequency."
    begin = "Press Measure to see up to which frequency the scene keeps its stiffness."
    drawn, listed = (
        "Impedance, stiffness, damping and mass over frequency",
        "Frequencies at which the behaviour changes",
    )
    read = (
        "Dots: measured values, with bars for the 95 % interval. Hollow dots: the force is not proportional "
        "to the motion. Solid line: theory of the sampled loop. Dashed line: above this frequency, the "
        "stiffness is more than 3 dB lower, or the loop adds more energy than the handle's damping removes. "
        "Dotted line: the handle's own mass and damping. Where the dotted line is above the stiffness, you "
        "feel mainly the mass. A law that is not linear is measured with one frequency at a time."
    )

    def __init__(self, studio: "Studio", live: "Live"):
        super().__init__(studio, live)
        self.found: Bode | None = None
        self._facts = LoopFacts(studio, self)
        live.health.connect(self._facts.note_health)
        self.where = Segmented("Measured on", ("Simulation", "Virtual board"))
        self.where.show_index(SIMULATION)
        self.where.setVisible(virtual_board.built())
        self.bar.add(self.where)
        self.amplitude = ParameterRow(AMPLITUDE)
        self.amplitude.slider.hide()
        self._fresh = Freshness(
            lambda: {
                "scene": studio.environment,
                "values": dict(studio.values),
                "place": self.where.index,
                "amplitude": self.amplitude.value,
                **loop_facts(studio, model=False),
            }
        )
        self.build()
        self.side.section("How the handle is moved")
        self.side.add(self.amplitude, hint(_HOW))
        for changed in (studio.settings_changed, studio.loop_changed, studio.engine_changed):
            changed.connect(self.show_found)
        self.where.chosen.connect(lambda _index: self.show_found())
        self.amplitude.changed.connect(lambda _key, _value: self.show_found())
        self._facts.changed.connect(self.measure_first)
        self.show_found()

    def first(self) -> str:
        known = self._facts.setting() is not None and self.where.index == SIMULATION
        return "" if self.found or not known else "loop"

    def run(self) -> None:
        """Measure the current scene in the chosen place (simulated loop or virtual board)."""
        setting, studio = self._facts.setting(), self._studio
        if setting is None or studio.engine is None:
            raise ParameterError(self._facts.why_unknown()[1])
        scene, values, on_board = studio.environment, dict(studio.values), self.where.index == VIRTUAL
        reach, most = self.amplitude.value, studio.engine.max_force
        # None stands for the default amplitude; the measurement may reduce it automatically
        amplitude = None if reach == AMPLITUDE.default else reach

        def work(progress: Progress) -> "Bode":
            from hapkit_studio.analysis.bode import on_board as board
            from hapkit_studio.analysis.bode import simulation

            found = simulation.measure(scene, values, [setting], amplitude, max_force=most)
            return board.measure(found, progress=progress) if on_board else found

        self._fresh.begin()
        self.answer.show_text("Moving the simulated handle…", "hand", "accent")
        self.job.start(work)

    def show_result(self, found: "Bode") -> None:
        """Store and show a result."""
        self.found = found
        self._fresh.finish()
        self.show_found()

    def show_found(self) -> None:
        """Show the diagram, or say that it is out of date."""
        found, outdated = self.found, self._fresh.outdated
        self.bar.export.setEnabled(found is not None)
        if found is None or self.job.running:
            return
        from hapkit_studio.charts.bode import draw

        self.chart.show_drawing(lambda figure, colors: draw(figure, colors, found), pale=bool(outdated))
        self.table.show_rows(CURVE_COLUMNS, found.curves)
        self.point.setText("\n".join(found.notes))
        pairs = [("Scene", found.environment.title), ("Handle position", on_screen(found.place, "m"))]
        pairs += [("Amplitude", on_screen(found.amplitude, "m"))]
        for curve in found.curves:
            pairs += [(f"Delay, {curve.where}", with_unit(1e6 * curve.setting.delay, "µs"))]
            if curve.clamped:
                pairs += [
                    (f"Time at the force limit, {curve.where}", f"{compact(100.0 * curve.clamped, 2)} %")
                ]
        self.conditions.show_pairs(pairs)
        if outdated:
            self.answer.show_text(outdated)
        else:
            self.answer.show_text(found.curves[-1].sentence, "info", "ink2")

    def exports(self) -> tuple[Callable[[str], object], Callable[[], dict]]:
        from hapkit_studio.charts.bode import bode_figure

        found = self.found
        assert found is not None
        return lambda path: bode_figure(found, path), found.as_json


VIEW = View("bode", "Bode", 40, BodePage, scene=False)
