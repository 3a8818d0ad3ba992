"""What Export writes of a failure: the picture of its two tries and its chart, or the same as numbers."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from hapkit_studio.gui.tabs.break_it.record import Record

if TYPE_CHECKING:
    from hapkit_studio.analysis.failures.base import Shown


def exports(record: Record) -> tuple[Callable[[str], object], Callable[[], dict]]:
    """Return what draws a measured failure to a path, and what writes it as one object, SI."""
    from hapkit_studio.analysis.failures import base

    shown = frozen(record)

    def figure(path: str) -> None:
        from hapkit_studio.charts.failures import failure_figure

        failure_figure(shown, path)

    return figure, lambda: base.as_json(shown, traces=True)


def frozen(record: Record) -> "Shown":
    """Return a record as it stands; it must have been measured."""
    from hapkit_studio.analysis.failures import base

    assert record.limit is not None
    assert record.below is not None
    assert record.above is not None
    below, above = (base.Try(tried.value, tried.evidence) for tried in (record.below, record.above))
    return base.Shown(record.failure, dict(record.case), record.limit, below, above, record.chart)
