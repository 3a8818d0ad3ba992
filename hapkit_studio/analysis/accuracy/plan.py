"""How a chart is computed: its scenes, and in each the runs whose error is known and whose cost is timed."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from hapkit_studio.analysis.accuracy import timing
from hapkit_studio.analysis.accuracy.points import Point, mark_front
from hapkit_studio.analysis.accuracy.sheet import Method, Scene, Sheet

# Of work that is short, so much is timed at once.
TIMED_STEPS = 8000


def repeats(steps: int) -> int:
    """Return how often work of so many steps is done for one timing."""
    return max(1, -(-TIMED_STEPS // max(steps, 1)))


def always(work: timing.Work) -> timing.Prepare:
    """Return what prepares work that can be done again as it is."""
    return lambda: work


@dataclass(frozen=True)
class Run:
    """One method at one step: its error, and what to time, which simulates so many seconds."""

    method: str
    label: str
    step_s: float
    error: float
    prepare: timing.Prepare
    seconds: float
    options: tuple[tuple[str, float], ...] = ()
    extra: tuple[tuple[str, float], ...] = ()


@dataclass(frozen=True)
class Plan:
    """One chart: ``runs(scene)`` computes every error; found by the name ``PLAN``."""

    key: str
    title: str
    methods: tuple[Method, ...]
    scenes: tuple[Scene, ...]
    runs: Callable[[Scene], Sequence[Run]]
    order: int

    def sheet(self, scene: Scene) -> Sheet:
        """Return a scene's sheet, its runs timed beside each other, and those that compete once more alone.

        Few take short turns, so that more turns fit in where the machine is calm.
        """
        runs = self.runs(scene)
        spent = timing.shortest([run.prepare for run in runs])
        points = [self._point(scene, run, ns) for run, ns in zip(runs, spent, strict=True)]
        rivals = [i for i, point in enumerate(points) if scene.competes(point)]
        again = timing.shortest([runs[i].prepare for i in rivals])
        for i, ns in zip(rivals, again, strict=True):
            points[i] = self._point(scene, runs[i], min(ns, spent[i]))
        return Sheet(self.key, scene, self.methods, mark_front(points))

    def _point(self, scene: Scene, run: Run, ns: float) -> Point:
        error = run.error if not math.isnan(run.error) else math.inf
        return Point(
            self.key,
            scene.key,
            run.method,
            run.step_s,
            error,
            ns / run.seconds,
            label=run.label,
            options=run.options,
            extra=run.extra,
        )
