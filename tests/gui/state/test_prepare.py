"""Order of compiling: the loop with its law first, then the other laws, fast ones first."""

import os
import subprocess
import sys
from contextlib import nullcontext
from types import SimpleNamespace

import pytest

from hapkit_studio.environments import discover
from hapkit_studio.errors import LawError
from hapkit_studio.gui.state import prepare
from hapkit_studio.laws import native
from hapkit_studio.laws.law import Law

# this program compiles only the laws into a new cache; other code comes from the usual cache
PROGRAM = """
import sys, os, numba
from hapkit_studio.gui.state import prepare
from hapkit_studio.haptics import engine, headless
numba.config.CACHE_DIR = sys.argv[1]
prepare.main(*sys.argv[2:])
print(os.nice(0))
"""


# this program prints what an engine on the simulated Hapkit compiles before its first sample
FIRST_SAMPLE = """
import time
from numba.core import event
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.haptics.engine import Engine
with event.install_recorder("numba:compile") as compiled:
    engine = Engine(SimulatedHapkit(), realtime=False)
    reader = engine.reader()
    engine.start()
    engine.set_loop(delay=0.001)
    while not len(reader.read()):
        time.sleep(0.001)
    engine.close()
print(*[event.data["dispatcher"] for _, event in compiled.buffer])
"""


@pytest.fixture
def started(tmp_path, monkeypatch):
    """Return the commands of the programs that would have been started; no part is compiled yet."""
    monkeypatch.setattr(prepare.platformdirs, "user_cache_dir", lambda *_, **__: str(tmp_path))
    programs: list[tuple[str, ...]] = []
    monkeypatch.setattr(prepare, "_program", lambda *args, gently: programs.append(args) or args)
    return programs


@pytest.fixture
def stamped(tmp_path, monkeypatch):
    """Mark every part as compiled."""
    monkeypatch.setattr(prepare.platformdirs, "user_cache_dir", lambda *_, **__: str(tmp_path))
    for part in ("loop", "boards"):
        prepare.stamp(part).touch()


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "nice"), reason="No such thing here.")
@pytest.mark.parametrize(
    ("args", "laws", "nicer"),
    [
        (("paddle", "damping"), {"free", "wall", "damping"}, 0),
        (("laws", "damping"), {"damping"}, 0),
        (("--gently", "laws", "damping", "swamp", "detents"), {"damping", "detents"}, 10),
    ],
)
def test_the_loop_needs_only_its_law_and_background_programs_have_low_priority(
    tmp_path, monkeypatch, args, laws, nicer
):
    command = [sys.executable, "-c", PROGRAM, str(tmp_path), *args]
    done = subprocess.run(command, capture_output=True, text=True, timeout=180, check=True)
    monkeypatch.setattr(native.numba.config, "CACHE_DIR", str(tmp_path))
    assert {key for key, e in discover().items() if native.is_compiled(e.force.source)} == laws
    assert int(done.stdout) == min(19, os.nice(0) + nicer)


@pytest.mark.slow
def test_the_loop_part_compiles_everything_that_the_first_sample_needs(tmp_path):
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path), "XDG_CACHE_HOME": str(tmp_path)}
    prepared = [sys.executable, "-m", "hapkit_studio.gui.state.prepare", "loop"]
    outputs = [
        subprocess.run(
            program, capture_output=True, text=True, timeout=180, check=True, env=environment
        ).stdout
        for program in (prepared, [sys.executable, "-c", FIRST_SAMPLE])
    ]
    assert outputs == ["", "\n"]


def test_a_missing_law_is_compiled_despite_the_stamp(stamped, started, monkeypatch):
    missing = discover()["puck"].force
    monkeypatch.setattr(Law, "is_compiled", lambda law: law is not missing)
    assert prepare.begin("loop", "wall") is None
    assert prepare.begin("loop", "swamp") is None
    assert prepare.begin("boards") is None
    assert prepare.begin("loop", "puck") == ("loop", "puck")
    prepare.stamp("loop").unlink()
    assert prepare.begin("loop", "cat") == ("loop", "cat")


def test_only_programs_in_the_background_have_low_priority(monkeypatch):
    commands = []
    monkeypatch.setattr(prepare.subprocess, "Popen", lambda command, **_: commands.append(command))
    monkeypatch.setattr(prepare, "prepared", lambda part: False)
    for gently in (True, False):
        prepare.begin("boards", gently=gently)
        prepare.begin_laws(["wall"], gently=gently)
        prepare.begin("loop", gently=gently)
    assert ["--gently" in command for command in commands] == [True, True, False, False, False, False]


@pytest.mark.parametrize(("processors", "programs"), [(1, 1), (2, 2), (16, 2), (None, 1)])
def test_fast_laws_are_compiled_first_on_every_processor(started, monkeypatch, processors, programs):
    monkeypatch.setattr(prepare.os, "cpu_count", lambda: processors)
    keys = ["puck", "cat", "free", "mass_spring_damper", "wall", "friction"]
    assert len(prepare.begin_laws(keys)) == programs
    size = {key: len(discover()[key].force.source) for key in keys}
    shares = [share[1:] for share in started]
    assert sorted(key for share in shares for key in share) == sorted(keys)
    assert all(list(share) == sorted(share, key=size.get) for share in shares)
    dear = sorted(keys, key=size.get)[-2:]
    assert programs == 1 or [sum(key in share for key in dear) for share in shares] == [1, 1]


@pytest.mark.parametrize("shipped", [True, False])
def test_a_bundle_compiles_only_parts_whose_machine_code_it_cannot_use(started, monkeypatch, shipped):
    monkeypatch.setattr(prepare, "uses_shipped_code", lambda: shipped)
    prepare.begin("boards")
    prepare.begin("analysis")
    assert len(started) == (0 if shipped else 2)


def test_a_law_that_cannot_be_compiled_does_not_stop_the_others(monkeypatch, capsys):
    done, laws = [], {key: environment.force for key, environment in discover().items()}

    def compiled(law):
        if law is laws["wall"]:
            raise LawError("no such type")
        done.append(law)

    monkeypatch.setattr(Law, "compiled", compiled)
    prepare.compile_laws("free", "wall", "swamp", "cat")
    assert done == [laws["free"], laws["cat"]]
    assert "wall: no such type" in capsys.readouterr().err


@pytest.mark.parametrize("code", [0, 3])
def test_setup_compiles_every_part_and_stops_at_the_first_failure(stamped, code, monkeypatch, capsys):
    programs = []

    def program(*args, gently):
        assert not gently  # the user waits for this program
        programs.append(args)
        return SimpleNamespace(returncode=code, wait=lambda: code)

    monkeypatch.setattr(prepare, "_program", program)
    monkeypatch.setattr(prepare, "prepared", lambda _part: False)
    monkeypatch.setattr(Law, "is_compiled", lambda _law: False)
    with pytest.raises(SystemExit) if code else nullcontext() as end:
        prepare.main("all")
    if code:
        assert (end.value.code, programs) == (code, [("loop", prepare.FIRST)])
        return
    parts = [*dict.fromkeys(command[0] for command in programs)]
    assert parts == ["loop", "laws", "verdict", "boards", "analysis"]
    assert {key for command in programs if command[0] == "laws" for key in command[1:]} == set(discover())
    assert "Compiling the loop (1 of 3) ..." in capsys.readouterr().out
