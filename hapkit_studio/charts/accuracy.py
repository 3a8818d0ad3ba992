"""Figures of speed and accuracy: work-precision charts, a scene's errors by part, the terms that scenes need.

Each method has the same marker and colour token in all charts; methods never differ in colour only.
"""

import math
import os
import platform
from collections.abc import Sequence
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

from hapkit_studio import environments
from hapkit_studio.analysis.accuracy.plan import front
from hapkit_studio.analysis.accuracy.scene import PART_WORDS, PARTS, delay_text, hertz, jnd, limit_text
from hapkit_studio.charts.style import DASH, TEXT, TICK, Colors, Label, legend, save, style_axes, write_labels
from hapkit_studio.columns import Column
from hapkit_studio.devices.simulated import TERMS
from hapkit_studio.dynamics.estimators import ESTIMATORS, parse
from hapkit_studio.dynamics.stick_slip import MODELS
from hapkit_studio.formatting import compact, significant
from hapkit_studio.haptics.board_plan import CLOCK

if TYPE_CHECKING:
    from hapkit_studio.analysis.accuracy import Accuracy
    from hapkit_studio.analysis.accuracy.needs import Needs
    from hapkit_studio.analysis.accuracy.plan import Point, Sheet
    from hapkit_studio.analysis.accuracy.scene import Option, SceneResult

_OTHERS = tuple(zip("osDp*vP^Xo", (
    "velocity", "position", "asked", "energy", "ink", "hold", "lecture", "applied", "ok", "danger",
), strict=True))  # fmt: skip
# Integrators and rates look the same as in the live plots; the look of any other method depends on its
# position in the list of methods.
_LIVE_LOOKS = {
    "explicit_euler": ("^", "applied"), "lecture": ("P", "lecture"), "semi_implicit": ("o", "velocity"),
    "verlet": ("s", "position"), "rk4": ("D", "asked"), "implicit_euler": ("v", "hold"),
    "trapezoid": ("p", "energy"), "exact": ("*", "ink"), "held": ("^", "applied"),
    "located": ("D", "asked"), "prompt": ("o", "velocity"), "late": ("v", "hold"),
}  # fmt: skip
_FAMILY = {key: n for family in (ESTIMATORS, MODELS) for n, key in enumerate(family)}


def marker_and_color(method: str) -> tuple[str, str]:
    """Return the marker and the colour token of a method."""
    return _LIVE_LOOKS.get(method, _OTHERS[_FAMILY.get(method, 0) % len(_OTHERS)])


def winner_columns(sheet: "Sheet", board: bool = False) -> tuple[Column, ...]:
    """Return the columns of the table of the cheapest methods for each tolerance, on computer or board."""
    return (
        Column("Fastest method", lambda t: sheet.winner_text(t, board), right=False),
        Column("Error ≤", sheet.scene.tolerance_text, right=False),
    )


def option_columns(found: "SceneResult") -> tuple[Column, ...]:
    """Return the columns of a scene's options: the method with its place, and its error."""
    best = [found.recommended(place.name) for place in found.question.places]
    return (
        Column(
            "Method", lambda one: f"{one.method or 'Your settings'}, {one.place}", right=False,
            mark=lambda one: option_style(one, found),
            token=lambda one: "accent" if one in best else "ink",
        ),
        Column("JND", lambda one: jnd(one.error).removesuffix(" JND"), lambda one: one.error,
               lambda one: "ok" if one.error < 1.0 else "ink"),
    )  # fmt: skip


