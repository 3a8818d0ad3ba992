"""The chain from method to hand: a small chart a step, and the error felt over achievable stiffness."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hapkit_studio.analysis.accuracy.velocity import SHORT
from hapkit_studio.analysis.chain import SUFFICIENT
from hapkit_studio.charts.accuracy import marker_and_color
from hapkit_studio.charts.style import (
    DASH,
    TEXT,
    TICK,
    Colors,
    Label,
    legend,
    save,
    style_axes,
    write_labels,
)
from hapkit_studio.haptics.engine import BOARD, COMPUTER

if TYPE_CHECKING:
    from hapkit_studio.analysis.chain import Candidate, Chain

_KEY = (
    "Filled: the board. Hollow: the computer. Ring: the default. Grey: the Pareto front of each. Below "
    "the dashed line nobody tells a method from the exact one. Velocity: the estimator in force."
)
_LEAST = 1e-2  # JND: what is less is drawn there
_MOST = 300.0
_STEPS = (
    ("force error, N", lambda c: max(c.force_error, 1e-4), (BOARD, COMPUTER)),
    ("board, cycles", lambda c: c.cost, (BOARD,)),
    ("computer, ns", lambda c: c.cost, (COMPUTER,)),
    ("highest rate, Hz", lambda c: c.fastest, (BOARD, COMPUTER)),
    ("limit, N/m", lambda c: c.limit, (BOARD, COMPUTER)),
    ("felt, JND", lambda c: min(max(c.error, _LEAST), _MOST), (BOARD, COMPUTER)),
)


def chain_figure(chains: "Sequence[Chain]", path: str | Path, steps: bool = True) -> None:
    """Write the chain of each scene, a panel each; steps: with a small chart of every step above it."""
    columns = min(len(chains), 3)
    rows = -(-len(chains) // columns)
    size = (900, 640) if steps else (columns * 480, rows * 400)

    def paint(figure: Any, c: Colors) -> None:
        panels = figure.subfigures(rows, columns, squeeze=False).flat
        joint = []
        for panel, chain in zip(panels, chains, strict=False):
            panel.suptitle(chain.question.environment.title, x=0.02, ha="left", size=TEXT, color=c.ink)
            joint.append(_panels(panel, c, chain, steps))
        figure.draw_without_rendering()
        for axes, chain in zip(joint, chains, strict=True):
            _names(axes, c, chain)

    said = [
        f"{ch.question.environment.title}, {p.name}: {ch.sentence(p.name)}"
        for ch in chains
        for p in ch.question.places
    ]
    save(paint, path, size, caption="\n".join((_KEY, *said)))


def draw(figure: Any, c: Colors, chain: "Chain") -> None:
    """Draw a scene's steps and what joins them."""
    axes = _panels(figure, c, chain, steps=True)
    figure.draw_without_rendering()
    _names(axes, c, chain)


def shown(chain: "Chain", place: str) -> "list[Candidate]":
    """Return the candidates of a place with the estimator in force, or all where only that is chosen."""
    force = chain.in_force(place)
    return [
        c for c in chain.at(place)
        if not c.method or force is None or c.estimator == force.estimator
    ]  # fmt: skip


def look(candidate: "Candidate", chain: "Chain") -> tuple[str, str]:
    """Return marker and colour token of a candidate: its method's, or its estimator's."""
    first = chain.question.choices[0] if chain.question.choices else None
    key = first.text(candidate.options[0][1]) if first else candidate.estimator
    return marker_and_color(key)


def _name(candidate: "Candidate") -> str:
    return candidate.method or SHORT[candidate.estimator]


def _panels(figure: Any, c: Colors, chain: "Chain", steps: bool) -> Any:
    """Draw a row of steps, below it the joint chart; return that chart's axes."""
    if not steps:
        axes = figure.add_subplot()
    else:
        grid = figure.add_gridspec(2, len(_STEPS), height_ratios=(2, 3))
        axes = figure.add_subplot(grid[1, :])
        names = list(dict.fromkeys(_name(x) for p in (COMPUTER, BOARD) for x in shown(chain, p)))[::-1]
        for column, step in enumerate(_STEPS):
            _step(figure.add_subplot(grid[0, column]), c, chain, names, step, named=column == 0)
    _joint(axes, c, chain)
    return axes


