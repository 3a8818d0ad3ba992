"""Speed and accuracy: each method's cost and error, the best method for a scene, and the terms a scene needs.

Each module with a ``PLAN`` defines one work-precision chart.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
from types import MappingProxyType
from typing import Any

from hapkit_studio import discovery
from hapkit_studio.analysis.accuracy import needs, scene
from hapkit_studio.analysis.accuracy.needs import Needs
from hapkit_studio.analysis.accuracy.plan import Plan, Sheet
from hapkit_studio.analysis.accuracy.scene import SceneRequest, SceneResult
from hapkit_studio.analysis.perception import FORCE_SHARE
from hapkit_studio.analysis.sweeps import Progress, no_progress
from hapkit_studio.discovery import declared
from hapkit_studio.environments.base import Environment


@dataclass(frozen=True)
class Accuracy:
    """Results: charts of methods, options of scenes, and the terms that scenes need; each may be empty."""

    sheets: tuple[Sheet, ...] = ()
    scenes: tuple[SceneResult, ...] = ()
    needs: tuple[Needs, ...] = ()


@cache
def plans() -> Mapping[str, Plan]:
    """Return every chart's plan by its key, in order."""
    found = declared(__name__, "PLAN", Plan)
    return MappingProxyType({plan.key: plan for plan in sorted(found, key=lambda plan: plan.order)})


def _each(work: Callable[[Any], Any], cells: Sequence, progress: Progress) -> tuple:
    found = []
    for done, cell in enumerate(cells):
        progress(done, len(cells))
        found.append(work(cell))
    progress(len(cells), len(cells))
    return tuple(found)


def of_methods(charts: Iterable[str] = (), progress: Progress = no_progress) -> Accuracy:
    """Compute the charts with these keys, or all charts; raise ParameterError for an unknown key.

    Costs are measured one after the other in the calling thread, so no other work may run at the same time.
    """
    chosen = [discovery.named(plans(), key, "accuracy chart") for key in charts] or list(plans().values())
    cells = [(plan, one) for plan in chosen for one in plan.scenes]
    return Accuracy(sheets=_each(lambda cell: cell[0].sheet(cell[1]), cells, progress))


def of_scenes(questions: Sequence[SceneRequest], progress: Progress = no_progress) -> Accuracy:
    """Compute every option of these scenes, and split each error into its parts."""
    return Accuracy(scenes=_each(lambda one: scene.split(scene.compute(one)), questions, progress))


def of_needs(
    environments: Sequence[Environment], progress: Progress = no_progress, force_share: float = FORCE_SHARE
) -> Accuracy:
    """Determine the terms that these scenes need at default values.

    ``force_share`` is the relative JND of a force.
    """
    work = partial(needs.compute, force_share=force_share)
    return Accuracy(needs=_each(work, environments, progress))
