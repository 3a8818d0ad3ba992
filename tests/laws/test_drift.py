"""Drift of clocks: sums of dt are detected in any form, and the recommended form is exact for an hour."""

import math

import numpy as np
import pytest

from hapkit_studio.laws import board, reference
from hapkit_studio.parameters import Parameter
from hapkit_studio.workshop import folder, reading, sketch
from hapkit_studio.workshop.own import built_in
from hapkit_studio.workshop.source import typed
from tests.laws.law_files import HEAD, PARAMETERS, environment, law_text, line_of, module
from tests.laws.machine_pc import needs_compiler

STATE = "{'t': 0.0, 'n': 0, 'last': 0.0, 'ring': (0.0, 0.0)}"
BESIDE = """
def later(t, dt):
    return t + dt

def both(t, dt):
    return t + dt, -t

def counted_down(t, dt):
    if t > 0.0:
        return max(0.0, t - dt)
    return 0.0
"""
# columns: the body of a law, the beginning of the reported line
DRIFTING = [
    ("s.t += dt", "s.t"),
    ("s.t = s.t + dt", "s.t"),
    ("s.t = dt + s.t", "s.t"),
    ("s.t -= dt", "s.t"),
    ("s.t -= -dt", "s.t"),
    ("s.t += 2 * dt / 3", "s.t"),
    ("s.t += p.stiffness * dt", "s.t"),
    ("s.t += 0.001", "s.t"),
    ("now = s.t + dt\na = now * 2\ns.t = now", "s.t"),
    ("s.t = later(s.t, dt)", "s.t"),
    ("s.t, a = both(s.t, dt)", "s.t, a"),
    ("a, s.t = x, s.t + dt", "a, s.t"),
    ("s.t = s.t + (dt if x > 0.0 else 0.0)", "s.t"),
    ("s.t = s.t + dt if x > 0.0 else 0.0", "s.t"),
    ("for i in range(4):\n    s.t += dt / 4", "    s.t"),
    ("s.ring[0] += dt", "s.ring"),
    ("s.ring[s.n] += dt", "s.ring"),
    ("if x > 0.01:\n    s.t += dt\nelse:\n    s.t = 0.0", "    s.t += dt"),
    ("if s.t > 1.0:\n    s.t = 0.0\ns.t += dt", "s.t += dt"),
    ("if s.t < 0.0:\n    return 0.0\ns.t += dt", "s.t += dt"),
    ("if s.n < 10:\n    s.t += dt", "    s.t"),
    ("s.t = max(s.t, 0.0) + dt", "s.t"),
    ("s.last = x > 0.0\ns.t += s.last * dt", "s.t"),
    ("s.t = (s.t + dt) % 1.0", "s.t"),
    ("s.t = math.fmod(s.t + math.tau * p.stiffness * dt, math.tau)", "s.t"),
    ("s.t += dt\nif s.t > 1.0:\n    s.t -= 1.0", "s.t += dt"),
    ("if s.t >= 1.0:\n    s.t -= 1.0\nelse:\n    s.t += dt", "    s.t += dt"),
    ("s.n += 1\na = math.sin(0.1 * s.n)", "a = "),
    ("s.n += 1\na = s.n * dt\nb = math.cos(2.0 * a)", "b = "),
    ("s.n += 1\nif x > 0.0:\n    s.last = s.n * dt", "    s.last"),
]
STEADY = [
    "s.n += 1",
    "s.n = (s.n + 1) % 100\na = math.sin(math.tau * s.n / 100)",
    "s.n += 1\ns.last = s.n if x > 0.0 else s.last\na = math.sin((s.n - s.last) * dt)",
    "s.t = min(s.t + dt, 1.0)",
    "s.t = max(0.0, s.t - dt)",
    "s.t = counted_down(s.t, dt)",
    "if s.t < 1.0:\n    s.t += dt",
    "if s.t > 1.0:\n    return 0.0\ns.t += dt",
    "if not (s.t >= 1.0 or x > 0.0):\n    s.t += dt",
    "s.t = s.t + dt if s.t < 1.0 else 1.0",
    "if x > 0.0 and s.t > 0.0:\n    s.t -= dt",
    "s.t += dt * (x - s.t)",
    "s.t *= 1.0 - dt",
    "s.last -= 300.0 * s.t * dt\ns.t += s.last * dt",
    "s.t += v * dt",
    "if x > 0.01 and not s.last:\n    s.t += 0.25\ns.last = x > 0.01",
    "s.t = 2 * dt",
    "s.t = s.t - s.t + dt",
]


def remarks(folder, body, state=STATE):
    text = law_text(f"{body}\nreturn 0.0", state, BESIDE)
    return environment(folder, text).force.remarks, text


@pytest.mark.parametrize(("body", "message"), DRIFTING, ids=[body for body, _ in DRIFTING])
def test_drifting_states_are_reported_at_their_line(tmp_path, body, message):
    (found,), text = remarks(tmp_path, body)
    lines = (HEAD + text).splitlines()
    assert lines[found.line - 1].startswith(f"    {message}")
    assert "on the board and in a sketch" in found.text
    assert str(found) == f"Line {found.line}: {found.text}."


