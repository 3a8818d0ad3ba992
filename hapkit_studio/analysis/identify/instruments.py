"""Instruments out of the hand's target: what it alone makes of the motion, free of the sensor's steps.

A loop feeds the sensor's steps back, so they move the handle, and at a constant speed they are no noise:
samples that lie apart share them. The target knows nothing of them. Two-stage least squares.
"""

import numpy as np

from hapkit_studio.analysis.identify.regression import APART
from hapkit_studio.analysis.identify.windows import Windows

# The handle follows its target for some time: its response is made of the target so many seconds before.
_LATER = (0.0, 0.016, 0.048)
# Below that first-stage F an instrument is weak, and intervals are worth nothing (Staiger and Stock 1997).
STRONG = 10.0
# Up to an F of a hundred intervals are too narrow, at 10 by 1.75 (Lee, McCrary, Moreira and Porter 2022).
_WIDER = 7.5


def fitted(
    target: np.ndarray, windows: Windows, columns: np.ndarray, kept: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the columns (windows, p) as the target (n,) in m makes them, and how strong each is (p,)."""
    instruments = _instruments(target, windows, columns)
    made = np.zeros_like(columns)
    used, own = instruments[kept], columns[kept]
    if len(used) <= 1.5 * instruments.shape[1]:
        return made, np.zeros(columns.shape[1])
    made[kept] = used @ np.linalg.lstsq(used, own, rcond=1e-9)[0]
    return made, _strength(made[kept], own, instruments.shape[1])


def _instruments(target: np.ndarray, windows: Windows, columns: np.ndarray) -> np.ndarray:
    series = [windows.derivative(target, 0)]
    for seconds in _LATER:
        samples = round(seconds / windows.period)
        late = np.concatenate((np.full(samples, target[0]), target[: len(target) - samples]))
        series += [windows.derivative(late, 1), windows.derivative(late, 2)]
    # directions and the constant are known as they are
    found = np.column_stack([*series, columns[:, -2:]])
    return found / np.maximum(np.sqrt(np.mean(found**2, axis=0)), 1e-12)


def _strength(made: np.ndarray, own: np.ndarray, instruments: int) -> np.ndarray:
    """Return each column's F: what of it the target alone makes, beside what it does not."""
    scale = np.maximum(np.sqrt(np.mean(own**2, axis=0)), 1e-300)
    inverse = np.diag(np.linalg.pinv((made / scale).T @ (made / scale)))
    rest = np.mean(((own - made) / scale) ** 2, axis=0)
    # neighbouring windows share their samples: so many of them tell as much as one
    return 1.0 / np.maximum(APART * inverse * rest * instruments, 1e-12)


def widening(strong: np.ndarray) -> np.ndarray:
    """Return by how much intervals are to be wider for the strength of their instruments."""
    return 1.0 + _WIDER / strong
