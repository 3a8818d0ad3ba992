"""What is in assembler besides the machine, in simavr: a filter's product and a frame's bytes, as in C++."""

import numpy as np
import pytest

from hapkit_studio.protocol.framing import frame
from tests.firmware.chip_calls import Chip, build, needs_compiler

pytestmark = needs_compiler

WRITER, BODY, CODED = 0x700, 0x710, 0x780
"""Places in the chip's memory that nothing else uses."""
LARGEST = 72


@pytest.fixture(scope="module")
def chip(tmp_path_factory):
    folder = tmp_path_factory.mktemp("chip")
    build(folder)
    with Chip(folder) as chip:
        yield chip


def share(value, half):
    """Return what estimator::share gives in C++ (n,) of (n,) uint32."""
    value, half = value.astype(np.uint64), half.astype(np.uint64)
    high, low, large, small = value >> 16, value & 0xFFFF, half >> 16, half & 0xFFFF
    total = high * large + (low * large >> 16) + (high * small >> 16)
    total -= np.where(high & 0x8000, half, 0)
    return (total << 1).astype(np.uint32)


def test_a_share_of_a_number_is_the_same_to_the_last_bit(chip):
    rng = np.random.default_rng(4)
    size = rng.integers(0, 33, (2, 3000)).astype(np.uint64)
    value, half = (rng.integers(0, 1 << 32, (2, 3000), dtype=np.uint64) >> (32 - size)).astype(np.uint32)
    edges = np.uint32([0, 1, 0xFFFF, 0x10000, 0x7FFFFFFF, 0x80000000, 0xFFFF0000, 0xFFFFFFFF])
    value = np.append(np.where(rng.random(3000) < 0.5, value, -value.view(np.int32)), np.repeat(edges, 8))
    value, half = value.astype(np.int64).astype(np.uint32), np.append(half, np.tile(edges, 8))
    found, cycles = chip.call("estimator_share", value, half)
    np.testing.assert_array_equal(found, share(value, half))
    assert cycles.max() < 110
    near = value.view(np.int32) * (half / 2.0**31)
    fits = np.abs(near) < 2.0**30
    assert fits.sum() > 1000
    low = near[fits] - found[fits].view(np.int32)
    assert low.min() >= 0.0
    assert low.max() < 6.0


def written(chip, body: bytes, *parts: int) -> bytes:
    """Return the frame that the chip makes of a body, put into it in parts of so many bytes."""
    start = b"\xff\xff" + CODED.to_bytes(2, "little") + (CODED + 1).to_bytes(2, "little")
    chip.write(WRITER, start)
    at = 0
    for size in parts:
        put(chip, body[at : at + size])
        at += size
    put(chip, body[at:])
    put(chip, chip.read(WRITER, 2))
    state = chip.read(WRITER, 6)
    code, end = int.from_bytes(state[2:4], "little"), int.from_bytes(state[4:6], "little")
    coded = bytearray(chip.read(CODED, end - CODED))
    coded[code - CODED] = end - code
    return bytes(coded) + b"\0"


def put(chip, data: bytes) -> None:
    chip.write(BODY, data or b"\0")
    place = np.array([WRITER << 16 | BODY], np.uint32)
    chip.call("frame_put", place, np.array([len(data) << 16], np.uint32))


def test_a_frame_is_what_the_computer_makes_of_its_body(chip):
    rng = np.random.default_rng(5)
    for size in range(1, LARGEST + 1):
        body = (rng.integers(0, 256, size) * (rng.random(size) < 0.7)).astype(np.uint8).tobytes()
        assert written(chip, body, *rng.integers(0, size + 1, 1)) == frame(body)
