"""Frames per second and the window thread's load of a core, relative to pyqtgraph's downsampling."""

from tests.bench.frame import Row, child

NAME, ORDER = "window", 60
SECONDS = 10


def run() -> list[Row]:
    """Return the rows of frame rate and load, both measured in a child process."""
    found = child("plots", str(SECONDS))
    ours, reference = found["ours"], found["pyqtgraph_peak"]
    fps, other = ours["fps"], reference["fps"]
    share, its = (100.0 * of["gui_thread_share"] for of in (ours, reference))
    what, name = "window, 5 curves and scene, 60 s at 4 kHz", "pyqtgraph"
    return [
        Row(what, fps, "fps", name, other, fps / other, "≥ 55 fps", fps >= 55.0),
        Row("its thread's share of one core", share, "%", name, its, share / its, "< 50 %", share < 50.0),
    ]
