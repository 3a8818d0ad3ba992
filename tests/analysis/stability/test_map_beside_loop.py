"""Computing a map on every core does not make the loop miss its deadlines."""

import contextlib
import threading

import pytest

from hapkit_studio.analysis.stability import rendered
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.errors import Cancelled
from hapkit_studio.haptics import rows
from hapkit_studio.haptics.engine import Engine
from tests.haptics import support

SAMPLES, TIMES = 1000, 3


def late_share(reader) -> float:
    """Return the smallest fraction of late samples of several attempts; other programs may disturb some."""
    found = [support.rest(reader, SAMPLES)[-SAMPLES:] for _ in range(TIMES)]
    return min(float((f[:, rows.LATENESS] > 0.5 * f[:, rows.PERIOD]).mean()) for f in found)


@pytest.mark.alone
def test_a_map_does_not_make_the_loop_late():
    """The map is computed at normal priority, at which threads without pauses would delay the loop most."""
    # this call compiles the code before the measurement
    rendered.classes(LoopSettings(), [1.0], [100.0], real=True)
    done, begun = threading.Event(), threading.Event()

    def watch(finished, of):
        if finished:
            begun.set()
        if done.is_set():
            raise Cancelled("Enough.")

    def keep_mapping():
        with contextlib.suppress(Cancelled):
            while True:
                rendered.classes(LoopSettings(), [1.0] * 50, [500.0] * 200, real=True, progress=watch)

    engine, work = Engine(SimulatedHapkit(), "wall", realtime=False), threading.Thread(target=keep_mapping)
    engine.start()
    try:
        reader = engine.reader()
        alone = late_share(reader)
        work.start()
        assert begun.wait(30.0)
        beside = late_share(reader)
    finally:
        done.set()
        engine.close()
        if work.is_alive():
            work.join()
    assert beside <= 5.0 * alone + 0.05
