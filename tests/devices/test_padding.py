"""The measured delay through a USB chip equals the true delay, with plain and with padded frames."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from hapkit_studio import errors
from hapkit_studio.devices.hapkit import PACKET
from hapkit_studio.devices.padding import Padding, effective_delay, measure_padding
from hapkit_studio.protocol.framing import Decoder, encode
from hapkit_studio.protocol.messages import Force, Stream
from tests.devices.fake_board import FakeKit, sample
from tests.devices.ftdi_kit import PERIOD, FtdiKit
from tests.firmware.vb import needs_board
from tests.firmware.vb import opened as opened_board


def loop_with(delay, every=1, samples=400):
    """Return the samples of a loop that answers every n-th sample after a delay in periods."""
    arrivals = [(seq + delay, seq) for seq in range(0, samples, every)]
    out = []
    for k in range(samples):
        there = [(at, seq) for at, seq in arrivals if at <= k]
        at, seq = there[-1] if there else (0.0, 0)
        out.append(sample(k, answered=seq, delay_us=round(1e6 * PERIOD * (at - seq)) if there else 0))
    return out


@pytest.mark.parametrize("delay", [0.2, 0.999, 1.0, 3.25, 60.0])
def test_the_delay_of_a_loop_that_answers_every_sample_is_measured(delay):
    assert effective_delay(loop_with(delay), PERIOD) == pytest.approx(delay * PERIOD, abs=1e-6)


@pytest.mark.parametrize("every", [2, 5, 16])
def test_a_force_in_effect_for_longer_counts_with_its_age(every):
    """A force in effect for n periods instead of one has a mean age that is (n - 1)/2 periods higher."""
    samples = loop_with(0.4, every)[2 * every : 2 * every + 10 * every + 1]
    assert effective_delay(samples, PERIOD) == pytest.approx((0.4 + (every - 1) / 2) * PERIOD, abs=1e-6)


def test_sample_numbers_may_wrap_and_be_missing():
    late = [sample(65_500 + k, answered=(65_500 + k - 1) & 0xFFFF, delay_us=300) for k in range(80) if k % 10]
    assert effective_delay(late, PERIOD) == pytest.approx(0.3 * PERIOD, abs=1e-9)
    assert effective_delay([], PERIOD) is None
    assert effective_delay([sample(k) for k in range(9)], PERIOD) is None
    assert effective_delay([sample(k, delay_us=65535) for k in range(9)], PERIOD) is None


@pytest.mark.parametrize("padded", [0, PACKET])
@pytest.mark.parametrize("latency", [0.001, 0.016])
def test_the_delay_of_a_usb_chip_that_collects_samples_is_measured(latency, padded):
    kit, decoder, taken = FtdiKit(latency), Decoder(), []
    data = kit(Stream(1, padded))
    while len(taken) < 400:
        new = decoder.feed(data)
        taken += new
        data = kit(Force(new[-1].seq, 0, 0.0))
    truth = np.mean(kit.ages[60:-20]) - PERIOD / 2
    assert effective_delay(taken[60:], PERIOD) == pytest.approx(truth, rel=0.02)


def test_an_unsolicited_zero_force_does_not_count_as_delay():
    samples = loop_with(1.5, samples=50)
    samples[30] = replace(samples[30], answered=0, delay_us=29_500)
    assert effective_delay(samples, PERIOD) < 3.0 * PERIOD


@pytest.mark.parametrize("latency", [0.001, 0.016])
def test_padded_frames_reach_the_packets_minimum_delay(opened, latency):
    truths = []

    class Kit(FtdiKit):
        def _stream(self, message):
            kept = self.ages[
                60:-20
            ]  # the last force is a zero command that refers to sample 0, so its age is wrong
            truths.append(np.mean(kept) - PERIOD / 2 if kept else None)
            return super()._stream(message)

    board, peer = opened(Kit(latency))
    found = measure_padding(board, 0.4)
    board.settings()  # when the board answers this request, it has read everything before it
    plain, padded = [t for t in truths if t is not None]
    assert found.plain == pytest.approx(plain, rel=0.03)
    assert found.padded == pytest.approx(padded, rel=0.03)
    # the chip sends a padded frame when its last byte arrives, after 0.62 ms; then comes the turnaround
    assert found.padded == pytest.approx(62 * 10e-6 + 0.4e-3, rel=0.03)
    assert found.padded < found.plain
    assert found.better == PACKET
    sent = [m for m in peer.received if isinstance(m, Force)]
    assert len(sent) > 100
    assert {m.force for m in sent} == {0.0}
    assert [m for m in peer.received if isinstance(m, Stream)][-1] == Stream(0, 0)
    assert {m.padded for m in peer.received if isinstance(m, Stream) and m.on} == {0, PACKET}


def test_missing_samples_are_an_error_and_the_stream_is_off(opened):
    board, peer = opened(FakeKit())
    with pytest.raises(errors.NoDataError, match="No force"):
        measure_padding(board, 0.2)
    board.settings()
    assert [m for m in peer.received if isinstance(m, Stream)][-1] == Stream(0, 0)


def test_padding_must_be_worth_its_bytes():
    found = [Padding(*delays).better for delays in ((2.0e-3, 1.0e-3), (1.0e-3, 0.96e-3), (1.0e-3, 1.2e-3))]
    assert found == [PACKET, 0, 0]


# --- the firmware behind the virtual board's FTDI chip
BYTE = 10e-6
FILLING = BYTE / 10 + 6 / 16e6
"""Time in s of a padding byte in addition to its own bits.

There are two bit times of silence after every second byte, and the board's main program needs 6 cycles to
queue it.
"""
BUSY = 0.2e-3
"""Time in s that the board's main program needs to build and pad its next frame before it reads a reply."""
FRAME = len(encode(sample(1)))


@cache
def measured(latency):
    with opened_board(options=["--latency", str(latency)]) as board:
        return measure_padding(board, 0.4)


@needs_board
def test_padding_saves_the_latency_timers_delay():
    direct = measured(0.0)
    rest = direct.plain - FRAME * BYTE  # ``rest`` is everything except the frame's time on the wire
    behind = measured(0.016)
    # the padding of a frame completes its packet
    filling = (PACKET - FRAME) * FILLING
    arrival = PACKET * BYTE + filling + rest
    # the reply arrives before the board builds its next frame
    assert PERIOD < arrival < PERIOD + BUSY
    assert 0.98 * arrival < behind.padded < arrival + BUSY
    # A plain packet usually ends inside a frame, so the newest complete frame is a period older, and replies
    # come only every 62 / FRAME periods.
    age = PERIOD * (FRAME - 1) / FRAME + FRAME * BYTE / 2
    held = (PACKET / FRAME - 1) * PERIOD / 2
    assert behind.plain == pytest.approx(age + rest + held, rel=0.04)
    assert behind.better == PACKET
    assert direct.better == 0
