"""Regression tests of small laws that were once compiled wrongly for the board's machine."""

import numpy as np
import pytest

from tests.laws import random_laws
from tests.laws.error_analysis import compile_unrounded
from tests.laws.law_files import law_text, module
from tests.laws.machine_pc import needs_compiler
from tests.laws.twins import Plain, compare

pytestmark = needs_compiler

HELPERS = """
def inner(a, b):
    for i in range(2):
        a = 0.5 * a + b
        b = 0.3 * b - a
    return a + b


def outer(a, b):
    c = inner(a, b)
    return c - inner(b, a)


def changing(a, b):
    kept = a
    for i in range(2):
        kept = 0.7 * kept + b
    b += kept
    return kept * b


def few(a):
    for i in range(2):
        a = 0.5 * a + math.cos(a)
    return a


def many(a, b, c):
    for i in range(2):
        a = 0.5 * a + b * c - math.cos(a)
    return a - c
"""
CASES = {
    "a result among what another function takes": """
        f = few(x)
        g = many(v, x, few(v))
        return f + g + many(x, v, few(x + v))
    """,
    "a result read behind another call": """
        f = few(s.sum)
        g = many(v, x, 0.5) + many(x, v, 0.25)
        s.sum = max(0, f)
        return g + few(x)
    """,
    "a number that a loop does not change after all": """
        g = 0.643
        for i in range(5, 0, -2):
            if 1.0:
                pass
            else:
                g = 1.0
        return g * p.c
    """,
    "a value across a call that calls the same function": """
        first = inner(x, v)
        second = outer(v, x)
        return first + second + outer(x, 0.3) + inner(first, second)
    """,
    "a function given the same again": """
        return changing(x, v) + changing(x, v) + changing(x, 0.5)
    """,
    "a loop without a turn beside another way": """
        if s.sum:
            for i in range(3):
                pass
        else:
            s.count = x - 1.0
        return p.b
    """,
    "a count as an index that is written to": """
        for i in range(0, 3):
            s.table[i] = x + i
        return s.table[0] - s.table[2]
    """,
    "a loop that ends in its first turn": """
        for i in range(1, 4):
            break
        return v
    """,
    "a loop that returns in its first turn, before another": """
        f = 1.0
        for i in range(5, 0, -2):
            return v
        for i in range(4):
            f += x
        return f
    """,
    "a return from a loop": """
        for i in range(5, 0, -2):
            if s.sum * i > x:
                return x + v
            s.sum = 0.5 * s.sum + x
        return p.c
    """,
    "what takes longest just before a loop is left": """
        for i in range(4):
            if x > 0.1 * i:
                s.sum = math.tan(s.sum) + math.tan(v)
                break
            s.last = s.last + x
        return s.sum
    """,
    "a division that nobody reads": """
        g = 3.0 / s.last
        s.last = v
        return 0.25
    """,
    "an index outside that nobody reads": """
        if s.table[s.count]:
            pass
        s.count = (s.count + 1.0) % 5
        return 1.0
    """,
    "a fault in a test that another one decides": """
        if s.pair[2.0 * x] > 0.0 or p.mode != "off" or p.mode == "off":
            return v
        return 0.0
    """,
    "a value read before its table is written": """
        g = s.pair[0.25]
        s.pair[abs(v)] = p.c
        return g
    """,
    "an index in an expression": """
        h = max(0.0, v)
        g = s.pair[h] + h
        return s.pair[abs(x)] - g
    """,
    "a state known before a loop that changes it": """
        s.last = 2.0
        for i in range(3):
            s.last = s.last + x
        return s.last
    """,
    "a state known in a loop's last turn only": """
        s.last = v
        for i in range(3):
            if x > 0.1 * i:
                break
            s.last = 4.0
        return s.last
    """,
    "numbers in place of tests": """
        f = x > 0.0
        g = (x and v) + (v or 2.0)
        return f + g - (not f)
    """,
}


@pytest.mark.parametrize("room", [0, 10_000])
@pytest.mark.parametrize("case", CASES)
def test_formerly_miscompiled_laws_give_the_right_force(case, room, machine, tmp_path):
    law = module(tmp_path, law_text(CASES[case], random_laws.STATE, HELPERS)).force
    law.bind(random_laws.PARAMETERS)
    values = {p.key: p.default for p in random_laws.PARAMETERS}
    program = compile_unrounded(law, values, 1e-3, room)
    found = compare(machine, program, Plain(law, values, 1e-3), random_laws.rows(1), lambda force: 1e-3)
    assert found.compared >= 0.8 * found.rows


@pytest.mark.parametrize("divisor", [41.0, 47.0, 109.0])
def test_integer_quotients_are_exact(divisor, machine, tmp_path):
    """In single precision, the product of such a divisor and its inverse is below 1."""
    body = f"both = x + v\nreturn math.floor(both / {divisor})"
    law = module(tmp_path, law_text(body, random_laws.STATE, HELPERS)).force
    law.bind(random_laws.PARAMETERS)
    program = compile_unrounded(law, {p.key: p.default for p in random_laws.PARAMETERS}, 1e-3, 0)
    machine.load(program.states, [np.float32(n) for n in program.given], program.slots, program.code)
    forces, _ = machine.run(np.array([[divisor - 1.0, 1.0]], np.float32))
    assert forces == [1.0]
