"""Times of the measuring commands, run as by a user; their figures go to a folder."""

import contextlib
import io
import tempfile
import time
from pathlib import Path

from hapkit_studio.cli import main
from tests.bench.frame import Row

NAME, ORDER = "charts", 46
LOOP = ("--viscous", "0.18", "--delay", "0.001", "--estimator", "iir")
RECORD = ("run", "spring", "-p", "stiffness=300", "-p", "damping=2", "--hand", "shake", "--seconds", "6")
COMMANDS = {
    "stability": ("stability", "-K", "620", "-B", "2", *LOOP, "--measure", "--map"),
    "stability-real": ("stability", "-K", "620", "-B", "2", *LOOP, "--measure", "--map", "--real"),
    "zwidth": ("zwidth",),
    "bode": ("bode", "wall", "-p", "stiffness=300", "--rate", "1000,4000"),
    "bounce": ("break-it", "bounce"),
    "filtered_damping": ("break-it", "filtered_damping"),
    "map-integrators": ("break-it", "integrators", "--plane"),
    "map-spring": ("break-it", "sampled_spring", "--plane"),
    "map-friction": ("break-it", "limit_cycle", "--plane"),
    "identify": ("identify",),
}


def run(folder: Path | None = None) -> list[Row]:
    """Run every command once to compile and once to measure; draw figures into the folder."""
    with tempfile.TemporaryDirectory() as scratch:
        record = str(Path(scratch, "run.csv"))
        _run(*RECORD, "--csv", record)
        rows = []
        for name, args in COMMANDS.items():
            path = (folder or Path(scratch)) / f"{name}.png"
            given = (*args, record) if name == "identify" else args
            _run(*given)
            begin = time.perf_counter()
            _run(*given, "--plot", str(path))
            rows.append(Row(f"hapkit-studio {' '.join(args)}, drawn", time.perf_counter() - begin, "s"))
    return rows


def _run(*args: str) -> None:
    with contextlib.redirect_stdout(io.StringIO()):
        if main(args):
            raise RuntimeError(f"{' '.join(args)} failed")
