"""Compiles what the loop needs into numba's cache. Its own program: a compile in a thread freezes the window.

Knows no Qt, so that it is up and done sooner.
"""

import hashlib
import os
import sys
from pathlib import Path

import platformdirs

_PARTS = ("devices", "dynamics", "environments", "haptics", "laws")


def stamp() -> Path:
    """Return the file that says: for these sources, this Python and this cache, all is compiled."""
    package = Path(__file__).resolve().parents[1]
    found = [f for part in _PARTS for f in sorted((package / part).glob("*.py"))]
    facts = [f"{f}:{f.stat().st_mtime_ns}" for f in found]
    facts += [sys.version, os.environ.get("NUMBA_CACHE_DIR", ""), sys.prefix]
    name = hashlib.sha256("\n".join(facts).encode()).hexdigest()[:16]
    return Path(platformdirs.user_cache_dir("hapkit-studio")) / f"prepared-{name}"


def prepared() -> bool:
    """Say whether everything was compiled before."""
    return stamp().exists()


def compile_all() -> None:
    """Compile loop, laws and what the window calls, by running a loop for a moment."""
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


def main() -> None:
    """Compile, then leave the stamp and clear older ones away."""
    compile_all()
    mark = stamp()
    mark.parent.mkdir(parents=True, exist_ok=True)
    for old in mark.parent.glob("prepared-*"):
        old.unlink(missing_ok=True)
    mark.touch()


if __name__ == "__main__":
    main()
