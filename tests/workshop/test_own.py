"""Calls of a compiled law: in a row and one at a time they are the same, and write where they may."""

import numpy as np
import pytest

from hapkit_studio.workshop import own, reading
from tests.workshop.student import text, write

FULL = "a = math.exp(1e6 * x)\nreturn p.stiffness * a"


def law_of(folder, *given):
    return reading.load(write(folder, text(*given))).force.compiled()


def run(law, x, fault, state=None):
    """Return (the call that failed, forces) at positions x (n,) in m, at rest."""
    x, p, force = np.array(x), np.array([200.0, 0.1, 0.0, 0.0]), np.zeros(len(x))
    state = own.law_memory(law)[0] if state is None else state
    return own.call_law(law.address, p, state, x, 0.0 * x, 1e-3, fault, force), force


def test_calls_in_a_row_keep_the_state(tmp_path):
    law = law_of(tmp_path, "s.n += 1.0\nreturn s.n + x", '{"n": 0.5}')
    state, fault = own.law_memory(law)
    wrong, force = run(law, [0.0, 0.1, 0.2], fault, state)
    assert (wrong, force.tolist(), state[0]) == (own.NO_FAULT, [1.5, 2.6, 3.7], 3.5)


def test_the_first_call_that_fails_is_the_last(tmp_path):
    law = law_of(tmp_path, FULL)
    fault = own.law_memory(law)[1]
    wrong, force = run(law, [0.0, -0.01, 0.01, 0.0], fault)
    assert wrong == 2
    assert force[:2].tolist() == [200.0, 0.0]
    assert fault[0] == 1


@pytest.mark.parametrize(
    "body", [FULL, "return 1.0 / (x - x)", "for i in range(2000000000):\n    pass\nreturn x"]
)
def test_a_law_writes_into_no_more_words_than_it_has(tmp_path, body):
    """The words come from here, the law from elsewhere: it must not write beyond them."""
    law = law_of(tmp_path, body)
    fault = np.full(16, 77)
    fault[: own.FAULT_WORDS] = 0
    run(law, [0.01], fault)
    assert fault[0] != 0
    assert set(fault[own.FAULT_WORDS :]) == {77}
    state, words = own.law_memory(law)
    assert (len(state), len(words)) == (1, own.FAULT_WORDS)


def test_one_call_begins_at_the_start_and_is_nan_where_it_faults(tmp_path):
    force = own.law_function(law_of(tmp_path, "s.n += 1.0\nreturn s.n * x / (0.02 - x)", '{"n": 1.0}'))
    p = np.zeros(4)
    assert [force(p, x, 0.0) for x in (0.01, 0.01)] == [2.0, 2.0]
    assert np.isnan(force(p, 0.02, 0.0))
    assert force(p, 0.01, 0.0) == 2.0
