"""The firmware renders laws on an imposed motion with the same bits as the machine on this computer.

At 1 kHz or less, every tick is reported with the position and velocity that the board used, the force, and a
state value. The machine on this computer and the law in double precision get the same rows from the first on.
"""

import math
from dataclasses import dataclass

import numpy as np
import pytest

from hapkit_studio.laws import machine
from hapkit_studio.laws.board import Program
from hapkit_studio.laws.law import Law
from hapkit_studio.workshop import reading
from hapkit_studio.workshop.own import built_in
from tests.firmware import board_runs
from tests.firmware.vb import QUANTUM, needs_board, opened
from tests.laws import clock_law, random_laws, table_law
from tests.laws.error_analysis import Analysis, Fault, Unclear, compile_unrounded, single
from tests.laws.machine_pc import Machine, build, needs_compiler
from tests.laws.twins import Compiled, NoNumber, Plain
from tests.wide import wide

ENVIRONMENTS = built_in()
pytestmark = [needs_board, needs_compiler]

BOUND = 2e-3  # largest difference in N from the Python law
ARENA = machine.ARENA
# the handle first rests, then moves into and out of objects on both sides
MOTION = ("0 position 0", "0.15 position 0.013 0.06", "0.22 position -0.02 0.1", "0.33 position 0.011 0.08")
SECONDS = 0.4
CASES = [
    ("spring", {"damping": 3.0}),
    ("wall", {"damping": 5.0}),
    ("friction", {}),
    ("friction", {"model": "lugre"}),
    ("hard_surface", {}),
    ("texture", {"kind": "sandpaper"}),
    ("mass_spring_damper", {"integrator": "verlet"}),
    ("cat", {}),
]
MORE = [
    ("bump_valley", {"width": 0.04}),
    ("bump_valley", {"law": "height"}),
    ("texture", {"kind": "grating"}),
    ("button", {}),
    ("detents", {}),
    ("friction", {"model": "tether"}),
    ("mass_spring_damper", {}),
    ("puck", {}),
]
SAMPLE = (2002, 2005, 2007, 2017)


@dataclass
class Run:
    """A board's reports on one law: rows (n, 2), forces (n,), and one state (index, value) per frame."""

    rows: np.ndarray
    forces: np.ndarray
    states: list[tuple[int, float]]
    refused: bool


def rate_of(program: Program) -> int | None:
    """Return a rate at which every tick is reported and the law fits its period, or None without one."""
    for rate in (1000, 500):
        if program.most + machine.REST_AT_MOST + machine.FRAME < 16_000_000 // rate:
            return rate
    return None


def rendered(folder, program: Program, rate: int) -> Run:
    """Return the board's reports from a law's first tick until the time ends or its force is NaN."""
    commands = folder / "script.txt"
    commands.write_text("\n".join(MOTION))
    with opened(log=folder / "truth.f64", script=commands, options=board_runs.WAITING) as board:
        board.start_stream()
        stream = board_runs.frames(board)
        seen = [board_runs.send(board, program, rate, stream=stream)]
        seen += board_runs.listen(board, SECONDS, stream)
    assert (np.diff([f.seq for f in seen]) & 0xFFFF == 1).all()
    refused = seen[-1].time_us - seen[0].time_us < 1e6 * SECONDS
    rows = np.array([(f.count * float(np.float32(QUANTUM)), f.velocity) for f in seen], np.float32)
    return Run(rows, np.array([f.asked for f in seen]), [(f.state_at, f.state) for f in seen], refused)


@pytest.fixture(scope="module")
def twin():
    """Return the machine on this computer."""
    with Machine(build()) as made:
        yield made


def hold(twin: Machine, program: Program, found: Run) -> Run:
    """Assert that the bits equal those of the machine on this computer; return the run from its first tick.

    The last force may be NaN. On a busy line, the first tick's frame may be missing; the handle was at rest
    then, as in the next tick.
    """
    for missing in (0, 1):
        rows = np.concatenate([found.rows[:1]] * missing + [found.rows])
        loaded = twin.load(program.states, program.given, program.slots, program.code)
        assert loaded.refusal == machine.Refusal.NONE
        assert loaded.cycles == program.most
        forces, states = (part[missing:] for part in twin.run(rows))
        none = np.flatnonzero(~np.isfinite(forces))
        end = none[0] if len(none) else len(forces)
        known = [k for k in range(end) if found.states[k][0] < program.states]
        mine = [*forces[:end], *(states[k, found.states[k][0]] for k in known)]
        its = np.array([*found.forces[:end], *(found.states[k][1] for k in known)], np.float32)
        same = np.equal(mine, its) | (np.isnan(mine) & np.isnan(its))
        if same.all():
            break
    assert same.all(), int(np.argmin(same))
    assert not np.isfinite(found.forces[end : end + 1]).any()
    forces = np.concatenate([np.full(missing, np.nan), found.forces])
    return Run(rows, forces, found.states, found.refused)


