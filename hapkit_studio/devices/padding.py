"""Measures, by the board's clock, how the delay changes if frames are padded to a whole USB packet."""

import time
from collections import deque
from collections.abc import Iterable
from typing import NamedTuple

from hapkit_studio.devices import delays
from hapkit_studio.devices.hapkit import PACKET, HapkitBoard
from hapkit_studio.errors import DeviceError, NoDataError
from hapkit_studio.protocol.framing import Decoder
from hapkit_studio.protocol.messages import Force, Sample

MEASURED_SECONDS = 1.0
_SETTLING = 50
_LEFT_OVER_SECONDS, _QUIET_SECONDS = 1.0, 1.0
_SLOWEST = 10.0
"""Time-out of a measurement, as a multiple of its board time."""


class Padding(NamedTuple):
    """Delays in s from a sample to its force, with plain frames and with frames padded to PACKET bytes."""

    plain: float
    padded: float

    @property
    def better(self) -> int:
        """Return PACKET if padding reduces the delay by over 5 %, else 0, because padding costs bandwidth."""
        return PACKET if self.padded < 0.95 * self.plain else 0


def measure_padding(board: HapkitBoard, seconds: float = MEASURED_SECONDS) -> Padding:
    """Answer samples with zero force in plain, then in padded frames; return the delays.

    The stream is off afterwards. Raise DeviceError if the board fails.
    """
    return Padding(*(_delay(board, padded, seconds) for padded in (0, PACKET)))


def _delay(board: HapkitBoard, padded: int, seconds: float) -> float:
    settled = time.monotonic() + _LEFT_OVER_SECONDS
    while _read(board) and time.monotonic() < settled:  # discard bytes of an earlier stream
        pass
    board.start_stream(padded)
    try:
        taken = _answered(board, seconds)
    finally:
        board.stop_stream()
    delay = effective_delay(taken[_SETTLING:], 1.0 / board.rate)
    if delay is None:
        raise NoDataError(
            f"No force reached {board.title} within {seconds:g} s. Check the USB cable, then try again."
        )
    return delay


def _answered(board: HapkitBoard, seconds: float) -> list[Sample]:
    """Answer the newest sample of every chunk, like the loop, for ``seconds`` of board time."""
    decoder, taken = Decoder(), deque[Sample]()
    quiet = max(_QUIET_SECONDS, board.patience)
    silent, end = time.monotonic() + quiet, time.monotonic() + _SLOWEST * seconds + quiet
    while time.monotonic() < min(silent, end):
        new = [m for m in decoder.feed(_read(board)) if isinstance(m, Sample)]
        if not new:
            continue
        board.send_messages(Force(new[-1].seq, 0, 0.0))
        taken += new
        silent = time.monotonic() + quiet
        if len(taken) >= seconds * board.rate:
            break
    return list(taken)


def _read(board: HapkitBoard) -> bytes:
    try:
        return board.read(0.05)
    except OSError as error:
        raise DeviceError(f"{board.title} is disconnected.") from error


def effective_delay(samples: Iterable[Sample], period: float) -> float | None:
    """Return the delay in s of the force in effect, for samples ``period`` s apart; None without a force."""
    found, before = delays.new_delays(), None
    for sample in samples:
        follows = before is not None and (sample.seq - before) & 0xFFFF == 1
        late = 1e-6 * sample.delay_us
        delays.note_force_age(found, sample.seq, sample.answered, late, period, follows)
        before = sample.seq
    measured = delays.measured_delay(found, delays.OF_COMPUTER)
    return measured.mean if measured else None
