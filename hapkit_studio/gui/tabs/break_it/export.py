"""What Export writes of a failure: the picture of its two tries and its chart, or the same as numbers."""

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

from hapkit_studio.gui.tabs.break_it.record import Record

if TYPE_CHECKING:
    from hapkit_studio.analysis.failures import Chart
    from hapkit_studio.analysis.failures.shown import Shown


def exports(record: Record) -> tuple[Callable[[str], object], Callable[[], dict]]:
    """Return what draws a measured failure to a path, and what writes it as one object, SI."""
    shown = frozen(record)

    def figure(path: str) -> None:
        from hapkit_studio.charts.failures import failure_figure

        failure_figure(shown, path)

    return figure, lambda: as_json(shown)


def frozen(record: Record) -> "Shown":
    """Return a record as it stands; it must have been measured."""
    from hapkit_studio.analysis.failures import shown

    assert record.limit is not None
    assert record.below is not None
    assert record.above is not None
    below, above = (shown.Try(tried.value, tried.evidence) for tried in (record.below, record.above))
    return shown.Shown(record.failure, dict(record.case), record.limit, below, above, record.chart)


def as_json(shown: "Shown") -> dict:
    """Return conditions, limit, both tries with their traces, and the chart's lines."""
    failure = shown.failure
    return {
        "key": failure.key,
        "title": failure.title,
        "formula": failure.formula,
        "knob": failure.knob.key,
        "knob_unit": failure.knob.unit,
        "options": {
            p.key: p.text(shown.case[p.key]) if p.discrete else shown.case[p.key] for p in failure.options
        },
        "limit": shown.limit,
        "inside": _try(shown.inside),
        "outside": _try(shown.outside),
        "chart": _chart(shown.chart) if shown.chart else None,
    }


def _try(tried) -> dict:
    found = tried.evidence
    return {
        "value": tried.value,
        "holds": found.holds,
        "measure": _number(found.measure),
        "measure_unit": found.measure_unit,
        "words": found.words,
        "time": [float(t) for t in found.time],
        "trace": [_number(y) for y in found.trace],
        "trace_label": found.label,
        "trace_unit": found.unit,
    }


def _chart(chart: "Chart") -> dict:
    lines = [
        {
            "label": one.label,
            "role": one.role,
            "x": [_number(v) for v in one.x],
            "y": [_number(v) for v in one.y],
        }
        for one in chart.lines
    ]
    marks = [{"label": mark.label, "x": mark.x} for mark in chart.marks]
    return {
        "x_label": chart.x_label,
        "y_label": chart.y_label,
        "level": chart.level,
        "lines": lines,
        "marks": marks,
    }


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