def apart(law: Law, values, program: Program, rate: int, found: Run) -> float:
    """Return the largest amount in N by which a force's error exceeds its error bound.

    The comparison ends at the first row whose bound is too large.
    """
    exact, analysis = Plain(law, values, 1.0 / rate), Analysis(program)
    worst = 0.0
    for (x, v), asked in zip(found.rows.astype(float).tolist(), found.forces, strict=True):
        try:
            force = exact.call(x, v)
            value, bound = analysis.call(x, v)
        except (Unclear, NoNumber, Fault):
            break
        if not math.isfinite(value) or analysis.zero_sign or bound > 0.1 * (1.0 + abs(force)):
            break
        if not math.isnan(asked):
            worst = max(worst, abs(asked - force) - 1.001 * bound)
    return worst


def hold_to_python(environment, values, twin: Machine, folder) -> np.ndarray:
    """Assert that the board's forces agree with those of the Python law; return the board's forces."""
    rate = rate_of(board_runs.program(environment, values, 1000, ARENA))
    assert rate
    program = board_runs.program(environment, values, rate, ARENA)
    assert program.size <= ARENA
    found = rendered(folder, program, rate)
    assert not found.refused
    assert np.ptp(found.rows[:, 0]) > 0.02
    found = hold(twin, program, found)
    law = Compiled(environment.force, values, 1.0 / rate)
    wanted = np.array([law.call(x, v) for x, v in found.rows.astype(float).tolist()])
    near = ~(np.abs(found.forces - wanted) > BOUND)
    assert near.mean() >= 0.99, int(np.argmin(near))
    return wanted


@pytest.mark.parametrize(("key", "given"), wide(CASES + MORE, lambda key, given: (key, given) in CASES[::2]))
def test_the_firmware_renders_an_environment(key, given, twin, tmp_path):
    environment = ENVIRONMENTS[key]
    assert np.abs(hold_to_python(environment, environment.values(given), twin, tmp_path)).max() > 0.05


OWN = '''"""Two walls and something sticky between them."""

import math

from hapkit_studio.environments.base import Environment
from hapkit_studio.laws import law
from hapkit_studio.parameters import Choice, Parameter


def wall(depth, stiffness):
    if depth <= 0.0:
        return 0.0
    return stiffness * depth


@law(state={"warmth": 0.0})
def force(p, s, x, v, dt):
    s.warmth += dt * (abs(v) - 2.0 * s.warmth)
    sticky = p.honey * math.tanh(20.0 * v) / (1.0 + s.warmth) if p.filling == "honey" else 0.0
    return wall(-p.gap - x, p.stiffness) - wall(x - p.gap, p.stiffness) - sticky


ENVIRONMENT = Environment(
    key="honey_pot", title="Honey pot", summary="Sticky between two walls", force=force,
    parameters=(
        Parameter("stiffness", "Stiffness", "N/m", 300.0, 0.0, 2000.0),
        Parameter("gap", "Gap", "m", 0.008, 0.0, 0.04),
        Parameter("honey", "Honey", "N", 0.8, 0.0, 2.0),
        Choice("filling", "Filling", ("honey", "air")),
    ),
)
'''


def test_a_file_in_a_users_folder_renders_on_the_board_unchanged(twin, tmp_path):
    file = tmp_path / "honey_pot.py"
    file.write_text(OWN, encoding="utf-8")
    environment = reading.load(file)
    assert np.abs(hold_to_python(environment, environment.values(), twin, tmp_path)).max() > 0.5


@pytest.mark.slow
@pytest.mark.parametrize("text", [table_law.TEXT, clock_law.TEXT], ids=["tables", "clock"])
def test_the_tables_and_the_clock_of_a_law_are_rendered(text, twin, tmp_path):
    file = tmp_path / "own.py"
    file.write_text(text, encoding="utf-8")
    environment = reading.load(file)
    assert np.abs(hold_to_python(environment, environment.values(), twin, tmp_path)).max() > 0.45


@pytest.mark.slow
@pytest.mark.parametrize("seed", wide(range(2000, 2075), lambda seed: seed in SAMPLE))
def test_the_firmware_renders_a_random_law(seed, twin, tmp_path):
    law, values = random_laws.law(tmp_path, seed), random_laws.settings(seed)
    program = compile_unrounded(law, values, 1e-3, ARENA)
    rate = rate_of(program)
    if rate is None or program.size > ARENA:
        pytest.skip(f"The law takes {program.most} cycles and {program.size} bytes.")
    exact = compile_unrounded(law, values, 1.0 / rate, ARENA)
    program = Program(**{**vars(exact), "given": tuple(map(single, exact.given))})
    found = rendered(tmp_path, program, rate)
    assert found.refused or len(found.rows) >= SECONDS * rate
    found = hold(twin, program, found)
    assert apart(law, values, exact, rate, found) <= 0.0
