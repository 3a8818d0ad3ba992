"""The command for the stiffness limits of a loop, its stability margin and its map."""

import argparse
import time
from contextlib import nullcontext
from dataclasses import replace
from typing import Any

import numpy as np

from hapkit_studio.analysis.cluster import cluster
from hapkit_studio.analysis.stability import hands, kb_plane
from hapkit_studio.analysis.stability.kb_plane import RENDERED_DAMPING, WIDTH, Plane, plane
from hapkit_studio.analysis.stability.margin import hand_text, sentence
from hapkit_studio.analysis.stability.rendered import cell_centres, measure_cells, measure_points
from hapkit_studio.analysis.stability.verdict import of_spring
from hapkit_studio.charts.stability import stability_figure
from hapkit_studio.columns import Column, text_lines
from hapkit_studio.commands import base
from hapkit_studio.errors import ParameterError
from hapkit_studio.formatting import compact, number, on_screen

COLUMNS = 13
SIDE = 100


OPTIONS = (
    *base.SETTING_OPTIONS,
    base.option("-K", "--stiffness", type=float, default=300.0, metavar="N/m", help="what is rendered"),
    base.option("-B", "--damping", type=float, default=0.0, metavar="N·s/m", help="what is rendered"),
    base.option("--to", type=float, metavar="N·s/m", help="the largest damping shown"),
    base.option("--hands", action="store_true", help="the worst hand of a box around people's"),
    base.option("--measure", action="store_true", help="also find the boundary by rendering"),
    base.option("--map", action="store_true", help=f"evaluate {SIDE} × {SIDE} cells of the plane"),
    base.option("--real", action="store_true", help="measure with friction and sensor steps"),
    base.option("--scheduler", metavar="ADDRESS", help="measure on a cluster: tcp://…"),
    base.PLOT,
)


def run(options: argparse.Namespace) -> base.Result:
    """Compute the stability of a loop; measure the limits if requested."""
    _check(options)
    setting = base.setting_of(options)
    found = plane(setting, options.stiffness, options.damping, width=options.to)
    found = replace(found, verdict=of_spring(setting, options.stiffness, options.damping))
    if options.hands:
        found = kb_plane.with_family(found)
    begin = time.monotonic()
    with cluster(options.scheduler) if options.scheduler is not None else nullcontext() as executor:
        found = _measured(options, found, executor)
    seconds = time.monotonic() - begin if found.points or found.cells else None
    as_json = {**kb_plane.as_json(found), "measuring_seconds": seconds}
    return base.with_files(_text(found, seconds), as_json, base.drawn(options.plot, stability_figure, found))


def _check(options: argparse.Namespace) -> None:
    """Raise ParameterError if a point or a width is outside the map of damping and stiffness."""
    damping = RENDERED_DAMPING.check(options.damping)
    if options.to is not None and WIDTH.check(options.to) <= damping:
        raise ParameterError(
            f"The largest damping shown must be more than the rendered {options.damping:g} N·s/m, "
            f"not {options.to:g} N·s/m."
        )


def _measured(options: argparse.Namespace, found: Plane, executor: Any) -> Plane:
    """Return the limits with the requested measurements."""
    loop = found.setting
    if options.measure:
        damping = np.linspace(0.0, found.width, COLUMNS)
        points = measure_points(
            loop, damping, real=options.real, executor=executor, progress=base.progress_line("columns")
        )
        found = replace(found, points=points)
    if options.map:
        across, up = (cell_centres(end, SIDE) for end in (found.width, found.top))
        cells = measure_cells(
            loop, across, up, real=options.real, executor=executor, progress=base.progress_line("cells")
        )
        found = replace(found, cells=cells)
    return found


