"""Fuzz both ends of the protocol: `make fuzz`. Runs are reproducible and print their size and duration.

The firmware's parser and controller, and its verifier and machine, run under libFuzzer if clang is available,
else under a driver with random mutations, with AddressSanitizer and UndefinedBehaviorSanitizer. The
computer's two decoders and the firmware's decoder get the same damaged lines. Noise shows how often a CRC-16
is right by chance.
"""

import argparse
import ctypes
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.stats import binom

from hapkit_studio.devices import virtual_board
from hapkit_studio.protocol import codec
from hapkit_studio.protocol.framing import DELIMITER, Decoder, encode, frame
from hapkit_studio.protocol.messages import MESSAGES, Sample, Telemetry
from tests.protocol import fuzz_seeds

FOLDER = Path(__file__).resolve().parents[2] / "firmware" / "fuzz"
LARGEST_TO_BOARD = max(m.size() for m in MESSAGES if not m.from_board())
SHOWN = {Sample.ID: Sample, Telemetry.ID: Telemetry}
FRAMES_A_LINE = 40
KINDS = 5


def build(*targets: str) -> Path:
    """Build all or some of the PC programs in the folder of the virtual board; return the folder."""
    folder = virtual_board.program().parent / "fuzz"
    command = ["make", "-s", "-j2", "-C", str(FOLDER), f"BUILD={folder}"]
    subprocess.run([*command, *targets], check=True, capture_output=True, text=True)
    return folder


def firmware(count: int, seed: int, folder: Path) -> str:
    """Run parser and controller on ``count`` inputs; return the program used; raise on a failure."""
    return _run("", count, seed, folder, FOLDER / "corpus")


def machine(count: int, seed: int, folder: Path) -> str:
    """Run verifier and machine on ``count`` inputs; return the program used; raise on a failure."""
    with tempfile.TemporaryDirectory() as corpus:
        fuzz_seeds.write(fuzz_seeds.machine_inputs(), Path(corpus))
        return _run("machine_", count, seed, folder, Path(corpus))


def _run(prefix: str, count: int, seed: int, folder: Path, corpus: Path) -> str:
    fuzzer = folder / f"{prefix}fuzzer"
    if fuzzer.exists():
        # the firmware allocates no memory, but the fuzzer itself needs ever more memory on a slow machine
        options = [f"-runs={count}", f"-seed={seed}", "-max_len=200", "-rss_limit_mb=8192"]
        options.append(f"-artifact_prefix={folder}/")
        command = [str(fuzzer), *options]
    else:
        command = [str(folder / f"{prefix}driver"), str(count), str(seed)]
    quick = os.environ | {"ASAN_OPTIONS": "malloc_context_size=1"}
    with tempfile.TemporaryDirectory() as found:  # the fuzzer writes new inputs to the first folder
        places = [found, str(corpus)] if fuzzer.exists() else [str(corpus)]
        done = subprocess.run([*command, *places], env=quick, capture_output=True, text=True, check=False)
    if done.returncode:
        raise AssertionError(done.stderr[-4000:])
    return Path(command[0]).name


# --- all three decoders get the same damaged lines
def _random_message(kind, rng: np.random.Generator):
    raw = bytes([kind.ID]) + rng.bytes(kind.size())
    return encode(kind.unpack(raw)) if kind in SHOWN.values() else frame(raw)


def _damaged(data: bytes, rng: np.random.Generator) -> bytes:
    """Return the bytes with one to three of them changed, lost, added or cut off."""
    line = bytearray(data)
    for _ in range(int(rng.integers(1, 4))):
        at, what = int(rng.integers(len(line) + 1)), int(rng.integers(4))
        if what == 0 and at < len(line):
            line[at] = int(rng.integers(256))
        elif what == 1:
            del line[at : at + 1]
        elif what == 2:
            line[at:at] = rng.bytes(1)
        else:
            del line[at : at + int(rng.integers(1, 20))]
    return bytes(line)


def pool(seed: int, size: int = 4096) -> tuple[list[bytes], set[bytes]]:
    """Return parts of lines and the bodies that they contain.

    Five kinds alternate: a good frame, a frame without a message, each of these two damaged, and noise.
    """
    rng = np.random.default_rng(seed)
    found, meant = [], set()
    for k in range(size):
        good = _random_message(MESSAGES[k % len(MESSAGES)], rng)
        noise = rng.bytes(int(rng.integers(1, 90)))
        own = frame(bytes([int(rng.integers(256))]) + rng.bytes(int(rng.integers(100))))
        found.append((good, own, _damaged(good, rng), _damaged(own, rng), noise)[k % KINDS])
        meant.update(Decoder().bodies(good + own))
    return found, meant


