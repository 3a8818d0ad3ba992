"""Settings with the same code differ in constants only, which ramp while the law runs on the board."""

import itertools

import numpy as np
import pytest

from hapkit_studio.laws import board
from hapkit_studio.laws.board import Program
from hapkit_studio.laws.machine import FIRST, MOST_CYCLES, Refusal
from hapkit_studio.laws.specialise import Specialiser
from hapkit_studio.workshop.own import built_in
from tests.laws.machine_pc import Machine, needs_compiler
from tests.laws.test_board_environments import PERIOD, TOO_SLOW, motion, options, settings
from tests.wide import wide

ENVIRONMENTS = built_in()
STEPS = 30  # a ramp has 30 steps of 1 ms


@pytest.fixture
def outcomes(monkeypatch):
    """Return the list of outcomes of comparisons that use parameters only, in order of evaluation."""
    found: list[bool] = []
    asked = Specialiser.compare

    def compare(self, op, left, right):
        outcome = asked(self, op, left, right)
        if isinstance(outcome, bool):
            found.append(outcome)
        return outcome

    monkeypatch.setattr(Specialiser, "compare", compare)
    return found


def programs(environment, chosen, rng, count, outcomes) -> list[tuple[tuple[bool, ...], Program]]:
    """Return the programs of random settings with these choices, each with its outcomes."""
    made = []
    for values in settings(environment, chosen, rng, count):
        outcomes.clear()
        program = board.compile(environment.force, values, PERIOD)
        made.append((tuple(outcomes), program))
    return made


@pytest.mark.parametrize("key", wide(ENVIRONMENTS, lambda key: key in ("wall", "friction")))
def test_the_code_depends_only_on_conditions_of_parameters(key, rng, outcomes):
    environment = ENVIRONMENTS[key]
    for chosen in options(environment):
        codes: dict[tuple[bool, ...], tuple[bytes, int]] = {}
        few = 3 if (key, chosen.get("integrator")) in TOO_SLOW or key == "puck" else 8
        for decided, program in programs(environment, chosen, rng, few, outcomes):
            shape = (program.code, len(program.given))
            assert codes.setdefault(decided, shape) == shape, chosen


@needs_compiler
@pytest.mark.parametrize("key", wide(ENVIRONMENTS, lambda key: key in ("wall", "friction")))
def test_forces_are_finite_during_ramps_and_correct_after_them(key, machine, rng, outcomes):
    environment, rows = ENVIRONMENTS[key], motion(120).astype(np.float32)
    moved = 0
    for chosen in options(environment):
        found = [p for _, p in programs(environment, chosen, rng, 4, outcomes)]
        for one, other in itertools.pairwise(found):
            if one.code != other.code or one.given == other.given or one.most > MOST_CYCLES:
                continue
            hold(machine, one, other, rows)
            moved += 1
    assert moved or key == "free"


def hold(machine: Machine, one: Program, other: Program, rows: np.ndarray) -> None:
    """Ramp from one program's constants to another's; fail on a non-finite force or a wrong final force."""
    assert machine.load(one.states, one.given, one.slots, one.code).refusal == Refusal.NONE
    forces, states = machine.run(rows[:60])
    start, aim = (np.array(p.given[p.states :], np.float32) for p in (one, other))
    for step in range(1, STEPS + 1):
        between = start + (aim - start) * np.float32(step / STEPS) if step < STEPS else aim
        for i, value in enumerate(between.tolist()):
            machine.set(FIRST + one.states + i, value)
        row = 60 + step - 1
        forces, states = machine.run(rows[row : row + 1])
        assert np.isfinite(forces).all(), (step, one.given, other.given)
    moved, _ = machine.run(rows[60 + STEPS :])
    assert machine.load(other.states, other.given, other.slots, other.code).refusal == Refusal.NONE
    for i, value in enumerate(states[-1].tolist()):
        machine.set(FIRST + i, value)
    fresh, _ = machine.run(rows[60 + STEPS :])
    assert moved.tobytes() == fresh.tobytes()
