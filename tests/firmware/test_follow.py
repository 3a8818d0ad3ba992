"""How the board follows a sensor, in the simulated chip: where the handle is, and as the C++ elsewhere."""

import ctypes
import subprocess

import numpy as np
import pytest

from hapkit_studio.protocol.messages import Sensor
from tests.firmware.asked_chip import chip
from tests.firmware.test_firmware import SKETCH
from tests.firmware.vb import CHIPS, needs_compiler

pytestmark = needs_compiler

FAILED, BEGIN, KIND, LEFTWARDS = 1 << 16, 1 << 17, 1 << 16, 1 << 24
KITS = {
    "magnet": (921, Sensor.MAGNETORESISTIVE, 51),
    "angle": (16384, Sensor.AS5048A, 0),
    "encoder": (0, Sensor.QUADRATURE, 0),
}
_SOURCE = """
#include "follow.h"
extern "C" void count(const uint32_t* words, int n, int32_t* out) {
  for (int i = 0; i < n; ++i) out[i] = static_cast<int32_t>(answer(words[2 * i], words[2 * i + 1]));
}
"""


@pytest.fixture(scope="module")
def board(tmp_path_factory):
    """Return a function that asks the assembler in the chip: (n, 2) words, (n,) counts."""
    words = ("avr-g++", "-std=gnu++11", CHIPS / "follow.cpp", SKETCH / "sensor.cpp", SKETCH / "follow_avr.S")
    for asked in chip(tmp_path_factory.mktemp("chip"), *words, f"-I{SKETCH}"):
        yield lambda words, ask=asked: ask(*np.ascontiguousarray(words.T).view(np.float32)).view(np.int32)


@pytest.fixture(scope="module")
def computer(tmp_path_factory):
    """Return the same for the C++ that stands for it elsewhere."""
    folder = tmp_path_factory.mktemp("computer")
    source, library = folder / "count.cpp", folder / "count.so"
    source.write_text(_SOURCE)
    flags = ["-std=c++17", "-O1", "-shared", "-fPIC", f"-I{SKETCH}", f"-I{CHIPS}"]
    subprocess.run(["g++", *flags, "-o", library, source, SKETCH / "sensor.cpp"], check=True)
    count = ctypes.CDLL(str(library)).count

    def asked(words):
        words = np.ascontiguousarray(words, np.uint32)
        out = np.empty(len(words), np.int32)
        count(words.ctypes.data_as(ctypes.c_void_p), len(words), out.ctypes.data_as(ctypes.c_void_p))
        return out

    return asked


def readings(counts, size, lowest):
    """Return what a sensor reads (n,) at the handle's places (n,) in counts."""
    return lowest + np.mod(counts, size or 65536)


def words(kit, raw, leftwards=False):
    """Return what begins with a kit and then has these readings."""
    size, kind, _ = KITS[kit]
    begin = (BEGIN, size | kind * KIND | leftwards * LEFTWARDS)
    return np.array([begin, *((r, 0) for r in raw)], np.uint32)


@pytest.mark.parametrize("leftwards", [False, True])
@pytest.mark.parametrize("kit", KITS)
def test_the_handle_is_where_it_was_moved_to(board, kit, leftwards):
    size, _, lowest = KITS[kit]
    # up to two fifths of the range in a sample, over both ends of what a 16-bit number holds
    fastest = 0.4 * (size or 65536)
    steps = fastest * np.sin(2 * np.pi * np.arange(400) / 400.0)
    counts = np.floor(np.cumsum(steps)).astype(np.int64) + 100
    found = board(words(kit, readings(counts, size, lowest), leftwards))[1:]
    np.testing.assert_array_equal(found - found[0], (counts - counts[0]) * (-1 if leftwards else 1))
    assert np.ptp(counts) > 2 * (size or 65536)


@pytest.mark.parametrize("kit", KITS)
def test_the_assembler_bridges_and_believes_what_the_c_plus_plus_does(board, computer, kit):
    size, _, lowest = KITS[kit]
    rng = np.random.default_rng(5)
    span = size or 65536
    steps = rng.normal(scale=span / rng.choice([400, 20, 6], 600), size=600)
    raw = readings(np.floor(np.cumsum(steps)).astype(np.int64), size, lowest)
    wrong = rng.random(600) < 0.15
    raw[wrong] = rng.integers(0, 1024 if lowest else span, wrong.sum())
    raw = raw + FAILED * (rng.random(600) < 0.05)
    asked = words(kit, raw)
    np.testing.assert_array_equal(board(asked), computer(asked))


@pytest.mark.parametrize("kit", KITS)
def test_one_wrong_reading_in_a_calm_motion_is_bridged(board, computer, kit):
    size, _, lowest = KITS[kit]
    span = size or 65536
    counts = np.floor(np.cumsum(span / 40 * np.sin(np.arange(600) / 24.0))).astype(np.int64)
    raw = readings(counts, size, lowest)
    # so far apart that all doubt is over in between
    wrong = np.arange(600) % 40 == 39
    raw[wrong] = readings(counts[wrong] + span // 3, size, lowest)
    asked = words(kit, raw)
    found = board(asked)[1:]
    np.testing.assert_array_equal(found, computer(asked)[1:])
    if size:
        # as if the last step but one went on
        assert np.abs((found - found[0]) - (counts - counts[0])).max() <= 0.01 * span