def accuracy_figure(result: "Accuracy", path: str | Path, board: bool = False) -> None:
    """Write the figure of a result: charts of methods, bars of scenes, or the table of needed terms.

    If ``board`` is true, plot the cost on the board for the methods that the board has.
    """
    if result.needs:
        size, caption = (1280, 86 + 66 * len(result.needs)), NEEDS_KEY + _DRAWN_TOO
        save(lambda figure, c: draw_needs(figure, c, result.needs), path, size, caption=caption)
        return
    parts: Sequence[Any] = result.sheets or result.scenes
    columns = 1 if result.scenes and len(parts) <= 3 else min(len(parts), 2)
    rows, wide, high = -(-len(parts) // columns), 680, 504
    if result.scenes:
        wide, high = 860, 150 + 24 * max(10, *(len(scene.options) for scene in result.scenes))
        high += 280 * (len(parts) == 1)  # add the height of the lower chart

    def paint(figure: Any, c: Colors) -> None:
        for panel, part in zip(figure.subfigures(rows, columns, squeeze=False).flat, parts, strict=False):
            if result.sheets:
                counted = board and part.boarded
                lines = [part.scene.title, part.sentence(counted)]
            else:
                lines = [part.question.environment.title, *map(part.sentence, _places(part))]
            head = "\n".join(fill(line, wide // 8) for line in lines)
            panel.suptitle(head, x=0.02, ha="left", size=TEXT, color=c.ink)
            draw_methods(panel, c, part, counted) if result.sheets else draw_scene(panel, c, part)

    machine = f"{platform.processor() or platform.machine()}, {os.cpu_count()} cores"
    delays = delay_text(option for scene in result.scenes for option in scene.options)
    key = f"{METHODS_KEY} Timed on: {machine}" if result.sheets else f"{SCENE_KEY} Delay: {delays}."
    save(paint, path, (columns * wide, rows * high), caption=key)


# --- methods

METHODS_KEY = (
    "Methods on the left need less computing time; methods further down are more accurate. Each line is a "
    "method, and each marker a step size. The number at a line is the order of the method: at 2.00, half the "
    "step gives a quarter of the error. "
    "Filled markers: a step of 1 ms, as in the loop. Grey line: the least error at each computing time."
)
STEP = 1e-3  # s: period of the loop
# limits of the error axis: errors below _FLOOR are rounding, errors above _MOST are divergence
_FLOOR, _MOST = {"": 1e-16, "m/s": 1e-9}, 1e6
_SIZE = 9.0
_FLAT = 0.3  # if the observed order is lower, smaller steps no longer help


def draw_methods(figure: Any, c: Colors, sheet: "Sheet", board: bool = False) -> None:
    """Draw one chart of methods."""
    from matplotlib.patheffects import withStroke
    from matplotlib.ticker import LogLocator

    axes, (factor, unit), floor = figure.add_subplot(), sheet.scene.shown_unit, _FLOOR[sheet.scene.unit]

    def place(point: "Point") -> tuple[float, float]:
        return point.cost(board) * (1e-6 if board else 1e-3), min(max(point.error, floor), _MOST) * factor

    drawn, limit = [p for p in sheet.points if math.isfinite(p.cost(board))], sheet.scene.tolerance * factor
    costs, errors = zip(*map(place, drawn), strict=True)
    low, top = min(*errors, limit) / 4.0, max(*errors, limit) * 4.0
    right = max(*costs, CLOCK * 1e-6 if board else 0.0) * 1.6
    axes.set(xscale="log", yscale="log", xlim=(min(costs) / 1.6, right), ylim=(low, top))
    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0), numticks=12))
    axes.minorticks_off()
    cost = (
        "million processor cycles per second on the board"
        if board
        else "µs of computing per simulated second"
    )
    style_axes(axes, c, cost, f"{sheet.scene.error}, {unit}")
    axes.axhspan(low, limit, color=c.stable, alpha=0.45, linewidth=0.0, zorder=0.5)
    axes.axhline(limit, color=c.danger, linewidth=1.8, linestyle=DASH, zorder=2.5)
    if board:
        axes.axvline(CLOCK * 1e-6, color=c.ink2, linewidth=1.8, zorder=2.5)
        beyond = CLOCK * 1e-6, right
        axes.axvspan(*beyond, facecolor="none", edgecolor=c.line, hatch="///", linewidth=0.0, zorder=0.6)
    best = front(sheet.points, board)
    if best:  # draw the band along the Pareto front as a staircase
        places = [place(point) for point in best]
        x, y = zip((places[0][0], top), *places, (right, places[-1][1]), strict=True)
        band = {"where": "post", "linewidth": 7.2, "solid_joinstyle": "miter", "zorder": 2.0}
        rim = [withStroke(linewidth=11.2, foreground=c.ink2)]
        axes.step(x, y, color=c.theory, path_effects=rim, label="Pareto front", **band)
    orders: list[Label] = []
    for key, name in sheet.methods.items():
        points = [p for p in sheet.line(key) if p in drawn]
        shape, token = marker_and_color(key)
        color, sound = getattr(c, token), [p for p in points if math.isfinite(p.error)]
        if sound:
            axes.plot(*zip(*map(place, sound), strict=True), color=color, linewidth=1.5, zorder=3)
        # only lines over several steps get a legend entry; points with the same step get their own labels
        # below
        if len({p.step_s for p in sound}) > 1:
            axes.plot([], [], shape, color=color, markersize=_SIZE, label=name)
            if (order := sheet.order(key)) > _FLAT:
                orders.append(Label(*place(sound[-1]), f"{order:.2f}", color, bold=True))
        for point in points:
            filled = math.isclose(point.step_s, STEP)
            spread = 0.0 if board else point.spread * 1e-3
            axes.errorbar(
                *place(point), xerr=spread, fmt=shape, ecolor=color, elinewidth=1.0,
                markersize=_SIZE,
                markeredgecolor=color, markerfacecolor=color if filled else c.plot, markeredgewidth=1.5,
                zorder=5 if filled else 4,
            )  # fmt: skip
    legend(axes, c)
    figure.figure.draw_without_rendering()
    tolerance = f"within {sheet.scene.tolerance_text(sheet.scene.tolerance)}"
    found = [Label(right, limit, tolerance, c.danger, bold=True), *orders]
    if board:
        found.append(Label(CLOCK * 1e-6, top / 10.0, "board limit: 16", c.ink2))
    # all points have the same step, so label each point with its option
    if len({p.step_s for p in drawn}) == 1:
        sound = [p for p in drawn if math.isfinite(p.error)]
        found += [Label(*place(p), p.label, getattr(c, marker_and_color(p.method)[1])) for p in sound]
    write_labels(axes, c, found)


