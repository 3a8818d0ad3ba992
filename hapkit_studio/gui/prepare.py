"""Compiles what the loops need into numba's cache. Its own program: a compile in a thread freezes the window.

Knows no Qt, so that it is up and done sooner. Part "loop" is what the first picture waits for; part "boards",
compiled afterwards and with the lowest priority, is what a board waits for.
"""

import hashlib
import os
import subprocess
import sys
from pathlib import Path

import platformdirs

PARTS = ("loop", "boards")
_SOURCES = ("devices", "dynamics", "environments", "haptics", "laws", "protocol")
_QUANTUM = 20.7e-6
_NO_FILE = -1
_MODULE = "hapkit_studio.gui.prepare"


def stamp(part: str) -> Path:
    """Return the file that says: for these sources, this Python and this cache, a part is compiled."""
    package = Path(__file__).resolve().parents[1]
    found = [f for folder in _SOURCES for f in sorted((package / folder).glob("*.py"))]
    facts = [f"{f}:{f.stat().st_mtime_ns}" for f in found]
    facts += [sys.version, os.environ.get("NUMBA_CACHE_DIR", ""), sys.prefix]
    name = hashlib.sha256("\n".join(facts).encode()).hexdigest()[:16]
    return Path(platformdirs.user_cache_dir("hapkit-studio")) / f"prepared-{part}-{name}"


def prepared(part: str) -> bool:
    """Say whether a part was compiled before."""
    return stamp(part).exists()


def begin(part: str) -> "subprocess.Popen | None":
    """Start compiling a part in a program of its own; None where that was done before or cannot be."""
    if prepared(part) or getattr(sys, "frozen", False):
        return None
    return subprocess.Popen([sys.executable, "-m", _MODULE, part])


def compile_loop() -> None:
    """Compile the loop on the simulated device, on two processors: paddle and laws aside, the tick here."""
    from hapkit_studio.devices.simulated import SimulatedHapkit
    from hapkit_studio.environments import named
    from hapkit_studio.haptics import headless, ring
    from hapkit_studio.haptics.engine import Engine
    from hapkit_studio.haptics.tick import tick

    with subprocess.Popen([sys.executable, "-m", _MODULE, "paddle"]):
        r, _ = headless.Scene(named("free"), {}).prepare()
        tick(r, 0.0, 1e-3, 0.0, ring.new_ring(r.control, 2).rows[0])
    engine = Engine(SimulatedHapkit(), realtime=False)
    reader = engine.reader()
    engine.start()
    engine.set_loop(delay=0.001)
    engine.health()
    reader.read()
    engine.close()


def compile_paddle() -> None:
    """Compile the laws, the simulated paddle and what else the loop calls beside the tick."""
    from hapkit_studio.devices import simulated
    from hapkit_studio.environments import discover
    from hapkit_studio.haptics import headless, histogram, plant, priority, ring, sleep

    priority.probe()
    library = discover()
    r, body = headless.Scene(library["free"], {}).prepare()
    r.values[:] = r.block_values
    plant.follow_settings(body, r)
    plant.write_truth(body, plant.measure(body), ring.new_ring(r.control, 2).rows[0])
    simulated.command(body.dev, body.queue, 0.0)
    simulated.advance(body.dev, body.queue, 0.0, plant.next_target(body, 0.0, 1e-3))
    plant.cut(body)
    histogram.add(histogram.new_histogram(), 0.0)
    sleep.until(sleep.now())
    for environment in library.values():
        environment.force.compiled()


def compile_boards() -> None:
    """Compile the loop on a serial port, by calling it with the quit word set and no port."""
    from hapkit_studio.haptics import block, histogram, line, rig, ring, serial_loop

    r = rig.new_rig(*block.new_block())
    r.control[rig.QUIT] = 1
    out, late = ring.new_ring(r.control, 2), histogram.new_histogram()
    serial_loop.run(r, line.new_line(_QUANTUM), out, late, _NO_FILE, serial_loop.new_spec())


def main(part: str = "loop") -> None:
    """Compile a part, then leave its stamp and clear older ones away."""
    if part == "boards" and hasattr(os, "nice"):
        os.nice(19)
    mark = stamp(part)
    {"loop": compile_loop, "paddle": compile_paddle, "boards": compile_boards}[part]()
    if part not in PARTS:
        return
    mark.parent.mkdir(parents=True, exist_ok=True)
    for old in mark.parent.glob(f"prepared-{part}-*"):
        old.unlink(missing_ok=True)
    mark.touch()


if __name__ == "__main__":
    main(*sys.argv[1:])
