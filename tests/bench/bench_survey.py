"""A survey on two local Dask workers; ``python -m tests.bench.bench_survey 25 20`` has 10⁶ points."""

import resource
import sys
import tempfile
import time
from pathlib import Path

import distributed
import numpy as np

from hapkit_studio.analysis import survey
from hapkit_studio.analysis.cluster import cluster
from tests.bench.frame import Row, print_head, print_rows

NAME, ORDER = "survey", 26
RATES, DELAYS, WORKERS, DIRECT_ROWS = 5, 2, 2, 200


def most_memory() -> float:
    """Return this program's peak memory in MB (Linux)."""
    return 1e-3 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def measure(rates: int, delays: int) -> list[Row]:
    """Return the cost per point on two workers, relative to direct calls on one core, and the memory."""
    axes, before = survey.usual_axes(rates, delays), most_memory()
    drawn = np.random.default_rng(1).integers(np.prod(axes.shape[:-1]), size=DIRECT_ROWS).tolist()
    survey.compute_rows(axes, drawn[:1])
    begin = time.process_time()
    survey.compute_rows(axes, drawn)
    direct = 1e6 * (time.process_time() - begin) / (DIRECT_ROWS * axes.shape[-1])
    local = distributed.LocalCluster(
        n_workers=WORKERS, threads_per_worker=1, dashboard_address=None, processes=True
    )
    with local, tempfile.TemporaryDirectory() as folder, cluster(local.scheduler_address) as executor:
        path, begin = Path(folder, "limits.survey"), time.perf_counter()
        survey.compute(path, axes, executor)
        seconds, points = time.perf_counter() - begin, survey.known(survey.read(path)[1])
        of_workers = max(executor.client.run(most_memory).values())  # type: ignore[attr-defined]
        size = 1e-6 * path.stat().st_size
    took, what = 1e6 * seconds * WORKERS / points, f"survey of {points:,} points, two Dask workers"
    return [
        Row(f"{what}: a point, one core", took, "µs", "direct calls", direct, direct / took),
        Row(f"{what}: all", seconds, "s"),
        Row(f"{what}: its file", size, "MB"),
        Row(f"{what}: most memory of a worker", of_workers, "MB"),
        Row(f"{what}: most memory of who asks", most_memory(), "MB", "before it", before),
    ]


def run() -> list[Row]:
    """Return the rows of a small survey."""
    return measure(RATES, DELAYS)


if __name__ == "__main__":
    print_head()
    print_rows(measure(*map(int, sys.argv[1:3])) if len(sys.argv) > 2 else run())
