"""Model no more than a scene needs: what each term of the device changes, scene by scene."""

from typing import TYPE_CHECKING

from PySide6.QtWidgets import QLabel

from hapkit_studio.devices.terms import TERMS
from hapkit_studio.environments import discover
from hapkit_studio.gui.dress import dress
from hapkit_studio.gui.tabs.bar import RunBar
from hapkit_studio.gui.tabs.base import Page, Tab, filled
from hapkit_studio.gui.tabs.export import Export
from hapkit_studio.gui.tabs.fidelity_table import FidelityTable
from hapkit_studio.gui.tabs.job import Job, Progress
from hapkit_studio.gui.tabs.side import Pairs, SidePanel, hint

if TYPE_CHECKING:
    from hapkit_studio.analysis.fidelity import Effect, Fidelity
    from hapkit_studio.gui.live import Live
    from hapkit_studio.gui.studio import Studio

_READ = (
    "Each term of the simulated device is left out alone, and the scene is rendered again under each of its "
    "hands. A cell shows what changed most, as a share of its scale, the least that people feel: 0.4 mm of "
    "a position, 0.3 N of a force or the whole force, if that is more. Above 2 % the scene needs the term; "
    "above 999 % it changes by more than ten times its scale."
)
_LIVE = (
    "The live simulated device models what its scene needs. In the Live view the panel has a switch, below "
    "the loop, that models all."
)


def scale_words(outcome: str) -> str:
    """Say what a change of an outcome is a share of."""
    from hapkit_studio.analysis.outcomes import FORCE, LENGTH

    return {
        "peak_force": f"{FORCE:g} N or the largest force",
        "final_position": f"{1e3 * LENGTH:g} mm",
        "peak_position": f"{1e3 * LENGTH:g} mm",
        "energy": "what went to and fro",
    }.get(outcome, "1")


def condition_pairs() -> list[tuple[str, str]]:
    """Return the loop that every scene is judged with, as names and values."""
    from hapkit_studio.analysis.fidelity import DELAY, ESTIMATOR, RATE
    from hapkit_studio.analysis.zwidth_result import estimator_words

    velocity = estimator_words(ESTIMATOR)[1]
    return [("Rate", f"{1e-3 * RATE:g} kHz"), ("Delay", f"{1e3 * DELAY:g} ms"), ("Velocity", velocity)]


def measure(keys: list[str], progress: Progress) -> "list[Fidelity]":
    """Return every scene's judgement."""
    from hapkit_studio.analysis import fidelity

    library, steps = discover(), len(TERMS) + 2
    found = []
    for number, key in enumerate(keys):

        def say(done: int, _of: int, before: int = number * steps) -> None:
            progress(before + done, steps * len(keys))

        found.append(fidelity.compute(library[key], say))
    return found


class FidelityPage(Page):
    """Scenes down, terms across; what a cell says in words at the side."""

    side: SidePanel

    def __init__(self, studio: "Studio", live: "Live"):
        super().__init__()
        self._studio = studio
        self._results: list[Fidelity] = []
        self.job = Job(self)
        self.bar = RunBar(self.job)
        self.title = QLabel("Model no more than a scene needs")
        dress(self.title, "QLabel { font-size: 14px; font-weight: 650; }")
        self.bar.add(self.title)
        self.table = FidelityTable()
        self.details = Pairs()
        self.side = self._side()
        self.column.addWidget(filled(self.bar, self.table))
        self._export = Export(self, "fidelity", self.bar.say)
        self.bar.run_pressed.connect(self.run)
        self.bar.export_pressed.connect(self.export)
        self.job.finished.connect(self.show_results)
        self.table.chosen.connect(self.show_effect)

    def run(self) -> None:
        """Judge every scene of the library."""
        keys = list(discover())
        self.job.start(lambda progress: measure(keys, progress))

    def show_results(self, results: "list[Fidelity]") -> None:
        """Show what was found; begin with the scene in force."""
        self._results = results
        self.table.show_results(results)
        keys = [result.scene for result in results]
        key = self._studio.environment.key
        self.table.choose(keys.index(key) if key in keys else 0, 0)

    def show_effect(self, effect: "Effect") -> None:
        """Say in words what leaving out one term does to one scene."""
        scene = discover()[effect.scene]
        self.side.heading.setText(f"{scene.title} without {TERMS[effect.term].word}")
        if effect.change is None:
            self.side.words.setText("No hand of this scene holds on to the handle, so its mass stays.")
            self.details.show_pairs([])
            return
        from hapkit_studio.charts.fidelity import outcome_word, percent

        verdict = "The scene needs it." if effect.needed else "The scene does not need it."
        self.side.words.setText(verdict)
        share = effect.ns_without / effect.ns_with
        moved = percent(effect.change) != "0 %"
        most = (
            [
                ("Of", scale_words(effect.outcome)),
                ("Most in", outcome_word(effect.outcome)),
                ("Under", effect.hand),
            ]
            if moved
            else []
        )
        self.details.show_pairs(
            [("Change", percent(effect.change)), *most, ("Time without", f"{share:.2f} of the time with")]
        )

    def export(self) -> None:
        """Save the table as a picture or as numbers."""
        results = self._results

        def figure(path: str) -> None:
            from hapkit_studio.charts.fidelity import fidelity_figure

            fidelity_figure(results, path)

        def numbers() -> dict:
            from hapkit_studio.commands.fidelity import as_json

            return as_json(results, [])

        self._export.ask(figure, numbers)

    def end(self) -> None:
        self.job.end()

    def _side(self) -> SidePanel:
        side = SidePanel("Fidelity", "Measure, then choose a cell.")
        side.add(self.details)
        side.section("Read the table")
        side.add(hint(_READ))
        side.section("Conditions")
        conditions = Pairs()
        conditions.show_pairs(condition_pairs())
        side.add(conditions)
        side.section("In the window")
        side.add(hint(_LIVE))
        return side


TAB = Tab("fidelity", "Fidelity", 25, FidelityPage, scene=False)