# --- this scene

SCENE_KEY = (
    "A shorter bar is closer to the ideal scene: the same law solved exactly, without sampling, delay, "
    "sensor steps or force limit. Most people notice 1 JND (just-noticeable difference). Parts left of 0 "
    "cancel other parts; the vertical mark is the total. // and →: the bar is longer than drawn. Ring: "
    "recommended."
)
OWN_KEY = """Own error: distance from the exact method at the
same rate. Filled: the rate that the board keeps.
Hollow: twice that rate."""
_FILL = {
    "method": ("ink2", ""), "rate": ("position", "///"), "delay": ("velocity", "..."),
    "velocity": ("energy", "\\\\\\"), "sensor": ("hold", "|||"), "limit": ("danger", "xxx"),
}  # fmt: skip
_AXIS_FACTOR = 2.0  # the axis ends at this multiple of the recommended options' error; longer bars are cut
_LABELLED = 0.01  # fraction of the axis; narrower parts have no label
_FEWEST_ROWS = 12.0  # smallest number of rows for the layout, so that few bars are not too thick
_BOTH, _BELOW = 560.0, 0.36  # pt: height that both charts need; height fraction of the lower chart
_LEAST_OWN, _ROUNDING = 1e-4, 1e-9  # JND: smallest error of a method that is drawn; level of rounding errors
_NAMES, _FIGURES = 206.0, 170.0  # pt: width of the labels at the left and of the figures at the right


def _places(scene: "SceneResult") -> list[str]:
    return [place.name for place in reversed(scene.question.places)]


