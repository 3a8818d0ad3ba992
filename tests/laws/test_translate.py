"""Compiled laws give the results of the plain Python function, and numba caches them."""

import gc
import math
import os
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hapkit_studio.environments import discover
from hapkit_studio.laws import native, translate
from hapkit_studio.laws.law import Law
from tests.laws.law_files import environment, held, law_text
from tests.wide import wide

HELPERS = """
import numpy

GAIN = 2.5
WHOLE = 3

def half(a):
    return 0.5 * a

def deep(a, b):
    rest = half(a)
    for i in range(5):
        if rest > b:
            break
        rest = rest + half(half(b)) + i
    return rest

def law_of(p, s, index):
    return p * s - index

def turned(x, v):
    # a helper may call its arguments as it likes, and give several numbers
    x, v = v, -x
    for _ in range(3):
        x = x + 0.5 * v
    return x, v > 0

def option(side, a):
    return a if side == 0 else -a

from math import hypot
"""
# each body uses a different part of the language
BODIES = [
    "return -p.stiffness * x - p.damping * v",
    """
    d = x - 0.005
    if d <= 0.0:
        return 0.0
    elif v > 0:
        return -p.stiffness * d - v
    return -p.stiffness * d
    """,
    "return 1.0 if p.side == 'right' and x > v or not v > 0.1 else -1.0 if 'left' != p.side else 2",
    "return min(x, v, dt) + max(x, 3) * abs(v) + float(x > 0) - int(1000 * x) + (x < v < 1)",
    "return GAIN * x ** 2 + WHOLE ** x + x % 0.013 + v // 0.017 - -x + (+v)",
    "return (7 * x) % -0.3 + (-7 * v) // 0.3 + (x * 1e3) // 1 % 2",
    "return math.sin(x) + math.cos(v) * math.tan(x)"
    " + math.atan2(x, v) + math.hypot(x, v) + math.pi - math.tau * math.e",
    "return math.exp(x) + math.expm1(v) + math.log(2"
    " + abs(x)) + math.log1p(abs(v)) + math.sqrt(abs(x)) + math.fabs(v)",
    "return math.asin(x / 9) + math.acos(v / 9) + math.atan(x) + math.sinh(x) + math.cosh(v) + math.tanh(x)",
    "return math.floor(100 * x) + math.ceil(100 * v)"
    " + math.fmod(x, 0.3) + math.copysign(x, v) + math.pow(abs(x), v)",
    "return deep(x, abs(v)) + half(v) * law_of(x, v, dt)",
    """
    a = 0.0
    for i in range(10):
        for j in range(10, -4, -3):
            if (i + j) % 2 == 0:
                continue
            if i * j > 40:
                break
            a += x * i - v * j / (i + 1) + i ** j * 1e-9
    return a
    """,
    """
    a, b = x, v
    a, b = b, a + b
    s.last, s.ring[1] = turned(a, b)
    s.ring[0], a = s.last, s.ring[1]
    return a + b * s.last + s.ring[0] + s.ring[1] + option(p.side, x) + min(hypot(x, v), math.inf)
    """,
    """
    a = 1
    a += 2
    a -= x
    a *= v
    a /= 4
    a **= 2
    a %= 0.7
    a //= 0.01
    return a
    """,
    """
    index = 2.0
    fault = 0.0
    for index in range(3):
        fault = s.ring[index] + index
        s.ring[int(index)] = fault * x
        s.ring[2] += v
    floats = s.ring[0] + s.ring[1] * 2 + s.ring[-0]
    return floats + fault
    """,
    """
    s.last = s.last + x
    law = s.last * 2
    np = True
    return law + np + s.last
    """,
    """
    a = x > 0
    a += 1
    b = (x > 0) - (v > 0)
    s.last = not x
    if x or b:
        a = v > 0
    return a + -(x > 0 and v) + b / 3 + s.last + (True if v > 1 else 2.0) + min(x > 0, v) + s.ring[v > 0]
    """,
    """
    'A word at the start.'
    if x > 0.0:
        np = 1.0
    else:
        np = 2.0
    pass
    return np * x
    """,
]
STATE = "{'last': 0.25, 'ring': (1.0, -2.0, 3.0)}"
numbers = st.floats(-3.0, 3.0, allow_nan=False).filter(lambda a: a == 0.0 or abs(a) > 1e-12)


def call(compiled, values, x, v, dt=1e-3):
    """Return (force, state, fault) of one call by address, in the law's initial state."""
    p, s = np.array(values, dtype=float), compiled.initial_state.copy()
    fault = np.zeros(native.FAULT_WORDS, dtype=np.int64)
    return native.call(compiled.address, p, np.append(s, 0.0), x, v, dt, fault), fault


@pytest.fixture(scope="module")
def laws(tmp_path_factory):
    folder = tmp_path_factory.mktemp("laws")
    return [environment(folder, law_text(body, STATE, HELPERS)).force for body in BODIES]


@pytest.mark.slow
@pytest.mark.parametrize(
    "which", wide(range(len(BODIES)), lambda i: i % 2 == 0), ids=lambda i: BODIES[i].split()[0] + str(i)
)
@settings(max_examples=40, deadline=None, derandomize=True)
@given(x=numbers, v=numbers, k=st.floats(0.0, 5e3), b=numbers, side=st.sampled_from([0.0, 1.0]))
def test_a_compiled_law_gives_the_plain_functions_results(laws, which, x, v, k, b, side):
    """Results differ by at most 1e-15 of the largest term, because sin and exp differ between libraries."""
    law = laws[which]
    want = law.plain({"stiffness": k, "damping": b, "side": side}, x, v)
    got, fault = call(law.compiled(), (k, b, side), x, v)
    assert fault[0] == (0 if math.isfinite(want) else 1)
    if math.isfinite(want):
        assert got == pytest.approx(want, rel=4e-15, abs=4e-15)
    else:
        assert not math.isfinite(got)


