"""The measured stability map: its time, one core's cells beside SciPy and MuJoCo, and its error."""

import statistics
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import numpy as np

from hapkit_studio.analysis.setting import Setting
from hapkit_studio.analysis.stability import rendered
from hapkit_studio.analysis.stability.limits import stiffness_limit
from hapkit_studio.analysis.sweeps import sweep, workers
from tests.bench import map_references as others
from tests.bench.frame import Row

NAME, ORDER = "map", 25
SETTING = Setting(mass=others.MASS, viscous=others.VISCOUS)
DAMPING = np.linspace(0.0, 40.0, 100)
STIFFNESS = np.geomspace(100.0, 40_000.0, 100)
CASES = 200
ESTIMATORS = (
    "difference",
    "iir",
    ("butterworth", {"cutoff": 60.0}),
    ("butterworth", {"cutoff": 20.0}),
    "kalman",
)


def seconds(work: Callable[[], object]) -> tuple[float, object]:
    begin = time.perf_counter()
    result = work()
    return time.perf_counter() - begin, result


def best(work: Callable[[], object], times: int = 3) -> float:
    """Return the median time of some, after one that compiles."""
    work()
    return statistics.median(seconds(work)[0] for _ in range(times))


def maps() -> list[Row]:
    """Return the time of whole maps on every core, and what a cell of them costs one core."""
    cores, rows, cells = workers(), [], DAMPING.size * STIFFNESS.size
    for what, real in (("ideal device", False), ("friction and sensor steps", True)):
        took = best(lambda real=real: rendered.classes(SETTING, DAMPING, STIFFNESS, real=real))
        rows.append(Row(f"map of 100 × 100, {what}, {cores} cores", took, "s", target="< 5 s", ok=took < 5.0))
    with ThreadPoolExecutor(1) as one:
        took = best(lambda: rendered.classes(SETTING, DAMPING, STIFFNESS, executor=one), 1)
        real = best(lambda: rendered.classes(SETTING, DAMPING, STIFFNESS, real=True, executor=one), 1)
        column = best(lambda: rendered.boundary(SETTING, DAMPING, executor=one), 1) / DAMPING.size
    rows.append(Row("a map's cell, ideal device, one core", 1e6 * took / cells, "µs"))
    rows.append(Row("a map's cell, friction and sensor steps, one core", 1e6 * real / cells, "µs"))
    rows.append(Row("a column's boundary by bisection, one core", 1e3 * column, "ms"))
    return rows


def cells_near_the_limit(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return stiffness and damping just inside and outside, so that every run takes its whole time."""
    damping = np.repeat(np.linspace(0.0, 5.0, count // 2), 2)
    limits = [stiffness_limit(SETTING.mass, SETTING.viscous, damping=b) for b in damping]
    return np.array(limits) * np.tile((0.97, 1.03), count // 2), damping


def beside_others() -> list[Row]:
    """Return cells per second on one core beside SciPy and MuJoCo, the same cells for the same time.

    Raise where more than one cell of a hundred has another verdict.
    """
    rows, ours, model = [], rendered.rendered(SETTING), others.mujoco_model()
    references: list[tuple] = [("solve_ivp with events", 4, others.scipy_cell, 50.0)]
    if model is not None:
        references.append(("MuJoCo, mj_step in a loop", 40, partial(others.mujoco_cell, model), 20.0))
    for name, count, cell, goal in references:
        k, b = cells_near_the_limit(count)
        rate = count / best(lambda k=k, b=b: rendered.judge(ours, k, b))
        took, theirs = seconds(lambda cell=cell, k=k, b=b: list(map(cell, k, b)))
        different = np.count_nonzero(np.array(theirs) != rendered.judge(ours, k, b))
        if different > 0.01 * count:
            raise RuntimeError(f"{name} judges {different} of {count} cells otherwise")
        what, ratio = "cells per second, one core, 12 s at 1 kHz", rate * took / count
        target = f"≥ {goal:g} × faster"
        rows.append(Row(what, rate, "1/s", name, count / took, ratio, target, ratio >= goal))
    return rows


def case(rng: np.random.Generator) -> tuple[Setting, float]:
    """Return a setting and a virtual damping: every rate, delay, filter and hand."""
    rate, mass = float(rng.choice([250.0, 500.0, 1e3, 2e3, 4e3])), float(10 ** rng.uniform(-2.0, -0.5))
    setting = Setting(
        mass,
        viscous=float(10 ** rng.uniform(-1.0, 0.7)),
        rate=rate,
        delay=float(rng.choice([0.0, 1.0, rng.uniform(0.0, 4.0)])) / rate,
        estimator=ESTIMATORS[rng.integers(len(ESTIMATORS))],
        hand=str(rng.choice(["released", "light", "medium", "firm"])),
    )
    return setting, float(rng.choice([0.0, 0.4 * rng.random() * mass * rate]))


def exact(setting: Setting, damping: float) -> float:
    loop = {"rate": setting.rate, "delay": setting.delay, "estimator": setting.estimator}
    return stiffness_limit(setting.mass, setting.viscous, damping=damping, hand=setting.hand, **loop)


def boundaries(cases: list[tuple[Setting, float]]) -> list[float]:
    return [rendered.stiffest(rendered.rendered(setting), damping) for setting, damping in cases]


def error() -> list[Row]:
    """Return the largest error of the measured boundary over the cases that some spring stands."""
    rng, cases = np.random.default_rng(4), []
    while len(cases) < CASES:
        drawn = case(rng)
        if exact(*drawn) > 0.0:
            cases.append(drawn)
    limits = np.array([exact(*drawn) for drawn in cases])
    worst = 100.0 * float(np.abs(np.array(sweep(boundaries, cases)) / limits - 1.0).max())
    what = f"measured boundary off the exact one, worst of {CASES}"
    return [Row(what, worst, "%", target="≤ 1 %", ok=worst <= 1.0)]


def run() -> list[Row]:
    """Return all rows of the map."""
    return maps() + beside_others() + error()