def option_style(option: "Option", scene: "SceneResult") -> tuple[str, str]:
    """Return the marker and colour token of an option; its method or its estimator determines them."""
    first = scene.question.choices[0] if scene.question.choices else None
    return marker_and_color(first.text(option.options[0][1]) if first else parse(option.estimator)[0].key)


def options_by_location(scene: "SceneResult") -> "list[tuple[str, list[Option]]]":
    """Return the options by location: recommended options first, then by error."""
    return [
        (place, sorted(scene.at(place), key=lambda o: (o is not scene.recommended(place), o.error)))
        for place in _places(scene)
    ]


def draw_scene(figure: Any, c: Colors, scene: "SceneResult") -> None:
    """Draw one bar for each option, split into its parts if these are known."""
    wide, high = (72.0 * size / figure.dpi for size in (figure.bbox.width, figure.bbox.height))
    judged = [option for option in scene.options if option.own]
    if judged and high >= _BOTH:
        figure, below = figure.subfigures(2, 1, height_ratios=(1.0 - _BELOW, _BELOW))
        _draw_own(below, c, scene, judged)
    ratios = _NAMES, max(wide - _NAMES - _FIGURES, 200.0), _FIGURES
    names, axes, right = figure.subplots(1, 3, sharey=True, width_ratios=ratios)
    for side in (names, right):
        side.set(xlim=(0.0, 1.0))
        side.set_axis_off()
    best = [o.error for p in _places(scene) if (o := scene.recommended(p)) and math.isfinite(o.error)]
    reach, row, low = max(1.3, _AXIS_FACTOR * max(best, default=1.0)), 0.0, 0.0
    quiet = {"size": TICK, "color": c.ink3, "va": "center"}
    right.text(0.45, -0.9, "Rate", ha="right", **quiet)
    right.text(0.97, -0.9, "Stable up to", ha="right", **quiet)
    for place, options in options_by_location(scene):
        names.text(0.02, row, place.capitalize(), **quiet)
        row += 0.9
        for option in options:
            ringed, (shape, token) = option is scene.recommended(place), option_style(option, scene)
            if ringed:
                for part in (names, axes, right):
                    part.axhspan(row - 0.46, row + 0.46, color=c.accentsoft, zorder=0.4)
                names.plot(0.08, row, "o", ms=17.0, mfc="none", mec=c.accent, mew=2.2)
            names.plot(0.08, row, shape, color=getattr(c, token), markersize=8.0)
            used = "in use" if option is scene.in_force(place) else ""
            note = "default" if option is scene.default(place) else used
            name = ", ".join(filter(None, (option.method or "Your settings", note)))
            plain = {"size": TICK, "color": c.ink, "va": "center", "weight": "bold" if ringed else "normal"}
            names.text(0.17, row, name, **plain)
            low = min(low, _bar(axes, c, option, row, reach))
            right.text(0.45, row, hertz(option.rate), ha="right", **plain)
            limit = limit_text(option.limit).removeprefix("stable up to ").removeprefix("limit ")
            limit = limit.removesuffix(" stable")
            right.text(0.97, row, limit, ha="right", **plain)
            row += 1.0
    bottom = max(row, _FEWEST_ROWS)
    # the lines are drawn below the labels
    axes.vlines(1.0, -0.6, bottom, color=c.danger, linewidth=1.6, linestyle=DASH, zorder=6)
    axes.axvline(0.0, color=c.edge, linewidth=1.0, zorder=6)
    axes.set(xlim=(1.1 * low, 1.25 * reach), ylim=(bottom, -1.4))
    style_axes(axes, c, "total error, in just-noticeable differences (JND); dashed: most people feel it", "")
    axes.set_yticks([])
    for text in (*names.texts, *axes.texts, *right.texts):
        text.set_in_layout(False)
    _part_names(axes, c, scene.options, reach)


