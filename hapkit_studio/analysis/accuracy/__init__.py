"""Speed charted against accuracy: what each method's error costs, and which one a scene should use.

One file a chart, found by the name ``PLAN``.
"""

import time
from collections.abc import Iterable, Mapping
from functools import cache
from types import MappingProxyType

from hapkit_studio import discovery
from hapkit_studio.analysis.accuracy.plan import Accuracy, Chart, Plan, Point, Trace
from hapkit_studio.analysis.sweeps import Progress, no_progress
from hapkit_studio.discovery import declared
from hapkit_studio.errors import ParameterError


@cache
def plans() -> Mapping[str, Plan]:
    """Return every chart's plan by its key, in their order."""
    found = declared(__name__, "PLAN", Plan)
    return MappingProxyType({plan.key: plan for plan in sorted(found, key=lambda plan: plan.order)})


def named(key: str) -> Plan:
    """Return the plan of a chart; raise ParameterError listing those there are."""
    return discovery.named(plans(), key, "accuracy chart")


def trace(point: Point) -> Trace | None:
    """Return a point's motion over time beside the true one, None where its chart has no such motion."""
    computed = named(point.chart).trace
    return computed(point) if computed else None


def compute(
    charts: Iterable[str] = (), scene: str | None = None, *, progress: Progress = no_progress
) -> Accuracy:
    """Return the charts of these keys, none for all, with all their scenes or one alone.

    progress is told after every scene how many of how many are done. Costs are timed in the calling thread,
    one after the other: beside other work they would be that work's. Raise ParameterError.
    """
    chosen = [named(key) for key in charts] or list(plans().values())
    wanted = [(plan, [s for s in plan.scenes if scene in (None, s.key)]) for plan in chosen]
    wanted = [(plan, scenes) for plan, scenes in wanted if scenes]
    if not wanted:
        known = ", ".join(s.key for plan in chosen for s in plan.scenes)
        raise ParameterError(f"There is no scene {scene!r} in these charts; there are: {known}.")
    begin = time.perf_counter()
    of, done, made = sum(len(scenes) for _, scenes in wanted), 0, []
    progress(done, of)
    for plan, scenes in wanted:
        sheets = []
        for one in scenes:
            sheets.append(plan.sheet(one))
            done += 1
            progress(done, of)
        made.append(Chart(plan.key, plan.title, tuple(sheets)))
    return Accuracy(tuple(made), time.perf_counter() - begin)
