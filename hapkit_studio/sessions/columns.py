"""The compressed form of a signal's samples in a session.

Multiples of a step (counts, microseconds, ticks, flags) are stored as differences with the fewest possible
bytes. Other values are stored as 32-bit floats. The bytes are sorted by significance before zlib compresses
them.
"""

import struct
import zlib

import numpy as np

from hapkit_studio.errors import FileError

_INTEGERS = tuple(np.dtype(code) for code in ("<i1", "<i2", "<i4", "<i8"))
_FLOATS = np.dtype("<f4")
_HEAD = struct.Struct("<Bdq")  # bytes per difference (0 means floats), step, and first number
_LEVEL = 6
# a value is stored as a float if it differs from a multiple by more than this fraction of a step
_NO_MULTIPLE = 1e-3
MOST_WHOLE = 1 << 53  # integers below this number are exact as float64
_LARGEST_STEP = 1e200


class DamagedError(FileError):
    """Raised if stored data were changed after they were written, or if a value is out of range."""


def encode(values: np.ndarray, step: float = 0.0, rounded: bool = True) -> bytes:
    """Compress numbers (n,) as multiples of a step in SI; a step of 0 stores them as floats.

    All numbers are stored as floats if one of them is not finite or exceeds 2**53 steps. If ``rounded`` is
    false, they are also stored as floats if one of them lies between two multiples.
    """
    if step > 0.0 and len(values) and np.abs(values).max() < MOST_WHOLE * step:
        multiples = np.rint(values / step)
        if rounded or np.abs(values - step * multiples).max() <= _NO_MULTIPLE * step:
            return _encode_multiples(multiples.astype(np.int64), step)
    with np.errstate(over="ignore"):  # values too large for 32 bits become infinite
        return _squeeze(_HEAD.pack(0, 0.0, 0), values.astype(_FLOATS))


def _encode_multiples(multiples: np.ndarray, step: float) -> bytes:
    differences = np.diff(multiples)
    least, most = (int(end(differences, initial=0)) for end in (np.min, np.max))
    kind = next(k for k in _INTEGERS if np.iinfo(k).min <= least and most <= np.iinfo(k).max)
    return _squeeze(_HEAD.pack(kind.itemsize, step, int(multiples[0])), differences.astype(kind))


def decode(data: bytes, count: int) -> np.ndarray:
    """Return the numbers (count,) as float64 from data that ``encode`` returned.

    Raise DamagedError if the data are damaged.
    """
    try:
        # the memory is limited to that of ``count`` numbers
        unpacker = zlib.decompressobj()
        plain = unpacker.decompress(data, _HEAD.size + count * _INTEGERS[-1].itemsize + 1)
        if not unpacker.eof:
            raise DamagedError("Samples cannot be read: their end is missing.")
        size, step, first = _HEAD.unpack_from(plain)
        if size == 0:
            with np.errstate(invalid="ignore"):  # a file may contain NaNs with arbitrary bits
                return _spread(plain, _FLOATS, count).astype(float)
        kind = next(k for k in _INTEGERS if k.itemsize == size)
        differences = np.concatenate([[first], _spread(plain, kind, count - 1)])
    except (struct.error, zlib.error, StopIteration, ValueError, OverflowError) as error:
        raise DamagedError(f"Samples cannot be read: {error}.") from None
    wide = size == _INTEGERS[-1].itemsize or abs(first) > MOST_WHOLE
    if not 0.0 < step < _LARGEST_STEP or (wide and _wraps(differences)):
        raise DamagedError("Samples cannot be read: their values are too large.")
    return step * np.cumsum(differences)


def _wraps(differences: np.ndarray) -> bool:
    """Return True if a cumulative sum of differences exceeds 2**54, so that it is not exact as float64."""
    return bool(np.abs(np.cumsum(differences, dtype=float)).max() > 2.0 * MOST_WHOLE)


def _squeeze(head: bytes, numbers: np.ndarray) -> bytes:
    planes = numbers.view(np.uint8).reshape(len(numbers), numbers.itemsize).T
    return zlib.compress(head + planes.tobytes(), _LEVEL)


def _spread(plain: bytes, kind: np.dtype, count: int) -> np.ndarray:
    planes = np.frombuffer(plain, np.uint8, offset=_HEAD.size).reshape(kind.itemsize, count)
    return planes.T.copy().view(kind)[:, 0]
