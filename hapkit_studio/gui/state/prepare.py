"""Compiles the loops into numba's cache in a separate program.

Compiling in a thread would freeze the window. This module does not import Qt, so it starts quickly. The parts
are, in this order: "loop" for the first frame, "verdict" for the stability card, "laws" of the other
environments, "boards" for real boards, and "analysis" for the measuring views. The part "all" consists of all
of these.
"""

import hashlib
import os
import subprocess
import sys
from collections.abc import Callable, Iterable
from pathlib import Path

import platformdirs

from hapkit_studio import interrupts
from hapkit_studio.dynamics import nominal
from hapkit_studio.formatting import printable
from hapkit_studio.program import FILLING, configured_cache, module_command, uses_shipped_code
from hapkit_studio.resources import sources_stamp

# laws with which the loop always starts: the engine's own law, and zero force for the first tick
ALWAYS = ("free", "wall")
FIRST = "wall"
_SOURCES = ("analysis", "devices", "dynamics", "environments", "haptics", "laws", "protocol")
_STAMPED = ("loop", "verdict", "boards", "analysis")
# nice values (low priority) for parts that the user does not wait for
_NICE = {"laws": 10, "boards": 19, "analysis": 10}
_GENTLY = "--gently"
_MOST_PROGRAMS = 2
_QUANTUM = nominal.QUANTUM
_NO_FILE = -1
_MODULE = "hapkit_studio.gui.state.prepare"


def stamp(part: str) -> Path:
    """Return the file that exists once a part is compiled for these sources, this Python and this cache."""
    facts = [sources_stamp(*_SOURCES), sys.version, configured_cache(), sys.prefix]
    name = hashlib.sha256("\n".join(facts).encode()).hexdigest()[:16]
    return Path(platformdirs.user_cache_dir("hapkit-studio", appauthor=False)) / f"prepared-{part}-{name}"


def prepared(part: str) -> bool:
    """Return whether a part was compiled before.

    The part "laws" has no stamp, because each law itself knows whether it is compiled.
    """
    return os.path.exists(stamp(part)) or (uses_shipped_code() and not FILLING)


def possible() -> bool:
    """Return whether compiling is enabled."""
    return os.environ.get("NUMBA_DISABLE_JIT", "0") in ("", "0")


def begin(part: str, key: str = FIRST, gently: bool = True) -> "subprocess.Popen | None":
    """Start a program that compiles a part; return None if this was done before or is not possible.

    ``key`` is the loop's first environment. If ``gently`` is True, the program runs at low priority.
    """
    if not possible() or (prepared(part) and (part != "loop" or _has_law(key))):
        return None
    return _program(part, key, gently=gently)


def begin_laws(keys: Iterable[str], gently: bool = True) -> "list[subprocess.Popen]":
    """Start compiling the laws of environments, simple laws first; return [] if this is not possible.

    Each law can be used once it is compiled. On several processors two programs share the work.
    """
    from hapkit_studio.environments import discover

    library = discover()
    order = sorted(keys, key=lambda key: len(library[key].force.source))
    share = min(_MOST_PROGRAMS, os.cpu_count() or 1)
    shares = [order[i::share] for i in range(share)] if possible() else []
    return [_program("laws", *some, gently=gently) for some in shares if some]


def _program(part: str, *keys: str, gently: bool = False) -> subprocess.Popen:
    gently = gently and part in _NICE
    # this flag sets the priority on Windows, and is 0 elsewhere
    flags = getattr(subprocess, "BELOW_NORMAL_PRIORITY_CLASS", 0) if gently else 0
    command = module_command(_MODULE, *([_GENTLY] if gently else []), part, *keys)
    with interrupts.deferred():
        return subprocess.Popen(command, creationflags=flags)


def _has_law(key: str) -> bool:
    from hapkit_studio.environments import discover

    library = discover()
    return key not in library or library[key].force.is_compiled()


def compile_loop(key: str) -> None:
    """Compile the simulated device's loop in two programs: the tick in this one, the rest in the other."""
    with _program("paddle", key):
        from hapkit_studio.devices.simulated import SimulatedHapkit
        from hapkit_studio.environments import named
        from hapkit_studio.haptics import headless, rows
        from hapkit_studio.haptics.engine import Engine
        from hapkit_studio.haptics.tick import tick

        r, _ = headless.Scene(named("free"), {}).prepare()
        tick(r, 0.0, 1e-3, 0.0, rows.new_ring(r.control, 2).rows[0])
    engine = Engine(SimulatedHapkit(), realtime=False)
    reader = engine.reader()
    engine.start()
    engine.set_loop(delay=0.001)
    engine.health()
    reader.read()
    engine.close()


