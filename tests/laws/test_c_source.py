"""In double precision, a sketch's C code gives the same results as the law in Python.

This is tested for all values of a law's choices, and for random laws. Double precision excludes rounding
differences, which are measured on the chip, so that every difference is an error of the translation.
"""

import ctypes
import itertools
import math
import re
import shutil
import subprocess
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest

from hapkit_studio import environments
from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import LawError
from hapkit_studio.laws import c_source
from hapkit_studio.parameters import Choice
from hapkit_studio.workshop import sketch
from tests.laws import random_laws
from tests.laws.twins import Compiled

pytestmark = pytest.mark.skipif(shutil.which("g++") is None, reason="no g++")

PERIOD = 2.0**-10
_IN_DOUBLE = (
    "sin cos tan asin acos atan sinh cosh tanh exp log log10 sqrt fabs floor ceil trunc round fmod pow atan2 "
)
HEAD = "\n".join(
    [
        "#include <math.h>",
        "#include <stdint.h>",
        "#define float double",
        *(f"#define {name}f {name}" for name in [*_IN_DOUBLE.split(), "hypot", "copysign"]),
        "#define PROGMEM",
        "#define pgm_read_float(at) (*(at))",
        f"static bool stopped; constexpr double kPeriod = {PERIOD!r};",
    ]
)
CALLED = """
extern "C" void run_{n}(int rows, const double* given, double* force) {{
  using namespace n{n};
  for (int i = 0; i < rows; i++) {{
    const double x = given[2 * i], v = given[2 * i + 1];
    (void)x;
    (void)v;
    force[i] = {call};
    if (stopped || !isfinite(force[i])) force[i] = NAN;
    stopped = isnan(force[i]);
  }}
  stopped = false;
}}
"""


@dataclass(frozen=True)
class Job:
    """A law with its parameter values, and the rows (n, 2) of position and velocity of its calls."""

    environment: Environment
    values: dict[str, float]
    rows: np.ndarray


def whole(value):
    """Return a number as text with all its digits."""
    return repr(float(value)) if math.isfinite(value) else "INFINITY" if value > 0.0 else "-INFINITY"


def run(jobs, folder, monkeypatch):
    """Return the force (n,) that each job's sketch computes in C, with NaN from the first fault on."""
    monkeypatch.setattr(c_source, "number", whole)
    monkeypatch.setattr(sketch, "number", whole)
    pieces = [HEAD]
    for n, job in enumerate(jobs):
        law = sketch.translated(job.environment, job.values)
        text = f"{sketch.constants(job.environment, job.values, law)}\n{sketch.law_text(law)}"
        text = re.sub(r"\b(\d+\.\d+)f\b", r"\1", text)
        pieces.append(f"namespace n{n} {{\n{text}\n}}\n{CALLED.format(n=n, call=law.call)}")
    source, library = folder / "laws.cpp", folder / "laws.so"
    source.write_text("\n".join(pieces))
    command = [
        "g++",
        "-std=gnu++11",
        "-Wall",
        "-Wextra",
        "-Werror",
        "-shared",
        "-fPIC",
        "-o",
        library,
        source,
    ]
    subprocess.run(command, check=True)
    laws = ctypes.CDLL(str(library))
    forces = []
    for n, job in enumerate(jobs):
        forces.append(np.empty(len(job.rows)))
        rows = np.ascontiguousarray(job.rows)
        laws[f"run_{n}"](len(rows), *(a.ctypes.data_as(ctypes.c_void_p) for a in (rows, forces[-1])))
    return forces


def check(jobs, folder, monkeypatch):
    for job, found in zip(jobs, run(jobs, folder, monkeypatch), strict=True):
        law = Compiled(job.environment.force, job.values, PERIOD)
        wanted = np.array([law.call(x, v) for x, v in job.rows.tolist()])
        faults = np.flatnonzero(~np.isfinite(wanted))
        wanted[faults[0] if len(faults) else len(wanted) :] = np.nan
        assert found == pytest.approx(wanted, rel=1e-6, abs=1e-8, nan_ok=True), job.values


@pytest.mark.slow
def test_every_environment_with_every_choice_agrees(tmp_path, monkeypatch):
    time = np.arange(1500) * PERIOD
    x = 0.02 * np.sin(5.0 * time) + 0.006 * np.sin(20.0 * time)
    rows = np.stack([x, np.gradient(x, PERIOD)], axis=1)
    jobs = []
    for environment in environments.discover().values():
        choices = [p for p in environment.parameters if isinstance(p, Choice) and p.key != "picture"]
        for options in itertools.product(*(p.options for p in choices)):
            values = environment.values({p.key: o for p, o in zip(choices, options, strict=True)})
            values = {key: float(np.float32(value)) for key, value in values.items()}
            jobs.append(Job(environment, values, rows))
    check(jobs, tmp_path, monkeypatch)


@pytest.mark.slow
def test_random_laws_agree(tmp_path, monkeypatch):
    jobs, seeds = [], range(30)
    for seed in seeds:
        try:
            law = random_laws.law(tmp_path, seed)
        except LawError:
            continue
        values = {key: float(np.float32(value)) for key, value in random_laws.settings(seed).items()}
        jobs.append(Job(SimpleNamespace(force=law), values, random_laws.rows(seed)))
    assert len(jobs) > 0.8 * len(seeds)
    check(jobs, tmp_path, monkeypatch)
