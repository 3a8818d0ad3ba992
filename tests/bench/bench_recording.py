"""The cost of recording: the loop's lateness with and without it, the load of a core, and bytes."""

import math
import statistics
import tempfile
import threading
import time
from pathlib import Path

from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.haptics import health
from hapkit_studio.haptics.engine import Engine
from hapkit_studio.sessions.recorder import BUFFER_SECONDS, Recorder
from tests.bench.frame import Row

NAME, ORDER = "recording", 62
PAIRS, SECONDS = 5, 4.0
SIZED_SECONDS = 20.0  # in s, long enough that the size of an empty file does not matter
HAND_SECONDS = 0.02
STROKE, STROKE_HZ = 0.02, 0.8  # amplitude in m and frequency in Hz of a slow hand
FASTEST, USUAL = 4000.0, 1000.0  # rates in Hz


def move_hand(engine: Engine, seconds: float) -> None:
    """Move the virtual hand to and fro for some seconds."""
    end = time.perf_counter() + seconds
    while (now := time.perf_counter()) < end:
        engine.move_hand(STROKE * math.sin(2.0 * math.pi * STROKE_HZ * now))
        time.sleep(HAND_SECONDS)


def lateness(engine: Engine, seconds: float) -> float:
    """Return the 99.9th percentile of the loop's lateness in µs over some seconds."""
    before = engine.lateness_bins.copy()
    move_hand(engine, seconds)
    return health.lateness_percentiles(engine.lateness_bins - before)["p99.9"]


def recorded(engine: Engine, recorder: Recorder, path: Path, seconds: float) -> tuple[float, float, float]:
    """Return lateness in µs during a recording, the recorder's load of a core in %, and bytes per second."""
    thread = next(thread for thread in threading.enumerate() if thread.name == "hapkit-recorder")
    assert thread.ident is not None
    clock = time.pthread_getcpuclockid(thread.ident)
    recorder.follow(engine)
    recorder.record(path)
    before = time.clock_gettime(clock)
    late = lateness(engine, seconds)
    share = 100.0 * (time.clock_gettime(clock) - before) / seconds
    written = recorder.progress.seconds
    recorder.stop()
    recorder.follow(None)
    return late, share, path.stat().st_size / written


def run() -> list[Row]:
    """Return lateness and load of a core at 4 kHz, MB per hour at 1 kHz, and MB in memory."""
    engine, recorder = Engine(SimulatedHapkit(), "spring"), Recorder()
    engine.start()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder)
        engine.set_loop(rate=FASTEST)
        without, beside = [], []
        for turn in range(PAIRS):
            without.append(lateness(engine, SECONDS))
            beside.append(recorded(engine, recorder, path / f"{turn}.hapkit", SECONDS))
        engine.set_loop(rate=USUAL)
        hour = 3600.0 * recorded(engine, recorder, path / "usual.hapkit", SIZED_SECONDS)[2]
    recorder.close()
    engine.close()
    late, share, rate = (statistics.median(column) for column in zip(*beside, strict=True))
    usual, spread = statistics.median(without), max(without) - min(without)
    return [
        Row("lateness p99.9 at 4 kHz while recording", late, "µs", "not recording", usual, late / usual,
            f"within its spread of {spread:.0f} µs", late <= usual + spread),
        Row("the recorder's share of one core, 4 kHz", share, "%", target="< 5 %", ok=share < 5.0),
        Row("an hour of the spring at 1 kHz", 1e-6 * hour, "MB", target="< 60 MB", ok=hour < 60e6),
        Row("the last 10 minutes at 4 kHz", 1e-6 * BUFFER_SECONDS * rate, "MB", target="< 150 MB",
            ok=BUFFER_SECONDS * rate < 150e6),
    ]  # fmt: skip
