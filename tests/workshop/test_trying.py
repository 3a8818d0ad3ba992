"""A trial calls a law at least 10,000 times, and reports faults at limits of its parameters and positions."""

import math

import numpy as np
import pytest

from hapkit_studio.parameters import Choice, Parameter
from hapkit_studio.workshop import own, reading, trying
from tests.workshop.student import END, line_of, saved, text, write

RING = '{"ring": (0.0, 0.0, 0.0), "n": 0.0, "on": 0.0}'
GROW = "s.n += 1.0\nif s.n > 50.0:\n    return s.ring[s.n - 48.0]\nreturn 0.0"
LATE = "if x != s.on:\n    s.n += 1.0\ns.on = x\nreturn 1.0 / (s.n - 60.5) / (9.0 - s.n)"
# columns: law, its state, the faulty line, message
FAULTS = [
    ("return 1.0 / (x - x)", "", "x - x", "a division by zero at x = 0 mm, v = 0 m/s:"),
    ("return x / p.mass", "", "p.mass", "zero at x = 0 mm, v = 0 m/s, mass = 0 kg: test the divisor"),
    ("return x / (1.0 if p.side == 'right' else 0.0)", "", "return", "side = left:"),
    ("a = 1.0\nreturn a / (x - 0.06)", "", "return a", "at x = 60 mm"),
    ("a = 1.0\nreturn a / (v + 3.0)", "", "return a", "v = −3 m/s"),
    ("return math.sqrt(x)", "", "math.sqrt", "finite number at x = −"),
    ("return math.exp(1e6 * abs(x))", "", "math.exp", "the result is not a finite number at x = "),
    (GROW, RING, "s.ring[s.n", "the index is outside the state or table at x ="),
    ("return s.ring[p.stiffness]", RING, "return s", "the index is outside the state"),
    (LATE, RING, "return 1.0", "a division by zero at x ="),
    ("for i in range(2000000000):\n    a = i\nreturn x", "", "for i", "takes too long at x ="),
    ("for i in range(15000):\n    for j in range(3):\n        a = i\nreturn x", "", "for ", "fewer times"),
]  # fmt: skip


@pytest.mark.parametrize(("body", "state", "where", "message"), FAULTS)
def test_a_fault_at_corner_values_is_reported_with_its_line(tmp_path, body, state, where, message):
    whole = text(body, state)
    verdict = trying.try_out(saved(tmp_path, whole))
    assert not verdict.ok
    (problem,) = verdict.problems
    assert message in problem.text
    lines = whole.split("\n")
    assert where in lines[problem.line - 1]


def test_a_guarded_law_passes(tmp_path):
    guarded = "if p.mass < 0.01 or x == 0.0:\n    return 0.0\nreturn p.stiffness * v / p.mass + 1.0 / x"
    verdict = trying.try_out(saved(tmp_path, text(guarded + " if p.side == 'right' else 0.0")))
    assert verdict.problems == verdict.warnings == ()
    assert verdict.calls >= 10_000
    assert verdict.ns_per_call > 0.0


def test_a_slow_law_passes_after_fewer_calls(tmp_path, monkeypatch):
    """All calls of a law of 1.3 ms take 17 s, and a trial that exceeds its time-out rejects the file."""
    monkeypatch.setattr(trying, "CALLING_SECONDS", 0.0)
    body = "total = 0.0\nfor i in range(1000):\n    total += math.sin(total + i)\nreturn total"
    verdict = trying.try_out(saved(tmp_path, text(body)))
    assert verdict.problems == ()
    assert 0 < verdict.calls < 1000


# columns: further arguments of Environment, line of the error, message
FUNCTIONS = [
    ("impedance=lambda p: (1.0 / p['mass'], 0.0),", "a division by zero"),
    ("impedance=lambda p: (p['stifness'], 0.0),", "there is no key 'stifness'"),
    ("impedance=lambda p: None,", "return (stiffness, damping), not None"),
    ("impedance=lambda p: (1.0, math.nan),", "return (stiffness, damping), not (1.0, nan)"),
    ("check=lambda p: 'too soft',", "the defaults contradict each other: too soft"),
    ("warnings=lambda p, c: [1 / 0],", "a division by zero"),
    ("over_position=lambda p, x: x[:2],", "one value for each position"),
    ("over_velocity=lambda p, v: 'fast',", "return numbers, not 'fast'"),
]


