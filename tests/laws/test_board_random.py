"""With random laws of the whole language, the board's machine agrees with double precision."""

from dataclasses import dataclass, field

import pytest

from hapkit_studio.errors import LawError
from hapkit_studio.laws.machine import MOST_CYCLES, Refusal
from tests.laws import random_laws
from tests.laws.error_analysis import compile_unrounded, single
from tests.laws.machine_pc import Machine, build, needs_compiler
from tests.laws.twins import Compiled, Plain, compare

pytestmark = needs_compiler

PERIOD = 1e-3
ROOMS = (0, 10_000)
"""Room in bytes with which functions are called, and with which they are inlined."""


@dataclass
class Seen:
    """Statistics of many laws: the compared ones, reasons for skipping others, and numbers of rows."""

    laws: int = 0
    refused: list[str] = field(default_factory=list)
    rows: int = 0
    compared: int = 0
    faults: int = 0


def useful(force: float) -> float:
    """Return the largest error bound in N with which a comparison is meaningful."""
    return 1e-3 * (1.0 + abs(force))


@pytest.fixture(scope="module")
def watched():
    with Machine(build(watched=True)) as made:
        yield made


def run(machine: Machine, folder, seeds, truth) -> Seen:
    """Compare the laws of these seeds, each with random settings; return statistics."""
    seen = Seen()
    for seed in seeds:
        law, values = random_laws.law(folder, seed), random_laws.settings(seed)
        try:
            program = compile_unrounded(law, values, PERIOD, ROOMS[seed % len(ROOMS)])
        except LawError as error:
            seen.refused.append(str(error))
            continue
        if program.most > MOST_CYCLES:
            loaded = machine.load(
                program.states, [single(g) for g in program.given], program.slots, program.code
            )
            assert loaded.refusal == Refusal.TOO_SLOW, seed
            seen.refused.append("too slow")
            continue
        try:
            found = compare(machine, program, truth(law, values, PERIOD), random_laws.rows(seed), useful)
        except AssertionError as error:
            raise AssertionError(f"law {seed}: {error}\n{random_laws.text(seed)}\n{values}") from error
        seen.laws += 1
        seen.rows += found.rows
        seen.compared += found.compared
        seen.faults += found.faults
    return seen


def hold(seen: Seen, count: int) -> None:
    """Assert that few laws were skipped, and that enough cases were covered."""
    assert seen.laws >= 0.85 * count, seen.refused
    assert seen.compared >= 0.75 * seen.rows
    assert 0.02 * seen.rows < seen.faults < 0.3 * seen.rows


@pytest.mark.slow
def test_random_laws_agree_with_double_precision(machine, tmp_path):
    hold(run(machine, tmp_path, range(1120, 1140), Plain), 20)


@pytest.mark.slow
def test_very_many_random_laws_agree_with_double_precision(watched, tmp_path):
    """The machine runs with sanitizers."""
    hold(run(watched, tmp_path, range(600), Plain), 600)


@pytest.mark.slow
@pytest.mark.parametrize("first", range(0, 80, 20))
def test_random_laws_agree_with_the_compiled_ones(machine, tmp_path, first):
    seen = run(machine, tmp_path, range(first, first + 20), Compiled)
    assert seen.laws >= 14, seen.refused
    assert seen.compared >= 0.7 * seen.rows