class Three:
    """The computer's two decoders and the firmware's decoder, which get the same lines."""

    def __init__(self, folder: Path):
        self._parse = ctypes.CDLL(str(folder / "parser.so")).parse
        self._parse.restype = ctypes.c_size_t
        self._parse.argtypes = [ctypes.c_char_p, ctypes.c_size_t, ctypes.c_char_p, ctypes.c_void_p]

    def board(self, line: bytes) -> tuple[list[bytes], int]:
        out, bad = ctypes.create_string_buffer(len(line) + 1), ctypes.c_uint32()
        end = self._parse(line, len(line), out, ctypes.byref(bad))
        raw, at, bodies = out.raw[:end], 0, []
        while at < end:
            bodies.append(raw[at + 1 : at + 1 + raw[at]])
            at += 1 + raw[at]
        return bodies, bad.value

    def check(self, line: bytes) -> list[bytes]:
        """Assert that all three agree on a line that ends with a delimiter; return its bodies."""
        plain = Decoder()
        bodies = plain.bodies(line)
        short = [body for body in bodies if len(body) <= 1 + LARGEST_TO_BOARD]
        assert self.board(line) == (short, plain.bad_frames + len(bodies) - len(short))
        state, buffer = codec.new_reader()
        data = np.frombuffer(bytearray(line), np.uint8)
        out = np.zeros((codec.rows_for(len(line)), codec.SAMPLE_WIDTH))
        rows = out[: codec.feed(state, buffer, data, len(line), out)]
        shown = [SHOWN[b[0]].unpack(b) for b in bodies if b[0] in SHOWN and len(b) == 1 + SHOWN[b[0]].size()]
        assert rows[:, codec.COUNT].tolist() == [m.count for m in shown]
        assert rows[:, codec.SEQ].tolist() == [m.seq for m in shown]
        assert state[codec.BAD_FRAMES] == plain.bad_frames
        assert state[codec.OTHER_FRAMES] == len(bodies) - len(shown)
        return bodies


@dataclass
class Lines:
    """The numbers of frames compared, of damaged frames, and of damaged frames accepted."""

    frames: int = 0
    damaged: int = 0
    false: int = 0


def agreement(count: int, seed: int, folder: Path) -> Lines:
    """Assert that the decoders agree on ``count`` frames, whole and damaged."""
    three, (pieces, meant) = Three(folder), pool(seed)
    rng, found = np.random.default_rng(seed), Lines()
    while found.frames < count:
        chosen = rng.integers(len(pieces), size=FRAMES_A_LINE)
        line = DELIMITER.join(_damaged_again(pieces[k], k % KINDS, rng) for k in chosen) + DELIMITER
        found.false += sum(body not in meant for body in three.check(line))
        found.frames += FRAMES_A_LINE
        found.damaged += int(np.count_nonzero(chosen % KINDS >= 2))
    return found


def _damaged_again(piece: bytes, kind: int, rng: np.random.Generator) -> bytes:
    """Return a damaged part, or noise, with one byte replaced at random; return a good part unchanged."""
    if kind < 2:
        return piece
    at = int(rng.integers(len(piece) + 1))
    return piece[:at] + rng.bytes(1) + piece[at + 1 :]


# --- noise on the line sometimes passes as a frame
NOISE_LENGTH = 12
"""Number of bytes of a line of noise, as many as a Force has.

COBS always accepts them, so only the CRC rejects.
"""

CRC_CHANCE = 2.0**-16
DOUBT = 1e-9
"""Significance level of the statistical tests."""


def at_most(lines: int) -> int:
    """Return the upper limit of the number of damaged frames that pass a CRC-16 by chance."""
    return int(binom.isf(DOUBT, lines, CRC_CHANCE))


def at_least(lines: int) -> int:
    """Return the lower limit of the number of noise lines that have the right CRC by chance."""
    return int(binom.ppf(DOUBT, lines, CRC_CHANCE))


def noise(count: int, seed: int, folder: Path) -> int:
    """Return the number of noise lines that the firmware's parser accepts.

    Assert that other decoders agree.
    """
    function = ctypes.CDLL(str(folder / "parser.so")).parse_noise
    function.restype = ctypes.c_uint64
    function.argtypes = [ctypes.c_uint64, ctypes.c_size_t, ctypes.c_uint64]
    return int(function(count, NOISE_LENGTH, seed))


def main(args: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--inputs", type=int, default=10_000_000)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args(args)
    folder, part = build(), given.inputs // 20
    began = time.monotonic()
    name = firmware(6 * part, given.seed, folder)
    print(f"firmware, parser and controller by {name}: {6 * part:,} inputs, no failure", flush=True)
    name = machine(given.inputs, given.seed, folder)
    print(f"firmware, verifier and machine by {name}: {given.inputs:,} inputs, no failure", flush=True)
    lines = agreement(part, given.seed, folder)
    print(f"three decoders on good, damaged and foreign frames: {lines.frames:,} frames, all agree")
    rest = given.inputs - 7 * part
    wrong = [
        (lines.damaged, lines.false, "damaged frames"),
        (rest, noise(rest, given.seed, folder), "lines of noise"),
    ]
    for count, accepted, what in wrong:
        print(f"{count:,} {what}: {accepted} accepted, by chance at most {at_most(count)}")
    print(f"{2 * given.inputs:,} inputs in {time.monotonic() - began:.0f} s")
    return any(accepted > at_most(count) for count, accepted, _ in wrong)


if __name__ == "__main__":
    sys.exit(main())