def compile_paddle(key: str) -> None:
    """Compile the simulated paddle, the loop's functions, and the loop's first laws.

    A second process compiles the tick at the same time. To balance the load, the present process compiles the
    last function of the tick.
    """
    from numba import typeof

    from hapkit_studio.devices import simulated
    from hapkit_studio.dynamics.estimators import count_response
    from hapkit_studio.environments import named
    from hapkit_studio.haptics import clib, clock, headless, health, passivity, priority, rows, simulated_loop

    r, body = headless.Scene(named("free"), {}).prepare()
    row = rows.new_ring(r.control, 2).rows[0]
    passivity.judge.compile((typeof(r), *[typeof(0.0)] * 3, typeof(row)))
    priority.probe()
    clib.assign(r.settings, r.block.settings)
    simulated_loop.follow_settings(body, r)
    simulated_loop.write_truth(body, simulated_loop.measure(body), row)
    simulated.command(body.dev, body.queue, 0.0)
    simulated.advance(body.dev, body.queue, 0.0, 0.0)
    simulated_loop.cut_motor(body)
    health.add_lateness(health.new_histogram(), 0.0)
    clock.until(clock.now())
    compile_laws(*ALWAYS, key)
    count_response("difference", 1000.0, _QUANTUM)  # the window's warnings call this function


def compile_laws(*keys: str) -> None:
    """Compile the laws of environments; an invalid or missing law does not stop the others."""
    from hapkit_studio.environments import discover
    from hapkit_studio.errors import LawError

    library = discover()
    for key in keys:
        try:
            if key in library:
                library[key].force.compiled()
        except LawError as error:
            print(printable(f"{key}: {error}"), file=sys.stderr, flush=True)


def compile_verdict(*_keys: str) -> None:
    """Compile the verdict on a scene's stability."""
    from hapkit_studio.analysis.stability.objects import OBJECTS, contact_limit
    from hapkit_studio.analysis.stability.verdict import of_spring
    from hapkit_studio.dynamics.loop_settings import LoopSettings

    of_spring(LoopSettings(), 300.0, 0.0)
    contact_limit(LoopSettings(), OBJECTS[0], {})


def compile_boards(*_keys: str) -> None:
    """Compile the loop of a serial port by calling it with a closed port and a set quit flag."""
    from hapkit_studio.haptics import arrays, block, health, link, rows, serial_loop

    r = arrays.new_arrays(block.new_block())
    r.control.quit[0] = 1
    out, late = rows.new_ring(r.control, 2), health.new_histogram()
    serial_loop.run(r, link.new_link(_QUANTUM), out, late, _NO_FILE)


def compile_analysis(*_keys: str) -> None:
    """Compile the functions of the measuring views."""
    from hapkit_studio.analysis.warm import warm_up

    warm_up()


def compile_all(*_keys: str) -> None:
    """Compile every missing part with progress messages, for example after an installation."""
    from hapkit_studio.environments import discover

    steps: list[tuple[str, Callable[[], Iterable[subprocess.Popen | None]]]] = [
        ("the loop", lambda: [begin("loop", gently=False)]),
        (
            "the environments",
            lambda: begin_laws((k for k, e in discover().items() if not e.force.is_compiled()), gently=False),
        ),
        (
            "what boards and measurements need",
            lambda: [begin(part, gently=False) for part in ("verdict", "boards", "analysis")],
        ),
    ]
    for number, (what, start) in enumerate(steps, 1):
        print(f"Compiling {what} ({number} of {len(steps)}) ...", flush=True)
        for program in start():
            if program is not None and program.wait():
                sys.exit(program.returncode)


_COMPILE: dict[str, Callable[..., None]] = {
    "loop": compile_loop,
    "paddle": compile_paddle,
    "laws": compile_laws,
    "verdict": compile_verdict,
    "boards": compile_boards,
    "analysis": compile_analysis,
    "all": compile_all,
}


def main(*args: str) -> None:
    """Compile a part for some environments, write its stamp, and delete older stamps."""
    part, *keys = [word for word in args if word != _GENTLY]
    if _GENTLY in args and hasattr(os, "nice"):
        os.nice(_NICE[part])
    mark = stamp(part)
    _COMPILE[part](*(keys or (FIRST,)))
    if part not in _STAMPED:
        return
    mark.parent.mkdir(parents=True, exist_ok=True)
    for old in mark.parent.glob(f"prepared-{part}-*"):
        old.unlink(missing_ok=True)
    mark.touch()


if __name__ == "__main__":
    interrupts.begin()
    main(*sys.argv[1:])
