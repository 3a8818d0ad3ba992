"""The board's laws built for this computer, beside the same laws in Python: both fed with the same rows."""

import ctypes
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from hapkit_studio.environments.base import Environment
from hapkit_studio.laws import native
from hapkit_studio.workshop.own import built_in

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "firmware" / "tests" / "laws"
MOST = 16
ENVIRONMENTS = built_in()

needs_compiler = pytest.mark.skipif(
    shutil.which("g++") is None or shutil.which("make") is None, reason="no g++ or no make"
)
_real, _reals = ctypes.c_double, ctypes.POINTER(ctypes.c_double)
_words = ctypes.POINTER(ctypes.c_int64)
_Law = ctypes.CFUNCTYPE(_real, _reals, _reals, _real, _real, _real, _words)


@dataclass(frozen=True)
class Job:
    """One law with its numbers, and the rows (n, 2) of position and velocity that it is called with."""

    environment: Environment
    values: dict[str, float]
    period: float
    rows: np.ndarray
    states: np.ndarray | None = None
    number: int | None = None

    @property
    def parameters(self) -> np.ndarray:
        """Return the parameters as the board has them, single precision."""
        return single(list(self.values.values()))

    def words(self) -> bytes:
        """Return what the driver reads."""
        number = list(ENVIRONMENTS).index(self.environment.key) if self.number is None else self.number
        head = np.array([number, self.states is not None, len(self.rows)], np.uint32).tobytes()
        p = np.zeros(MOST, np.float32)
        p[: len(self.values)] = self.parameters
        rows = self.rows if self.states is None else np.hstack([self.rows, self.states])
        return head + np.float32(self.period).tobytes() + p.tobytes() + rows.astype(np.float32).tobytes()


def single(values) -> np.ndarray:
    """Return numbers rounded to single precision, as float64."""
    return np.asarray(values, np.float32).astype(float)


def build(folder: Path, name: str) -> Path:
    """Return one of the programs, built into a folder."""
    made = folder / name
    subprocess.run(["make", "-s", "-C", FOLDER, f"BUILD={folder}", made], check=True)
    return made


def run(driver: Path, jobs: list[Job]) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return (force (n,), state after (n, k)) of every job by the board's law."""
    data = b"".join(job.words() for job in jobs)
    done = subprocess.run([driver], input=data, capture_output=True, check=False)
    assert done.returncode == 0, done.stderr.decode()[:4000]
    flat, found, place = np.frombuffer(done.stdout, np.float32).astype(float), [], 0
    for job in jobs:
        width = 1 + len(job.environment.state_names)
        answer = flat[place : place + width * len(job.rows)].reshape(len(job.rows), width)
        found.append((answer[:, 0], answer[:, 1:]))
        place += answer.size
    assert place == len(flat)
    return found


def by_python(job: Job, exact: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """Return (force (n,), state after (n, k)) of a job by the compiled law, in double precision.

    Where the job brings states, each row starts from its own. Rows are rounded unless they are exact.
    """
    law = job.environment.force.compiled()
    function = _Law(law.address)
    p = np.append(job.parameters, 0.0)
    s = np.append(law.initial_state, 0.0)
    fault = np.zeros(native.FAULT_WORDS, np.int64)
    places = (p.ctypes.data_as(_reals), s.ctypes.data_as(_reals))
    size, period = len(s) - 1, float(np.float32(job.period))
    force, after = np.empty(len(job.rows)), np.empty((len(job.rows), size))
    rows = job.rows if exact else single(job.rows)
    for k, (x, v) in enumerate(rows.tolist()):
        if job.states is not None:
            s[:size] = job.states[k]
        fault[:] = 0
        force[k] = function(*places, x, v, period, fault.ctypes.data_as(_words))
        if fault[0]:
            force[k] = np.nan
        after[k] = s[:size]
    return force, after
