"""Model no more than is felt: what each term of the device changes, scene by scene."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

from hapkit_studio.analysis import fidelity
from hapkit_studio.analysis.fidelity import DELAY, ESTIMATOR, FORCE, LENGTH, RATE, Effect, Fidelity
from hapkit_studio.analysis.perception import MOMENT
from hapkit_studio.analysis.setting import estimator_words
from hapkit_studio.charts.fidelity import fidelity_figure, jnd, outcome_word, percent
from hapkit_studio.devices.simulated import TERMS
from hapkit_studio.environments import discover
from hapkit_studio.gui.background import Progress
from hapkit_studio.gui.pages.base import Pairs, SidePanel, View
from hapkit_studio.gui.pages.measuring import MeasuringPage
from hapkit_studio.gui.pages.table import Column, Table
from hapkit_studio.gui.widgets.parts import hint

if TYPE_CHECKING:
    from hapkit_studio.gui.live.live import Live
    from hapkit_studio.gui.studio import Studio

_READ = (
    "Each column leaves one term out of the simulated device and renders every scene again, with each hand "
    "that the scene has. Where the hands' scripts show no difference, they also throw the handle at "
    f"{fidelity.THROWS[0]:g} to {fidelity.THROWS[-1]:g} m/s, go on for {fidelity.LONG:g} s, and let go "
    f"every {1e3 * MOMENT:g} ms. A cell shows the most that a person feels of it, in just-noticeable "
    "differences (JND): 6 % of a force and 15 mN at least, 0.4 mm of a place, the least vibration that is "
    "felt at its frequency, 20 ms of an event. A scene needs the shaded terms: felt alone, above one, or "
    "where several are left out together."
)
_LIVE = (
    "The simulated device of the window does without its own damping and friction where a scene does not "
    "need them with the parameters it starts with. All else it always has: plots and velocity filters show "
    "the sensor's steps. To model everything always, open Loop, More in the panel of the Live view."
)


def scale_words(outcome: str) -> str:
    """Say what a change of an outcome is a share of."""
    return {
        "peak_force": f"largest force, at least {FORCE:g} N",
        "final_position": f"{1e3 * LENGTH:g} mm",
        "peak_position": f"{1e3 * LENGTH:g} mm",
        "energy": "energy exchanged",
    }.get(outcome, "1")


def measure(keys: list[str], progress: Progress) -> list[Fidelity]:
    """Return every scene's judgement."""
    library, steps = discover(), len(TERMS) + 2

    def say(at: int, done: int, _of: int) -> None:
        progress(at * steps + done, steps * len(keys))

    return [fidelity.compute(library[key], partial(say, at)) for at, key in enumerate(keys)]


@dataclass(frozen=True)
class Row:
    """A scene and what was found of it, None before it was judged."""

    key: str
    title: str
    result: Fidelity | None = None


def columns() -> tuple[Column, ...]:
    """Return the scenes' names, then a column a term."""
    names = [term.word.replace(" ", "\n") for term in TERMS.values()]
    return (Column("Scene", lambda row: row.title, right=False), *map(_column, names, range(len(TERMS))))


def _column(name: str, index: int) -> Column:
    def text(row: Row) -> str:
        if row.result is None:
            return ""
        found = row.result.effects[index]
        return jnd(found.felt) + (f"\n{found.sense}" if found.term in row.result.needs else "")

    def felt(row: Row) -> float:
        found = row.result.effects[index].felt if row.result else None
        return -1.0 if found is None else found

    def look(needed: str, spare: str) -> Callable[[Row], str]:
        return lambda row: needed if row.result and tuple(TERMS)[index] in row.result.needs else spare

    return Column(name, text, felt, token=look("accent", "ink3"), ground=look("accentsoft", "surface"))


class FidelityPage(MeasuringPage):
    """Scenes down, terms across; what a cell says in words at the side."""

    file = "fidelity"
    title = "Model no more than a scene needs"

    def __init__(self, studio: "Studio", live: "Live"):
        super().__init__(studio, live)
        self._results: list[Fidelity] = []
        self.table = Table("Scenes down, terms of the device across", cells=True)
        self.details = Pairs()
        self.side = SidePanel("Fidelity", "Choose a cell once it is measured.")
        self.side.add(self.details)
        for name, words in (("Read the table", _READ), ("In the window", _LIVE)):
            self.side.section(name)
            self.side.add(hint(words))
        conditions = Pairs(self.side.section("Conditions"))
        velocity = estimator_words(ESTIMATOR)[1]
        conditions.show_pairs(
            [("Rate", f"{1e-3 * RATE:g} kHz"), ("Delay", f"{1e3 * DELAY:g} ms"), ("Velocity", velocity)]
        )
        self.side.add(conditions)
        self.build(self.table)
        self.table.cell_chosen.connect(self._choose)
        self._list()

    def first(self) -> str:
        return "" if self._results else "scenes"

    def run(self) -> None:
        """Judge every scene of the library."""
        keys = list(discover())
        self.job.start(lambda progress: measure(keys, progress))

    def show_result(self, results: list[Fidelity]) -> None:
        """Show what was found; begin with the scene in force."""
        self._results = results
        self._list()
        keys = [row.key for row in self.table.content.rows]
        key = self._studio.environment.key
        self.table.setCurrentIndex(self.table.model().index(keys.index(key) if key in keys else 0, 1))

    def _list(self) -> None:
        found = {result.scene: result for result in self._results}
        rows = [Row(key, scene.title, found.get(key)) for key, scene in discover().items()]
        self.table.show_rows(columns(), rows)

    def _choose(self, row: Row, column: int) -> None:
        if row.result is not None:
            self.show_effect(row.result.effects[max(column - 1, 0)], row.result.needs)

    def show_effect(self, effect: Effect, needs: tuple[str, ...]) -> None:
        """Say in words what leaving out one term does to one scene."""
        scene = discover()[effect.scene]
        self.side.heading.setText(f"{scene.title} without {TERMS[effect.term].word}")
        if effect.felt is None:
            self.side.words.setText("No hand of this scene holds the handle, so its mass cannot be left out.")
            self.details.show_pairs([])
            return
        self.side.words.setText(
            "The scene needs it." if effect.term in needs else "The scene does not need it."
        )
        pairs = [("Felt", f"{jnd(effect.felt)} JND")]
        if jnd(effect.felt) != "0":
            pairs += [("As a", effect.sense), ("With the hand", effect.hand)]
        if effect.moves:
            change = percent(effect.change), outcome_word(effect.outcome), scale_words(effect.outcome)
            pairs += zip(("Largest change", "Of the", "100 % is"), change, strict=True)
        share = effect.ns_without / effect.ns_with
        self.details.show_pairs([*pairs, ("Computing time", f"{share:.2f} of that with it")])

    def exports(self) -> tuple[Callable[[str], object], Callable[[], dict]]:
        from hapkit_studio.commands.fidelity import as_json

        results = self._results
        return lambda path: fidelity_figure(results, path), lambda: as_json(results)


VIEW = View("fidelity", "Fidelity", 25, FidelityPage, scene=False)
