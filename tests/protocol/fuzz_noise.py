"""Noise on the line: how often the decoders take it for a frame."""

import ctypes
from pathlib import Path

import numpy as np
from scipy.stats import binom

from hapkit_studio.dynamics.jit import compiled
from hapkit_studio.protocol import codec

LENGTH = 12
"""Bytes of a line of noise: those of a Force. COBS always takes them, so only the CRC stands in the way."""

CRC_CHANCE = 2.0**-16
DOUBT = 1e-9
"""Probability that a run is called wrong although the CRC does what a CRC can."""


def at_most(lines: int) -> int:
    """Return how many of so many damaged frames a CRC-16 may let pass by chance."""
    return int(binom.isf(DOUBT, lines, CRC_CHANCE))


def at_least(lines: int) -> int:
    """Return how many of so many lines of noise have the right CRC by chance, at least."""
    return int(binom.ppf(DOUBT, lines, CRC_CHANCE))


def board(count: int, seed: int, folder: Path) -> int:
    """Return how many lines of noise the firmware's parser takes."""
    function = ctypes.CDLL(str(folder / "parser.so")).parse_noise
    function.restype = ctypes.c_uint64
    function.argtypes = [ctypes.c_uint64, ctypes.c_size_t, ctypes.c_uint64]
    return int(function(count, LENGTH, seed))


@compiled
def _draw(seed):
    """Return the next state of Knuth's MMIX generator and its upper bits."""
    seed = seed * np.uint64(6364136223846793005) + np.uint64(1442695040888963407)
    return seed, int(seed >> np.uint64(40))


@compiled
def _noise(state, buffer, line, out, count, seed):
    n = line.shape[0] - 1
    for _ in range(count):
        for k in range(n):
            seed, number = _draw(seed)
            line[k] = 1 + number % 255
        at = 0
        while at < n:
            seed, number = _draw(seed)
            line[at] = 1 + number % (n - at)
            at += int(line[at])
        codec.feed(state, buffer, line, n + 1, out)


def computer(count: int, seed: int) -> int:
    """Return how many lines of noise the computer's compiled decoder takes."""
    state, buffer = codec.new_reader()
    line, out = np.zeros(LENGTH + 1, np.uint8), np.zeros((4, codec.SAMPLE_WIDTH))
    _noise(state, buffer, line, out, count, np.uint64(seed))
    return count - int(state[codec.BAD_FRAMES])
