"""A file's functions run in a separate process, so they cannot block the studio."""

import json
import math
import time

import numpy as np
import pytest

import hapkit_studio as hs
from hapkit_studio.environments.base import Conditions
from hapkit_studio.workshop import isolated, reading, trial
from tests.waiting import PATIENCE
from tests.wide import wide
from tests.workshop.student import END, line_of, saved, text

GOOD = """
def check(p):
    return "" if p["mass"] else "no mass"


def warnings(p, c):
    yield f"{p['stiffness']:g} N/m every {c.period:g} s, {c.delay:g} s late by {c.estimator[0]}"


GIVEN = {
    "check": check,
    "warnings": warnings,
    "unused": lambda p: {"mass": "it has none"},
    "impedance": lambda p: (p["stiffness"], 0),
    "over_position": lambda p, x: -p["stiffness"] * x,
    "over_velocity": lambda p, v: [v, 2.0 * v],
}
"""
VALUES = {"stiffness": 5.0, "mass": 1.0, "side": 0.0}
OFF = (
    "`check` of mine.py took more than 1 s or too much memory: its functions except the law are switched off."
)


def made(folder, beside=GOOD):
    """Return the environment of a file whose dictionary ``GIVEN`` has further arguments of Environment."""
    return reading.load_source(saved(folder, with_functions(beside)))


def with_functions(beside):
    return text(beside=beside, end=END.replace("    force=force,", "    force=force,\n    **GIVEN,"))


def with_check(statement):
    """Return a check that runs a statement only for a value from 123 to 124, which is no corner value."""
    return f"""
import os


def check(p):
    if 123 < p['stiffness'] < 124:
        {statement}
    return ''


GIVEN = {{'check': check}}
"""


def test_arguments_and_results_are_the_same_in_the_process(tmp_path):
    own = made(tmp_path)
    assert own.check(VALUES) == ""
    assert own.check({**VALUES, "mass": 0.0}) == "no mass"
    conditions = Conditions(rate=1e4, delay=2e-3, max_force=math.inf, estimator=("iir", {"cutoff": 9.0}))
    assert own.warnings(VALUES, conditions) == ("5 N/m every 0.0001 s, 0.002 s late by iir",)
    assert own.unused(VALUES) == {"mass": "it has none"}
    assert own.impedance(VALUES) == (5.0, 0.0)
    assert own.over_position(VALUES, np.array([1.0, np.nan])) == pytest.approx([-5.0, np.nan], nan_ok=True)
    assert own.over_velocity(VALUES, np.array([1.0, 2.0])).tolist() == [[1.0, 2.0], [2.0, 4.0]]


TAKES_TOO_MUCH = {
    "a loop": "for i in range(10**12): pass",
    "one call": "sum(range(10**12))",
    "leaves": "os._exit(0)",
    "crashes": "os.abort()",
    "talks": "return 'x' * 5_000_000",
    "memory": "(1,) * 500_000_000",
}


@pytest.mark.slow
@pytest.mark.parametrize("how", wide(TAKES_TOO_MUCH, lambda how: how in ("a loop", "crashes", "memory")))
def test_excessive_functions_are_disabled_with_a_one_line_message(tmp_path, how):
    own = made(tmp_path, with_check(TAKES_TOO_MUCH[how]))
    assert own.check(VALUES) == ""
    begin = time.monotonic()
    run = hs.simulate(own, {"stiffness": 123.5}, hand="press", seconds=0.3)
    assert time.monotonic() - begin < PATIENCE  # without a time limit the run would take hours
    assert run.warnings == (OFF,)
    assert np.allclose(run.force, -123.5 * run.position)
    assert own.check({**VALUES, "stiffness": 123.5}) == ""
    assert own.warnings(VALUES, Conditions()) == (OFF,)


def test_printed_output_does_not_disturb_replies(tmp_path):
    own = made(tmp_path, with_check("os.write(1, b'{}'); print('a'); return 'odd'"))
    assert own.check({**VALUES, "stiffness": 123.5}) == "odd"


@pytest.mark.slow
@pytest.mark.parametrize("stiffness", [5.0, 123.5], ids=["idle", "in a loop"])
def test_the_process_ends_with_its_parent(tmp_path, stiffness):
    tried = saved(tmp_path, with_functions(with_check("while True: pass")))
    process = isolated.begin("hapkit_studio.workshop.function_process", str(tried.path))
    requests = [tried.text, ["check", {**VALUES, "stiffness": stiffness}]]
    process.communicate("".join(json.dumps(w) + "\n" for w in requests).encode(), timeout=PATIENCE)
    assert process.returncode is not None


@pytest.mark.slow
@pytest.mark.parametrize(
    ("statement", "message"),
    [
        ("while True: pass", "`check` does not end"),
        ("os._exit(0)", "`check` ended Python: remove calls such as exit()"),
        ("os.abort()", "`check` crashed Python"),
    ],
)
def test_a_trial_names_the_function_at_its_line(tmp_path, statement, message):
    tried = saved(tmp_path, with_functions(with_check(statement).replace("123 <", "0 <=")))
    (problem,) = trial.check(tried, timeout=40.0).problems
    assert (problem.text, problem.line) == (message, line_of(tried.text, "def check"))
