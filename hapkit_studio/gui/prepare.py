"""Compiles what the loops need into numba's cache. Its own program: a compile in a thread freezes the window.

Knows no Qt, so that it is up and done sooner. Part "loop" is what the first picture waits for; part "boards",
compiled afterwards and with the lowest priority, is what a board waits for.
"""

import hashlib
import os
import sys
from pathlib import Path

import platformdirs

PARTS = ("loop", "boards")
_SOURCES = ("devices", "dynamics", "environments", "haptics", "laws", "protocol")
_QUANTUM = 20.7e-6
_NO_FILE = -1


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


def compile_loop() -> None:
    """Compile laws, the simulated loop and what the window calls, by running a loop for a moment."""
    from hapkit_studio.devices.simulated import SimulatedHapkit
    from hapkit_studio.environments import discover
    from hapkit_studio.haptics.engine import Engine

    for environment in discover().values():
        environment.force.compiled()
    engine = Engine(SimulatedHapkit(), realtime=False)
    reader = engine.reader()
    engine.start()
    engine.set_loop(delay=0.001)
    engine.health()
    reader.read()
    engine.close()


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
    {"loop": compile_loop, "boards": compile_boards}[part]()
    mark.parent.mkdir(parents=True, exist_ok=True)
    for old in mark.parent.glob(f"prepared-{part}-*"):
        old.unlink(missing_ok=True)
    mark.touch()


if __name__ == "__main__":
    main(*sys.argv[1:])