def _draw_own(figure: Any, c: Colors, scene: "SceneResult", options: "list[Option]") -> None:
    """Draw each method's error over the board's cycles: filled at its rate, hollow at twice the rate."""
    axes, right = figure.subplots(1, 2, width_ratios=(1.0, 0.62))
    right.set(xlim=(0.0, 1.0), ylim=(len(options) + 3.6, -0.5))
    right.set_axis_off()
    has, font = CLOCK * 1e-6, {"size": TICK, "va": "center"}
    right.text(0.0, 0.0, "Doubling the rate divides the error by", color=c.ink2, **font)
    for row, option in enumerate(sorted(options, key=lambda o: -o.own[0][1]), 1):
        (shape, token), (cycles, errors) = option_style(option, scene), zip(*option.own, strict=True)
        color, places = getattr(c, token), [max(e, _LEAST_OWN) for e in errors]
        axes.plot([1e-6 * n for n in cycles], places, color=color, linewidth=1.5, zorder=3)
        for n, error, face in zip(cycles, places, (color, c.plot), strict=True):
            axes.plot(1e-6 * n, error, shape, color=color, markerfacecolor=face, markersize=8.0, zorder=4)
        gain = significant(errors[0] / errors[1], 2) if errors[1] > _ROUNDING else "–"
        right.plot(0.03, row, shape, color=color, markersize=8.0)
        right.text(0.08, row, option.method, color=c.ink, **font)
        right.text(0.45, row, gain, color=c.ink2, **font)
    right.text(0.0, len(options) + 2.2, OWN_KEY, color=c.ink2, **font)
    axes.set(xscale="log", yscale="log")
    axes.set_title("How accurate is each method by itself?", loc="left", size=TICK, color=c.ink2)
    axes.margins(0.12)
    low, high = axes.get_xlim()[0], max(axes.get_xlim()[1], 2.0 * has)
    axes.set_xlim(low, high)
    axes.set_xticks([n for n in (2, 3, 5, 7, 10, 12, 16, 20, 30, 50, 100) if low <= n <= high])
    axes.minorticks_off()
    axes.axhline(1.0, color=c.danger, linewidth=1.6, linestyle=DASH, zorder=2)
    axes.axvline(has, color=c.ink2, linewidth=1.4, zorder=2)
    beyond = {"facecolor": "none", "edgecolor": c.line, "hatch": "///", "linewidth": 0.0, "zorder": 0.5}
    axes.axvspan(has, high, **beyond)
    style_axes(axes, c, "million cycles a second; hatched: beyond the board's 16", "method's own error, JND")
    axes.yaxis.set_major_formatter(lambda error, _: f"{'≤ ' if error <= _LEAST_OWN else ''}{compact(error)}")


def _bar(axes: Any, c: Colors, option: "Option", row: float, reach: float) -> float:
    """Draw an option's bar, cut at the end of the axis; return how far the bar extends to the left."""
    # the ends of the bar: to the right (True) and to the left (False)
    cut, ends = option.error > reach, {True: 0.0, False: 0.0}
    how = {"height": 0.62, "linewidth": 0.6, "zorder": 3}
    if not option.parts:
        axes.barh(row, min(option.error, reach), color=c.theory, edgecolor=c.edge, **how)
    for part, size in zip(PARTS, option.parts, strict=False):
        start, (token, hatch) = min(ends[size >= 0.0], reach), _FILL[part]
        ends[size >= 0.0] += size
        end = min(ends[size >= 0.0], reach)
        if not (cut and size < 0.0):  # in a cut bar, parts that cancel each other cannot be recognised
            color = getattr(c, token)
            axes.barh(row, end - start, left=start, facecolor=color, hatch=hatch, edgecolor=c.plot, **how)
    left = 0.0 if cut else ends[False]
    if left < -0.01 * reach:
        axes.plot([option.error] * 2, [row - 0.4, row + 0.4], color=c.ink, linewidth=2.0, zorder=7)
    end = reach if cut else max(option.error, ends[True])
    for at in (0.93, 0.95) if cut else ():  # show a break, because the bar is longer than drawn
        slash = [at * reach, (at + 0.015) * reach], [row + 0.42, row - 0.42]
        axes.plot(*slash, color=c.plot, linewidth=4.0, zorder=5)
    text = f"{jnd(option.error)}{' →' if cut else ''}"
    axes.text(end + 0.015 * reach, row, text, size=TICK, color=c.ink, va="center", zorder=7, weight="bold")
    return left


