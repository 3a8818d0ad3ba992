"""Run once, with small input, every compiled function that measurements use, to fill numba's cache."""

import math

import numpy as np

from hapkit_studio.analysis import accuracy, failures
from hapkit_studio.analysis.stability import rendered
from hapkit_studio.analysis.zwidth import simulation
from hapkit_studio.analysis.zwidth.result import Protocol
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.worker import Worker


def warm_up() -> None:
    """Compile the functions of the stability map, the charts and the protocols."""
    damping, stiffness = np.zeros(1), np.full(1, 100.0)
    # use one worker, because a sweep's low-priority threads would wait on a busy machine
    with Worker("warm-up") as one:
        rendered.boundary(LoopSettings(), damping, executor=one)
        rendered.classes(LoopSettings(controller=True), damping, stiffness, real=True, executor=one)
    for plan in accuracy.plans().values():
        for _, prepare, _ in plan.runs(plan.scenes[-1]):
            prepare(1)[0]()
    for failure in failures.failures().values():
        limit = failure.inside(failure.case())
        if math.isfinite(limit):
            failure.try_at(limit)
    simulation.trial(LoopSettings(), 300.0, 1.0, Protocol(seconds=0.2, tail=0.1))
