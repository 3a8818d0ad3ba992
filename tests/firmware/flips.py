"""Two algorithms that count the jumps ("flips") of the sensor's saw-tooth signal.

One is the firmware's, which is compiled here; the other is the class template's.
"""

import ctypes
import functools
import math
import subprocess
import tempfile
from pathlib import Path

import numpy as np

SKETCH = Path(__file__).resolve().parents[2] / "firmware" / "hapkit"
COUNTS = 921
"""Number of sensor counts per half turn of the motor."""
LOWEST = 51
QUANTUM = math.pi * 0.090 * 0.005 / (COUNTS * 0.074)
"""Handle travel in m per sensor count."""
THRESHOLD = 700
"""A jump of this many counts is a flip for the class template."""
LIMIT = COUNTS / 2
"""Speed in counts per sample up to which a difference over one sample identifies a flip."""
TEMPLATE_LIMIT = (COUNTS - THRESHOLD) / 2
"""The same speed for the template, which uses a difference over two samples."""

_SOURCE = """
#include "flip.h"
extern "C" void track(const unsigned short* raw, int n, unsigned short counts, int* out) {
  FlipTracker flips;
  flips.start(counts);
  flips.begin(raw[0], raw[0]);
  for (int i = 0; i < n; ++i) out[i] = flips.update(raw[i]);
}
"""


@functools.cache
def _library() -> ctypes.CDLL:
    with tempfile.TemporaryDirectory() as folder:
        source, library = Path(folder) / "flips.cpp", Path(folder) / "flips.so"
        source.write_text(_SOURCE)
        command = ["g++", "-std=c++17", "-O1", "-shared", "-fPIC", f"-I{SKETCH}", "-o", library, source]
        subprocess.run(command, check=True)
        return ctypes.CDLL(str(library))


def readings(counts: np.ndarray) -> np.ndarray:
    """Return the readings at handle positions (n,) in counts, which are a saw tooth of whole counts."""
    return (LOWEST + np.floor(np.mod(counts, COUNTS))).astype(np.uint16)


def ours(raw: np.ndarray, counts: int = COUNTS) -> np.ndarray:
    """Return the positions (n,) in counts that the firmware's tracker computes from the readings."""
    raw = np.ascontiguousarray(raw, np.uint16)
    out = np.empty(raw.size, np.int32)
    pointers = (raw.ctypes.data_as(ctypes.c_void_p), raw.size, counts, out.ctypes.data_as(ctypes.c_void_p))
    _library().track(*pointers)
    return out.astype(float)


def template(raw: np.ndarray) -> np.ndarray:
    """Return the positions (n,) in counts that the class template of 2013 to 2024 computes from the readings.

    A flip is a jump over two samples; its size is measured each time and multiplied by the number of all
    flips so far.
    """
    before, earlier, flips, size, just = int(raw[0]), int(raw[0]), 0, 0, False
    out = np.empty(raw.size)
    for k, now in enumerate(raw.astype(int)):
        over_one, over_two = now - before, now - earlier
        if abs(over_two) > THRESHOLD and not just:
            flips += -1 if over_two > 0 else 1
            size = abs(over_one) if abs(over_one) > THRESHOLD else abs(over_two)
            just = True
        else:
            just = False
        earlier, before = before, now
        out[k] = now + flips * size
    return out


def sine(rate: float, magnet: float = 0.0, seconds: float = 2.0) -> np.ndarray:
    """Return handle positions (n,) in counts of a sine of 40 mm and 2 Hz, at a rate in Hz.

    ``magnet`` is the sensor's reading at the middle, in counts.
    """
    time = np.arange(round(seconds * rate)) / rate
    return 0.040 / QUANTUM * np.sin(4.0 * math.pi * time) + magnet


def worst_error(tracker, counts: np.ndarray) -> float:
    """Return the largest error in counts of a tracker over a motion."""
    found = tracker(readings(counts))
    return float(np.abs((found - found[0]) - (np.floor(counts) - np.floor(counts[0]))).max())


def throw(speed: float) -> np.ndarray:
    """Return positions (n,) in counts that accelerate slowly to a speed in counts per sample, then slow down.

    The slow end passes two more flips, so that the template measures their size again.
    """
    up = np.linspace(0.0, speed, 100)
    return np.cumsum(np.concatenate([up, np.full(100, speed), up[::-1], np.full(1000, 2.0)]))


def loses_flips(tracker, speed: float) -> bool:
    """Return True if a tracker is wrong by a flip after a throw with a speed in counts per sample."""
    counts = throw(speed)
    found = tracker(readings(counts))
    return abs((found[-1] - found[0]) - (counts[-1] - counts[0])) > COUNTS / 2


def fastest(tracker) -> float:
    """Return the lowest speed in counts per sample at which a tracker loses flips."""
    low, high = 1.0, float(COUNTS)
    while high - low > 0.1:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if loses_flips(tracker, middle) else (middle, high)
    return low
