"""The laws in Python, fed with rows of position and velocity as a board or a sketch has them."""

import ctypes
from dataclasses import dataclass

import numpy as np

from hapkit_studio.environments.base import Environment
from hapkit_studio.laws import native
from hapkit_studio.workshop.own import built_in

ENVIRONMENTS = built_in()

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

    @property
    def parameters(self) -> np.ndarray:
        """Return the parameters as the board has them, single precision."""
        return single(list(self.values.values()))


def single(values) -> np.ndarray:
    """Return numbers rounded to single precision, as float64."""
    return np.asarray(values, np.float32).astype(float)


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
