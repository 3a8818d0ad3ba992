"""With every combination of an environment's choices, the board's machine agrees with the compiled law."""

import itertools

import numpy as np
import pytest

from hapkit_studio.errors import ParameterError
from hapkit_studio.laws import board
from hapkit_studio.laws.machine import ARENA, MOST_CYCLES, Refusal
from hapkit_studio.parameters import Choice
from hapkit_studio.workshop.own import built_in
from tests.laws.error_analysis import compile_unrounded
from tests.laws.machine_pc import Machine, build, needs_compiler
from tests.laws.twins import Compiled, compare
from tests.wide import wide

ENVIRONMENTS = built_in()
pytestmark = needs_compiler

PERIOD = 1e-3
BOUND = 2e-3  # largest permitted difference in N
SHORT, LONG = 0, 10_000
"""Room in bytes: none for inlining, or enough for inlining every function."""
TOO_SLOW = {("mass_spring_damper", "exact"), ("puck", "exact")}
"""Environments and options whose call may exceed the board's cycle counter."""
TOO_LARGE = {("puck", "implicit_euler"), ("puck", "trapezoid"), *TOO_SLOW}
"""Environments and options that do not fit the board's arena."""

LENGTHY = ("mass_spring_damper", "puck")
"""Environments whose laws take long to compile."""
KEYS = wide(ENVIRONMENTS, lambda key: key not in LENGTHY)


@pytest.fixture(
    scope="module",
    params=[pytest.param(False, id="plain"), pytest.param(True, id="watched", marks=pytest.mark.slow)],
)
def machine(request):
    """Return the board's machine on this computer; slow tests have sanitizers and more settings."""
    with Machine(build(watched=request.param)) as made:
        made.settings = 3 if request.param else 1
        yield made


def motion(count=200):
    """Return rows (n, 2) of position and velocity of a motion with pauses, in the board's precision."""
    t = np.arange(count) * PERIOD
    x = 0.03 * np.sin(2 * np.pi * 1.9 * t) + 0.008 * np.sin(2 * np.pi * 7.3 * t + 1.0)
    x[count // 2 : count // 2 + 20] = x[count // 2]
    x = np.floor(x / 20.7e-6) * 20.7e-6
    v = np.diff(x, prepend=x[0]) / PERIOD
    for k in range(1, count):
        v[k] = v[k - 1] + 0.2 * (v[k] - v[k - 1])
    return np.stack([x, v], axis=1)


def options(environment):
    """Yield every combination of an environment's choices, as {key: option}."""
    choices = [p for p in environment.parameters if isinstance(p, Choice)]
    for combination in itertools.product(*(p.options for p in choices)):
        yield dict(zip((p.key for p in choices), combination, strict=True))


def usual(environment):
    """Return the default choices of an environment, as {key: option}."""
    return {p.key: p.options[int(p.default)] for p in environment.parameters if isinstance(p, Choice)}


def settings(environment, chosen, rng, count):
    """Yield the default settings with these choices, then random settings within the limits."""
    yield environment.values(chosen)
    while count:
        numbers = {
            p.key: float(rng.uniform(p.low, p.high))
            for p in environment.parameters
            if not isinstance(p, Choice)
        }
        try:
            yield environment.values(chosen | numbers)
        except ParameterError:
            continue
        count -= 1


def drawn(environment, chosen, rng, count):
    """Return random settings with these choices.

    The settings do not depend on which tests are selected.
    """
    for other in options(environment):
        found = list(settings(environment, other, rng, count))
        if other == chosen:
            return found
    raise ValueError(chosen)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("key", "chosen"),
    wide(
        ((key, chosen) for key, environment in ENVIRONMENTS.items() for chosen in options(environment)),
        lambda key, chosen: key not in LENGTHY or chosen == usual(ENVIRONMENTS[key]),
    ),
)
def test_machine_and_compiled_law_agree(key, chosen, machine, rng):
    environment, rows = ENVIRONMENTS[key], motion()
    total = compared = 0
    for values in drawn(environment, chosen, rng, machine.settings):
        for room in (SHORT, LONG):
            program = compile_unrounded(environment.force, values, PERIOD, room)
            if any((key, option) in TOO_SLOW for option in chosen.values()):
                loaded = machine.load(program.states, program.given, program.slots, program.code)
                assert loaded.refusal == Refusal.TOO_SLOW
                assert program.most > MOST_CYCLES
                continue
            law = Compiled(environment.force, values, PERIOD)
            try:
                found = compare(machine, program, law, rows, lambda force: BOUND)
            except AssertionError as error:
                raise AssertionError(f"{chosen}, {values}, {room} bytes of room: {error}") from error
            assert found.worst <= BOUND
            assert not found.faults
            total += found.rows
            compared += found.compared
    assert compared >= 0.99 * total


@pytest.mark.parametrize("key", ENVIRONMENTS)
def test_errors_do_not_accumulate_over_a_whole_motion(key, machine):
    """The law runs without restarts, and its single-precision errors do not accumulate."""
    environment, rows = ENVIRONMENTS[key], motion(1500).astype(np.float32)
    values = environment.values()
    program = board.compile(environment.force, values, PERIOD, SHORT)
    machine.load(program.states, program.given, program.slots, program.code)
    forces, _ = machine.run(rows)
    law = Compiled(environment.force, values, PERIOD)
    wanted = np.array([law.call(x, v) for x, v in rows.astype(float).tolist()])
    assert (np.abs(forces - wanted) <= BOUND).mean() >= 0.999


@pytest.mark.parametrize("key", KEYS)
def test_laws_too_large_for_the_board_are_reported(key):
    environment, found = ENVIRONMENTS[key], set()
    for chosen in options(environment):
        program = board.compile(environment.force, environment.values(chosen), PERIOD, ARENA)
        if program.size > ARENA:
            found.add((key, *chosen.values()))
    assert found == {(large, *rest) for large, *rest in TOO_LARGE if large == key}
