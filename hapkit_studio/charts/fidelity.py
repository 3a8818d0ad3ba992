"""The table of what each scene's device must model."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hapkit_studio.charts.style import Colors, save
from hapkit_studio.devices.simulated import TERMS

if TYPE_CHECKING:
    from hapkit_studio.analysis.fidelity import Effect, Fidelity

_OFF = ("the hand's alone", "0", "0", "0", "16 kHz", "0", "none", "true velocity")
_KEY = (
    "What a person feels of one term left out, in just-noticeable differences, JND: 6 % of a force, 15 mN at "
    "least; 0.4 mm; the least vibration felt; 20 ms of an event. Shaded: the scene needs it; felt "
    "alone, above one, or where several are left out together. "
    "Small: what is felt and computing time without ÷ with the term; with which hand."
)
_SCENE_WIDTH, _COST_WIDTH = 1.3, 0.9


def percent(change: float | None) -> str:
    """Write a share of a scale, short; what is a thousand percent or more is just that."""
    if change is None:
        return "–"
    value = 100.0 * change
    if value < 0.05:
        return "0 %"
    return "> 999 %" if value >= 999.5 else f"{value:.0f} %" if value >= 9.95 else f"{value:.1f} %"


def jnd(felt: float | None) -> str:
    """Write just-noticeable differences, short; an event that is missing is more than any number."""
    if felt is None:
        return "–"
    return (
        "0" if felt < 0.05 else "> 99" if felt >= 99.5 else f"{felt:.0f}" if felt >= 9.95 else f"{felt:.1f}"
    )


def outcome_word(key: str) -> str:
    """Write an outcome's key as words."""
    return key.removeprefix("count:").replace("_", " ")


def fidelity_figure(results: Sequence["Fidelity"], path: str | Path) -> None:
    """Write the table scene × term: the most that is felt, as what, under which hand, and its cost."""
    size = (1152, 86 + 62 * len(results))
    save(lambda figure, c: draw(figure, c, results), path, size, caption=_KEY)


def draw(figure: Any, c: Colors, results: Sequence["Fidelity"]) -> None:
    """Draw the table; what a scene needs is shaded."""
    columns = len(TERMS)
    axes = figure.add_subplot()
    axes.set_xlim(-_SCENE_WIDTH, columns + _COST_WIDTH)
    axes.set_ylim(len(results) + 0.05, -0.9)
    axes.set_axis_off()
    heads = [(term.word, f"→ {off}") for term, off in zip(TERMS.values(), _OFF, strict=True)]
    for column, (word, below) in enumerate([*heads, ("cost", "needed ÷ all")]):
        axes.text(column + 0.5, -0.55, word, ha="center", va="center", size=14, color=c.ink)
        axes.text(column + 0.5, -0.2, below, ha="center", va="center", size=11, color=c.ink3)
    for row, result in enumerate(results):
        axes.text(-0.1, row + 0.5, result.scene, ha="right", va="center", size=15, color=c.ink)
        for column, effect in enumerate(result.effects):
            _cell(axes, c, column, row, effect, effect.term in result.needs)
        saved = result.together.ns_without / result.together.ns_with
        axes.text(columns + 0.5, row + 0.5, f"{saved:.2f} ×", ha="center", va="center", size=14, color=c.ink)


def _cell(axes: Any, c: Colors, column: int, row: int, effect: "Effect", needed: bool) -> None:
    from matplotlib.patches import Rectangle

    ground, ink = (c.accentsoft, c.accent) if needed else (c.surface, c.ink3)
    axes.add_patch(Rectangle((column, row), 1.0, 1.0, facecolor=ground, edgecolor=c.line, linewidth=0.8))
    weight = "bold" if needed else "normal"
    axes.text(
        column + 0.5, row + 0.27, jnd(effect.felt), ha="center", va="center",
        size=15, color=ink, weight=weight,
    )  # fmt: skip
    if effect.felt is None:
        return
    time = f"{effect.ns_without / effect.ns_with:.2f} ×"
    words = f"{effect.sense} · {time}\n{effect.hand}" if jnd(effect.felt) != "0" else time
    axes.text(column + 0.5, row + 0.69, words, ha="center", va="center", size=10.5, color=c.ink)