@pytest.mark.parametrize("body", STEADY)
def test_states_that_forget_rounding_errors_are_not_reported(tmp_path, body):
    assert remarks(tmp_path, body)[0] == ()


def test_only_free_vibrations_of_the_studios_laws_are_reported(tmp_path):
    found = {key: {r.text.split("`")[1] for r in e.force.remarks} for key, e in built_in().items()}
    assert {key: names for key, names in found.items() if names} == {"cat": {"s.breath", "s.phase"}}
    for template in folder.templates():
        assert reading.load_source(typed(tmp_path / "own.py", template.text)).force.remarks == ()


def test_a_sketch_has_the_remark_above_the_line(tmp_path):
    text = law_text("s.t += dt\nreturn -p.stiffness * s.t", STATE)
    made = environment(tmp_path, text)
    lines = [line.strip() for line in sketch.text(made, made.values()).splitlines()]
    at = lines.index("s.t += kPeriod;")
    comment = " ".join(line.removeprefix("// ") for line in lines[at - 3 : at])
    assert comment.endswith(f"{made.force.remarks[0].text}.")


# --- the board's machine computes in single precision
RATE = 4000
HOUR = 3600 * RATE


@needs_compiler
def test_a_sum_of_dt_drifts_as_far_as_the_message_says(machine, tmp_path):
    made = environment(tmp_path, law_text("s.t += dt\nreturn 0.0", STATE))
    program = board.compile(made.force, made.values(), 1.0 / RATE)
    machine.load(program.states, program.given, program.slots, program.code)
    _, states = machine.run(np.zeros((10 * RATE, 2)))
    assert abs(states[-1, 0] - 10.0) == pytest.approx(3e-3, abs=1e-3)
    machine.set(2, 590.0)
    _, states = machine.run(np.zeros((10 * RATE, 2)))
    assert abs(states[-1, 0] - 600.0) > 0.05  # error in s that arises within 10 s, from 590 s to 600 s


def clocked(folder):
    """Return the reference page's law that counts calls to time 100 ms after a touch at 15 mm."""
    made = module(folder, reference.CLOCK)
    made.force.bind(PARAMETERS)
    return made.force


def touches(start, count):
    """Return rows (count, 2) of position and velocity from a call number on, and their forces (count,) in N.

    The handle is in contact in every other 1000 rows.
    """
    call = start + 1 + np.arange(count)
    since = (call % 2000) / RATE
    inside = call % 2000 < 1000
    force = np.where(inside & (call % 2000 < 400), 0.5 * np.sin(2 * math.pi * 40 * since), 0.0)
    return np.stack([np.where(inside, 0.016, 0.0), np.zeros(count)], axis=1), force


@needs_compiler
@pytest.mark.parametrize("start", [0, 10 * RATE, 600 * RATE, HOUR - RATE])
def test_a_count_of_calls_is_exact_for_an_hour(machine, tmp_path, start):
    program = board.compile(clocked(tmp_path), {p.key: p.default for p in PARAMETERS}, 1.0 / RATE)
    machine.load(program.states, program.given, program.slots, program.code)
    machine.set(2, start)
    rows, wanted = touches(start, RATE)
    forces, states = machine.run(rows)
    assert np.abs(forces - wanted)[1000:].max() < 2e-3
    assert np.abs(wanted).max() > 0.49
    assert states[-1, 0] == start + RATE


@pytest.mark.slow
@needs_compiler
def test_a_count_of_calls_is_exact_at_each_call_of_an_hour(machine, tmp_path):
    program = board.compile(clocked(tmp_path), {p.key: p.default for p in PARAMETERS}, 1.0 / RATE)
    machine.load(program.states, program.given, program.slots, program.code)
    for start in range(0, HOUR, RATE):
        rows, wanted = touches(start, RATE)
        assert np.abs(machine.run(rows)[0] - wanted)[0 if start else 1000 :].max() < 2e-3


@needs_compiler
@pytest.mark.parametrize("frequency", [40.0, 37.3, 170.0])
def test_a_vibration_of_whole_calls_repeats_exactly(machine, tmp_path, frequency):
    law = module(tmp_path, reference.VIBRATION).force
    law.bind((Parameter("frequency", "Frequency", "Hz", 40.0, 1.0, 400.0),))
    program = board.compile(law, {"frequency": frequency}, 1.0 / RATE)
    machine.load(program.states, program.given, program.slots, program.code)
    calls = round(RATE / frequency)
    forces, _ = machine.run(np.zeros((20 * calls, 2)))
    wanted = 0.3 * np.sin(math.tau * np.arange(1, calls + 1) / calls)
    assert np.abs(forces[:calls] - wanted).max() < 2e-3
    assert np.array_equal(forces.reshape(20, calls), np.tile(forces[:calls], (20, 1)))


def test_the_line_of_the_advice_is_the_laws_line(tmp_path):
    (found,), text = remarks(tmp_path, "a = 1.0\ns.t = later(s.t, dt)")
    assert found.line == line_of(text, "s.t = later")
