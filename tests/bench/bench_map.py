"""The stability map: its time relative to NumPy on all cores, and the error of the measured boundary."""

import statistics
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from hapkit_studio.analysis.stability import rendered
from hapkit_studio.analysis.stability.limits import stiffness_limit
from hapkit_studio.analysis.sweeps import sweep, workers
from hapkit_studio.dynamics.loop_settings import LoopSettings
from tests.bench import map_references
from tests.bench.frame import Row

NAME, ORDER = "map", 25
SETTING = LoopSettings()
DAMPING = np.linspace(0.0, 40.0, 100)
STIFFNESS = np.geomspace(100.0, 40_000.0, 100)
CASES = 200
FASTER = 3.0
"""Target of NumPy's time over the map's: 0.4 s where NumPy takes 1.2 s."""
ESTIMATORS = (
    "difference",
    "iir",
    ("butterworth", {"cutoff": 60.0}),
    ("butterworth", {"cutoff": 20.0}),
    "kalman",
)


def best(work: Callable[[], object], times: int = 3, clock: Callable[[], float] = time.process_time) -> float:
    """Return the median time of several runs after a run that compiles; by default it is processor time."""

    def took() -> float:
        begin = clock()
        work()
        return clock() - begin

    work()
    return statistics.median(took() for _ in range(times))


def maps() -> list[Row]:
    """Return the time of whole maps on one core relative to NumPy, and on all cores.

    For a map with friction and sensor steps, the studio simulates a few of its cells, and NumPy all of them.
    Raise RuntimeError if more than 1 % of the cells differ.
    """
    k, b = (axis.ravel() for axis in np.meshgrid(STIFFNESS, DAMPING, indexing="ij"))
    rows, what = [], f"map of {STIFFNESS.size} × {DAMPING.size}"
    with ThreadPoolExecutor(1) as one:
        for device, real, name, reference in (
            ("ideal device", False, "NumPy, eigenvalues of all cells", map_references.by_roots),
            ("friction and sensor steps", True, "NumPy, all cells stepped at once", map_references.by_steps),
        ):

            def ours(real: bool = real) -> np.ndarray:
                return rendered.classes(SETTING, DAMPING, STIFFNESS, real=real, executor=one)

            def theirs(reference: Callable = reference) -> np.ndarray:
                return reference(SETTING, k, b)

            if np.count_nonzero(theirs() != ours().ravel()) > 0.01 * k.size:
                raise RuntimeError(f"{name}: more than 1 % of the cells are judged otherwise")
            took, other = best(ours), best(theirs)
            compared = name, other, other / took
            goal = (f"≥ {FASTER:g} × as fast", other >= FASTER * took) if real else ("", None)
            rows.append(Row(f"{what}, {device}, one core", took, "s", *compared, *goal))
        every = best(lambda: rendered.judge(rendered.rendered(SETTING, True), k, b), 1)
        rows.append(Row(f"{what}, the same with every cell rendered", every, "s"))
        column = best(lambda: rendered.boundary(SETTING, DAMPING, executor=one), 1) / DAMPING.size
    whole = best(lambda: rendered.classes(SETTING, DAMPING, STIFFNESS, real=True), clock=time.perf_counter)
    cores = f"{what}, friction and sensor steps, {workers()} cores"
    rows.append(Row(cores, whole, "s", target="< 5 s", ok=whole < 5.0))
    rows.append(Row("a column's boundary by bisection, one core", 1e3 * column, "ms"))
    return rows


def case(rng: np.random.Generator) -> tuple[LoopSettings, float]:
    """Return a random setting and virtual damping, from every rate, delay, filter and hand."""
    rate, mass = float(rng.choice([250.0, 500.0, 1e3, 2e3, 4e3])), float(10 ** rng.uniform(-2.0, -0.5))
    setting = LoopSettings(
        mass=mass,
        viscous=float(10 ** rng.uniform(-1.0, 0.7)),
        rate=rate,
        delay=float(rng.choice([0.0, 1.0, rng.uniform(0.0, 4.0)])) / rate,
        estimator=ESTIMATORS[rng.integers(len(ESTIMATORS))],
        hand=str(rng.choice(["released", "light", "medium", "firm"])),
    )
    return setting, float(rng.choice([0.0, 0.4 * rng.random() * mass * rate]))


def exact(setting: LoopSettings, damping: float) -> float:
    loop = {"rate": setting.rate, "delay": setting.delay, "estimator": setting.estimator}
    return stiffness_limit(setting.mass, setting.viscous, damping=damping, hand=setting.hand, **loop)


def boundaries(cases: list[tuple[LoopSettings, float]]) -> list[float]:
    return [rendered.stiffest(rendered.rendered(setting), damping) for setting, damping in cases]


def error() -> list[Row]:
    """Return the largest error of the measured boundary over those cases that have a stable spring."""
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
    """Return the benchmark's rows on the stability map."""
    return maps() + error()