def _part_names(axes: Any, c: Colors, options: "Sequence[Option]", reach: float) -> None:
    """Label the visible parts above the bars."""
    from matplotlib.patches import Patch

    drawn = {
        p for o in options for p, size in zip(PARTS, o.parts, strict=False) if abs(size) > _LABELLED * reach
    }
    axes.legend(
        handles=[
            Patch(facecolor=getattr(c, _FILL[part][0]), hatch=_FILL[part][1], edgecolor=c.plot,
                  label=PART_WORDS.get(part, part))
            for part in PARTS if part in drawn
        ],
        loc="upper left", ncols=len(PARTS), frameon=False, fontsize=TICK, labelcolor=c.ink,
        borderaxespad=0.1, columnspacing=1.0, handlelength=1.6,
    ).set_in_layout(False)  # fmt: skip


# --- what it needs

NEEDS_KEY = (
    "What most people feel if one property is left out, in just-noticeable differences (JND). Loop at 1 kHz, "
    "delay 1 ms, velocity filter IIR at 35.5 Hz. Shaded: the scene needs the property. †: only the most "
    "sensitive people feel the difference. The text below a number names the sense that feels the difference."
)
_DRAWN_TOO = (
    " It also states the hand motion, where the difference becomes noticeable, and the change of the "
    "stiffness limit."
)


def felt_text(felt: float | None) -> str:
    """Format just-noticeable differences; an infinite one means a missing event."""
    if felt is None:
        return "–"
    most = felt >= 99.5
    return "0" if felt < 0.05 else "> 99" if most else f"{felt:.0f}" if felt >= 9.95 else f"{felt:.1f}"


EFFECT_COLUMNS = (
    Column("Most people feel", lambda effect: felt_text(effect.felt), unit="JND"),
    Column("Sense", lambda effect: effect.sense, right=False),
    Column("Hand motion", lambda effect: effect.hand, right=False),
    Column("Sensitive people feel", lambda effect: felt_text(effect.strict), unit="JND"),
    Column("When noticeable", lambda effect: effect.since_text, right=False),
    Column("Change of stiffness limit", lambda effect: effect.gain_text),
)  # each row is the effect of removing one term


def draw_needs(figure: Any, c: Colors, results: "Sequence[Needs]") -> None:
    """Draw the table of terms by scene; the terms that a scene needs are shaded."""
    axes = figure.add_subplot()
    axes.set_axis_off()
    texts, grounds = [], []
    for result in results:
        cells = [(felt_text(e.felt) + (" †" if e.differs else ""), e) for e in result.effects]
        more = [", ".join(w for w in (e.since_text, e.gain_text) if w != "–") for _, e in cells]
        texts.append([
            word if word in ("0", "–") else f"{word}\n{e.sense}, {e.hand}\n{last}".strip()
            for (word, e), last in zip(cells, more, strict=True)
        ])  # fmt: skip
        grounds.append([c.accentsoft if e.term in result.needs else c.surface for e in result.effects])
    table = axes.table(
        texts, grounds, bbox=(0.0, 0.0, 1.0, 1.0),
        rowLabels=[environments.named(r.scene).title.replace("–", "–\n") for r in results],
        colLabels=[term.word for term in TERMS.values()], cellLoc="center", edges="closed",
    )  # fmt: skip
    table.auto_set_font_size(False)
    table.set_fontsize(TICK - 2)
    for cell in table.get_celld().values():
        cell.set(edgecolor=c.line)
        cell.get_text().set_color(c.ink)
