"""Records: named numbers that Python and compiled code read and write as attributes."""

from typing import Any

import numpy as np

Record = Any  # a numpy.record; mypy does not know the types of its fields


def record(*fields: tuple) -> np.dtype:
    """Return a dtype of records whose fields are attributes: 8-byte numbers, or arrays of them."""
    return np.dtype((np.record, np.dtype(list(fields), align=True)))


def zeros(dtype: np.dtype) -> Record:
    return np.zeros(1, dtype)[0]
