"""Records: numbers with names, read and written as attributes in Python and in compiled code."""

from typing import Any

import numpy as np

Record = Any  # a numpy.record; its fields have no types that mypy knows


def record(*fields: tuple) -> np.dtype:
    """Return a dtype whose elements have their fields as attributes, of 8 bytes each or arrays of these."""
    return np.dtype((np.record, np.dtype(list(fields), align=True)))


def zeros(dtype: np.dtype) -> Record:
    """Return a record of zeros."""
    return np.zeros(1, dtype)[0]