@pytest.mark.parametrize(("given", "message"), FUNCTIONS)
def test_the_environments_other_functions_are_called_too(tmp_path, given, message):
    whole = text(end=END.replace("    force=force,", "    force=force,\n    " + given))
    (problem,) = trying.try_out(saved(tmp_path, whole)).problems
    assert message in problem.text
    assert problem.line == line_of(whole, given)


def test_calls_cover_all_limits_and_motions():
    parameters = (
        Parameter("a", "A", "N/m", 2.0, 1.0, 3.0),
        Parameter("b", "B", "m", 0.01, -0.02, 0.03),
        Choice("c", "C", ("left", "middle", "right")),
    )
    made = type("Made", (), {"parameters": parameters, "check": staticmethod(lambda values: "")})
    found = list(trying.sequences(made))
    assert sum(len(f.x) for f in found) >= 10_000
    assert found[0].values == {"a": 2.0, "b": 0.01, "c": 0.0}
    for key, wanted in (("a", {1.0, 2.0, 3.0}), ("b", {-0.02, 0.01, 0.03}), ("c", {0.0, 1.0, 2.0})):
        assert {f.values[key] for f in found} == wanted
    assert {f.dt for f in found if f.values["a"] == 1.0 and f.values["b"] == 0.01} == {1e-4, 1e-3, 1e-2}
    assert [f.dt for f in found[:3]] == [1e-3, 1e-4, 1e-2]
    x, v = np.concatenate([f.x for f in found]), np.concatenate([f.v for f in found])
    pairs = set(zip(x.tolist(), v.tolist(), strict=True))
    assert pairs >= {(px, pv) for px in (-0.06, 0.06, 0.03) for pv in (-3.0, 0.0, 3.0)}
    assert np.abs(x).max() <= 0.0602
    assert np.abs(v).max() == 3.0
    steps = found[0].x[found[0].v == 20.7e-6 / found[0].dt]
    assert np.isclose(np.diff(steps), 20.7e-6).sum() >= 7


FULL = "a = math.exp(1e6 * x)\nreturn p.stiffness * a"


def law_of(folder, *given):
    return reading.load(write(folder, text(*given))).force.compiled()


def run(law, x, fault, state=None):
    """Return (index of the failed call, forces) at positions x (n,) in m, at rest."""
    x, p, force = np.array(x), np.array([200.0, 0.1, 0.0, 0.0]), np.zeros(len(x))
    state = own.law_memory(law)[0] if state is None else state
    return own.call_law(law.address, p, state, x, 0.0 * x, 1e-3, fault, force), force


def test_calls_end_at_the_first_failure(tmp_path):
    law = law_of(tmp_path, FULL)
    fault = own.law_memory(law)[1]
    wrong, force = run(law, [0.0, -0.01, 0.01, 0.0], fault)
    assert wrong == 2
    assert force[:2].tolist() == [200.0, 0.0]
    assert fault[0] == 1


@pytest.mark.parametrize(
    "body", [FULL, "return 1.0 / (x - x)", "for i in range(2000000000):\n    pass\nreturn x"]
)
def test_a_law_does_not_write_beyond_its_memory(tmp_path, body):
    """The studio owns the memory of the state, and a user's law must not write beyond it."""
    law = law_of(tmp_path, body)
    fault = np.full(16, 77)
    fault[: own.FAULT_WORDS] = 0
    run(law, [0.01], fault)
    assert fault[0] != 0
    assert set(fault[own.FAULT_WORDS :]) == {77}
    state, words = own.law_memory(law)
    assert (len(state), len(words)) == (1, own.FAULT_WORDS)


def test_each_point_of_a_curve_starts_with_the_initial_state_and_faults_give_nan(tmp_path):
    body = "s.n += 1.0\nreturn s.n * x / (0.02 - x)"
    made = reading.load(write(tmp_path, text(body, '{"n": 1.0}')))
    curve = made.curve(made.values(), np.array([0.01, 0.01, 0.02, 0.01]))
    assert curve.tolist() == pytest.approx([2.0, 2.0, math.nan, 2.0], nan_ok=True, abs=0.0)