RING = "{'ring': (0.0, 0.0, 0.0), 'last': 0.0}"


def test_state_is_kept_between_samples_and_reset_for_a_run(tmp_path):
    body = "s.count += 1\ns.ring[int(s.count) % 3] = x\nreturn 0.001 * s.count"
    made = environment(tmp_path, law_text(body, "{'count': 0.0, 'ring': (0.0,) * 3}"))
    assert made.state_names == ("count", "ring[0]", "ring[1]", "ring[2]")
    for _ in range(2):
        run = held(made)
        assert run.state.shape == (50, 4)
        assert np.array_equal(run.state[:, 0], np.arange(1.0, 51.0))
        assert run.force == pytest.approx(0.001 * np.arange(1, 51))
        assert np.all(run.state[2:, 1:] == run.position[0])


def test_plain_is_nan_where_the_function_has_no_value(tmp_path):
    """The window plots a law's curve, and must not crash where the law has no value."""
    for value in ("1.0 / (x - x)", "math.sqrt(-1.0)", "math.exp(1e9)", "s.ring[7]"):
        made = environment(tmp_path, law_text(f"return {value}", RING))
        assert math.isnan(made.force.plain(made.values(), 0.0, 0.0))
        assert np.isnan(made.curve(made.values(), np.zeros(3))).all()


@pytest.mark.slow
def test_an_edited_helper_or_constant_gives_a_different_generated_file(tmp_path):
    sources, forces = set(), []
    for gain in (1.0, 2.0):
        for helper in ("GAIN * a", "GAIN * a + 1.0"):
            beside = f"GAIN = {gain}\n\ndef help(a):\n    return {helper}\n"
            made = environment(tmp_path, law_text("return help(3.0)", "", beside))
            sources.add(made.force.compiled().keepalive.__file__)
            forces.append(call(made.force.compiled(), (0.0,) * 3, 0.0, 0.0)[0])
    assert forces == [3.0, 4.0, 6.0, 7.0]
    assert len(sources) == 4


def test_unused_generated_files_are_removed(tmp_path, monkeypatch):
    """Writing another law removes unused files and their machine code; recently loaded files are kept."""
    monkeypatch.setattr(native.numba.config, "CACHE_DIR", str(tmp_path / "cache"))
    both = [environment(tmp_path, law_text(f"return x * {n}.5")).force for n in (7, 8)]
    files = [Path(law.compiled().keepalive.__file__) for law in both]
    for path in files:
        os.utime(path, (0.0, 0.0))
    environment(tmp_path, law_text("return x * 8.5")).force.compiled()
    assert list((tmp_path / "cache").rglob(f"{files[0].stem}.*.nbi"))
    environment(tmp_path, law_text("return x * 9.5")).force.compiled()
    assert not list((tmp_path / "cache").rglob(f"{files[0].stem}.*"))
    assert list((tmp_path / "cache").rglob(f"{files[1].stem}.*.nbi"))


@pytest.mark.skipif(native.INTERPRETED, reason="Nothing is compiled.")
def test_cached_code_must_be_complete_and_of_the_same_numba(tmp_path, monkeypatch):
    """numba writes the index before the data; if the data are missing, the law would be compiled again.

    Some versions of numba compare time stamps, so loading must not change them.
    """
    monkeypatch.setattr(native.numba.config, "CACHE_DIR", str(tmp_path / "kept"))
    law, twin = (environment(tmp_path, law_text("return -2.0 * x")).force for _ in range(2))
    assert not law.is_compiled()
    path = Path(law.compiled().keepalive.__file__)
    assert twin.is_compiled()
    with monkeypatch.context() as another:
        another.setattr(native.numba, "__version__", "0.1")
        assert not twin.is_compiled()
    os.utime(path, (0.0, 1e9))
    twin.compiled()
    assert path.stat().st_mtime == 1e9
    assert path.stat().st_atime > 1e9
    third = environment(tmp_path, law_text("return -2.0 * x")).force
    for ending in ("nbc", "nbi"):
        for part in (tmp_path / "kept").rglob(f"law_*.law-*.{ending}"):
            part.unlink()
        assert not third.is_compiled()
    assert law.is_compiled()


def let_others_run(*_):
    time.sleep(1e-5)


@pytest.mark.slow
def test_parsing_is_limited_to_one_thread():
    """CPython 3.11 fails if garbage collection lets another thread parse at the same time."""
    gc.callbacks.append(let_others_run)
    before = gc.get_threshold()
    gc.set_threshold(50)
    text = "\n".join(f"x{i} = ((((1 + {i}) * 2) - 3) / 4)" for i in range(100))
    try:
        with ThreadPoolExecutor(4) as several:
            found = list(several.map(lambda _: len(translate.parse(text).body), range(40)))
    finally:
        gc.callbacks.remove(let_others_run)
        gc.set_threshold(*before)
    assert found == [100] * 40


def test_a_law_of_the_studio_is_translated_on_first_use_and_any_other_at_once(tmp_path, monkeypatch):
    done = []
    own = discover()["cat"].force.function
    other = environment(tmp_path, law_text("return 0.0")).force.function
    scope = Law.bind.__globals__
    monkeypatch.setitem(scope, "translate", lambda function, *_: done.append(function) or "text")
    for function, at_once in ((own, False), (other, True)):
        done.clear()
        made = Law(function)
        made.bind(())
        assert bool(done) == at_once
        assert (made.source, made.source, done) == ("text", "text", [function])