def _text(found: Plane, seconds: float | None) -> str:
    margin, setting, verdict = found.margin, found.setting, found.verdict
    assert verdict is not None
    limits = ", ".join(f"{hand_text(hand)} {_newtons(limit)}" for hand, limit in found.hands.items())
    lines = [
        f"{margin.stiffness:,g} N/m and {margin.damping:g} N·s/m: {sentence(margin)}",
        *verdict.lines,
        *([verdict.reason] if verdict.reason else []),
        ", ".join(f"{name.lower()} {value}" for name, value in kb_plane.conditions(setting)),
        "",
        *_table(found),
        "",
        *([f"Passive up to {compact(found.edge_damping[-1], 3)} N·s/m."] if found.edge.size else []),
        "An ideal sensor: no steps for friction to hide."
        if np.isinf(found.coulomb)
        else f"Friction hides the sensor's steps up to {found.coulomb:,.0f} N/m.",
        f"Limit in N/m at {margin.damping:g} N·s/m: {limits}.",
    ]
    if found.family is not None:
        lines += _hands(found.family, margin.damping)
    if seconds is not None:
        real = any(part.real for part in (found.points, found.cells) if part is not None)
        lines.append(
            f"measured in {on_screen(seconds, 's', 2)}{', with friction and sensor steps' if real else ''}"
        )
    if found.cells is not None:
        classes = found.cells.classes
        verbs = ("decay", "stay bounded" if found.cells.controller else "buzz", "grow")
        counts = np.bincount(classes.ravel().astype(int), minlength=len(verbs))
        text = ", ".join(f"{n:,} {verb}" for n, verb in zip(counts, verbs, strict=True))
        lines.append(f"{classes.size:,} cells: {text}")
    return "\n".join(lines)


def _hands(found: hands.Family, damping: float) -> list[str]:
    """Return lines on the worst hand at a damping, and on the published hands that define the range."""
    people = float(np.interp(damping, found.damping, found.people))
    worst = found.worst[int(np.abs(found.damping - damping).argmin())]
    mass, b, k = worst.mass, worst.damping, worst.stiffness
    return [
        f"In the worst hand of a box around people's hands {_newtons(people)} N/m: "
        f"{compact(mass, 3)} kg, {b:g} N·s/m, {compact(k, 4)} N/m.",
        *(
            f"  {hand.what}: {hands.ranges_text(hand.mass, hand.damping, hand.stiffness)}; {hand.source}"
            f"{'' if hand.read else ' (from memory)'}"
            for hand in hands.KNOWN
        ),
    ]


def _table(found: Plane) -> list[str]:
    """Return a table of stiffness limits as lines, for at most COLUMNS of the map's damping values.

    A row is a pair of indices: one into the measured arrays, one into the arrays of the whole map.
    """
    step = max((len(found.damping) - 1) // (COLUMNS - 1), 1)
    passive, points = kb_plane.passive(found), found.points
    columns = [
        Column("Damping", lambda row: f"{found.damping[row[1]]:.2f}", unit="N·s/m"),
        Column("Exact", lambda row: _newtons(found.exact[row[1]]), unit="N/m"),
        Column("Simple rule", lambda row: _newtons(found.simple[row[1]]), unit="N/m"),
        Column("Passive", lambda row: _newtons(passive[row[1]]), unit="N/m"),
    ]
    if points is not None:
        stiffness, swing = points.stiffness, points.swing
        head = "Measured" if swing is None else "Bounded"
        columns.append(Column(head, lambda row: _newtons(stiffness[row[0]]), unit="N/m"))
        if swing is not None:
            columns.append(Column("Swing", lambda row: _millimetres(swing[row[0]]), unit="± mm"))
    return text_lines(columns, enumerate(range(0, len(found.damping), step)))


def _millimetres(value: float) -> str:
    return "–" if np.isnan(value) else number(1e3 * value, 2)


def _newtons(value: float) -> str:
    return "–" if np.isnan(value) else "unlimited" if np.isinf(value) else f"{value:,.1f}"


COMMAND = base.Command(
    "stability", "compute how stiff a loop may be: exact, passive, by rule and measured", run, OPTIONS, 50
)
