"""The command that computes the stiffness limits of millions of loops and can resume from its file."""

import argparse
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import AbstractContextManager, contextmanager
from multiprocessing import active_children, get_context
from pathlib import Path

from hapkit_studio import interrupts
from hapkit_studio.analysis.checks import whole_number
from hapkit_studio.analysis.cluster import cluster
from hapkit_studio.analysis.sweeps import Progress, begin_worker, workers
from hapkit_studio.commands import base
from hapkit_studio.formatting import compact, plain

DRAW_SECONDS = 10.0

OPTIONS = (
    base.option("file", type=Path, help="of the survey: created or continued"),
    base.option(
        "--rates", type=int, default=25, metavar="N", help="number of rates from 250 Hz to 10 kHz; 25"
    ),
    base.option("--delays", type=int, default=20, metavar="N", help="number of delays up to 5 ms; 20"),
    base.option("--read", action="store_true", help="compute nothing, show the stored results"),
    base.option("--workers", type=int, metavar="N", help="number of processes; one per core"),
    base.option("--scheduler", metavar="ADDRESS", help="compute on a cluster: tcp://…"),
    base.option("--plot", metavar="PATH", help="write a picture, updated during the computation"),
)


def run(options: argparse.Namespace) -> base.Result:
    """Compute the missing rows; draw the survey if requested."""
    from hapkit_studio.analysis import survey  # imported here because the import takes seconds
    from hapkit_studio.charts.survey import survey_figure

    def draw() -> list[str]:
        return base.drawn(options.plot, survey_figure, survey.read(options.file))

    rows, begin = 0, time.monotonic()
    if not options.read:
        counts = [whole_number(getattr(options, name), f"--{name}", 1) for name in ("rates", "delays")]
        with _executor(options) as executor:
            rows = survey.compute(options.file, survey.usual_axes(*counts), executor, _progress(draw))
    seconds = time.monotonic() - begin
    axes, limits = survey.read(options.file)
    known, computed = survey.known(limits), rows * axes.shape[-1]
    text = f"{axes.text}: {known:,} of {limits.size:,} loops known."
    if computed:
        each = 1e6 * seconds / computed
        text += f" {computed:,} computed in {base.span(seconds)}, {compact(each, 3)} µs each."
    as_json = {"axes": axes, "points": limits.size, "known": known, "computed": computed, "seconds": seconds}
    return base.with_files(text, plain(as_json), draw())


def _executor(options: argparse.Namespace) -> AbstractContextManager[Executor]:
    if options.scheduler is not None:
        return cluster(options.scheduler)
    count = workers() if options.workers is None else whole_number(options.workers, "--workers", 1)
    return _programs(count)


@contextmanager
def _programs(count: int) -> Iterator[Executor]:
    """Yield an executor with this many worker processes; Ctrl+C kills them at once.

    Processes are used because most of this work holds Python's lock. They are spawned, not forked, because a
    fork may copy locks in their locked state.
    """
    with ProcessPoolExecutor(count, get_context("spawn"), initializer=begin_worker) as pool:
        try:
            with interrupts.deferred():
                for _ in range(count):
                    pool.submit(int)  # each call starts a process
            yield pool
        except KeyboardInterrupt:
            # the pool's thread raises an error after its processes were killed: ignore it
            threading.excepthook = lambda _: None
            for process in active_children():
                process.kill()
            raise


def _progress(draw: Callable[[], object]) -> Progress:
    """Return a progress callback that updates one line and redraws the figure from time to time."""
    report, drawn = base.progress_line("loops' rows"), time.monotonic()

    def progress(done: int, of: int) -> None:
        nonlocal drawn
        report(done, of)
        if time.monotonic() - drawn > DRAW_SECONDS:
            draw()
            drawn = time.monotonic()

    return progress


COMMAND = base.Command("survey", "compute how stiff millions of loops may be", run, OPTIONS, 68)