def _step(axes: Any, c: Colors, chain: "Chain", names: list[str], step: tuple, named: bool) -> None:
    title, value, places = step
    for place in places:
        force = chain.in_force(place)
        if force is not None and place == places[0]:
            at = names.index(_name(force))
            axes.axhspan(at - 0.45, at + 0.45, color=c.accentsoft, zorder=0.5)
        for one in shown(chain, place):
            _mark(axes, c, chain, one, value(one), names.index(_name(one)))
    style_axes(axes, c, title, "")
    axes.margins(x=0.1)  # no mark is cut off at the end
    if value is _STEPS[0][1] or value is _STEPS[-1][1]:
        axes.set_xscale("log")
        axes.minorticks_off()
    else:
        axes.set_xlim(left=0.0)
        axes.locator_params(axis="x", nbins=3)
    axes.set_yticks(range(len(names)), names if named else [""] * len(names))
    axes.set_ylim(-0.7, len(names) - 0.3)
    if "JND" in title:
        axes.axvline(SUFFICIENT, color=c.danger, linewidth=1.4, linestyle=DASH)


def _mark(
    axes: Any, c: Colors, chain: "Chain", one: "Candidate", x: float, y: float, size: float = 7.0
) -> None:
    shape, token = look(one, chain)
    color = getattr(c, token)
    face = color if one.place == BOARD else c.plot
    axes.plot(x, y, shape, markersize=size, markeredgecolor=color, markerfacecolor=face, zorder=4)


def _place(one: "Candidate") -> tuple[float, float]:
    """Return where a candidate stands in the joint chart."""
    return one.limit, min(max(one.error, _LEAST), _MOST)


def _joint(axes: Any, c: Colors, chain: "Chain") -> None:
    known = [one for one in chain.candidates if one.limit > 0.0 and math.isfinite(one.limit)]
    for place in (COMPUTER, BOARD):
        front = sorted({_place(one) for one in known if one.place == place and one.pareto})
        if front:
            x, y = zip((0.0, front[0][1]), *front, (front[-1][0], _MOST), strict=True)
            axes.step(x, y, where="pre", color=c.theory, linewidth=6.0, zorder=1.0)
        default = chain.default(place)
        if default in known:
            axes.plot(
                *_place(default), "o", markersize=19, markerfacecolor="none", markeredgecolor=c.accent,
                markeredgewidth=2.2, zorder=5,
            )  # fmt: skip
        force = chain.in_force(place)
        if force in known:
            axes.plot(
                *_place(force), "o", markersize=13, markerfacecolor="none", markeredgecolor=c.ink, zorder=6
            )
    for one in known:
        _mark(axes, c, chain, one, *_place(one), size=8.5)
    axes.axhline(SUFFICIENT, color=c.danger, linewidth=1.6, linestyle=DASH, zorder=2)
    axes.set(
        yscale="log",
        ylim=(0.6 * _LEAST, 1.6 * _MOST),
        xlim=(0.0, 1.2 * max((k.limit for k in known), default=1.0)),
    )
    axes.set_yticks([_LEAST, 0.1, 1.0, 10.0, 100.0], ["≤ 0.01", "0.1", "1", "10", "100"], size=TICK)
    axes.minorticks_off()
    style_axes(axes, c, "achievable stiffness, N/m", "error felt, JND")
    legend(axes, c)


def _names(axes: Any, c: Colors, chain: "Chain") -> None:
    """Name the cheapest sufficient choice of each place, and each method once where it is stiffest."""
    labels = []
    for place in (COMPUTER, BOARD):
        best = chain.answer(place).cheapest
        for one in shown(chain, place):
            chosen = best is not None and (one.options == best.options if best.method else one is best)
            if one.limit > 0.0 and math.isfinite(one.limit) and (chosen or place == BOARD):
                words = f"{_name(one)}, {place}" if chosen else _name(one)
                color = c.accent if chosen else getattr(c, look(one, chain)[1])
                labels.append(Label(*_place(one), words, color, bold=chosen))
    write_labels(axes, c, labels)
