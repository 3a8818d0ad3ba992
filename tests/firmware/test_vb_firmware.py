"""The firmware in the virtual board measures, drives the motor, exchanges messages, and shuts down."""

import itertools
import os

import numpy as np
import pytest

from hapkit_studio.devices.flash import shipped
from hapkit_studio.devices.virtual_board import firmware
from hapkit_studio.protocol.framing import DELIMITER, Decoder, encode
from hapkit_studio.protocol.messages import (
    BoardFlag,
    Force,
    Hello,
    HelloRequest,
    Sample,
    Settings,
    SettingsRequest,
    Stream,
)
from tests.firmware.vb import (
    LONGEST_INTERRUPT,
    QUANTUM,
    duty_step,
    heard,
    needs_board,
    opened,
    rows_of,
    session,
)

pytestmark = needs_board

SWEEP = ("0.1 position -0.05 0.25", "0.4 position 0.05 0.5", "1.0 position 0 0.04")
PUSH = ("0.1 hand 0.015 400 8 0.1 0.2", "0.6 hand -0.01 400 8 0.1 0.3")
QUESTIONS = (HelloRequest(), SettingsRequest())


def quiet(sample):
    return 0.0


def test_counts_follow_the_sensors_saw_tooth(tmp_path):
    samples, log, _ = session(tmp_path, 1.05, quiet, SWEEP)
    rows = rows_of(samples, log)
    counts = np.array([s.count for s in samples])
    assert np.ptp(rows.position) == pytest.approx(0.1)
    # a jump of more than 460 converter steps means that the sensor's saw-tooth signal has wrapped
    assert np.count_nonzero(np.abs(np.diff(rows.converter)) > 460) >= 9
    moved = np.round(rows.position / QUANTUM - (counts - counts[0]), 6)
    assert np.ptp(moved) <= 1.0 + 1e-6
    tooth = 51 + np.floor(np.mod(log.position / QUANTUM + 300, 921))  # the magnet starts at 300 counts
    sure = np.abs(np.mod(log.position / QUANTUM, 1.0) - 0.5) < 0.499999
    np.testing.assert_array_equal(log.converter[sure], tooth[sure])
    assert 51 <= log.converter.min() < 60
    assert 960 < log.converter.max() <= 972


@pytest.mark.slow
@pytest.mark.parametrize("image", [firmware(), shipped()], ids=["built", "shipped"])
def test_motor_force_equals_the_laws_within_a_count_and_a_step(tmp_path, image):
    stiffness, forces, start = 120.0, {}, []

    def spring(sample):
        start.append(sample.count)
        forces[sample.seq] = -stiffness * QUANTUM * (sample.count - start[0])
        return forces[sample.seq]

    samples, log, summary = session(tmp_path, 1.2, spring, PUSH, firmware=image)
    rows = rows_of(samples, log)
    answered = [k for k in range(1, len(samples)) if samples[k].answered in forces and samples[k].delay_us]
    assert len(answered) > 1100
    found = rows.motor_force[answered]
    wanted = np.array([forces[samples[k].answered] for k in answered])
    assert np.abs(wanted).max() > 1.0
    step = duty_step(rows.duty[answered])
    assert np.all(np.abs(found - wanted) <= step)
    before = rows.position[[samples[k].answered - samples[0].seq for k in answered]] - rows.position[0]
    assert np.all(np.abs(found + stiffness * before) <= step + stiffness * QUANTUM)
    assert [s.pwm for s in samples] == rows.duty.astype(int).tolist()
    # every reply takes effect before the next sample
    assert all(s.answered == s.seq - 1 for s in samples[1:])
    assert max(s.delay_us for s in samples[1:]) < 1000
    assert summary["overruns"] == summary["deaf"] == summary["unanswered"] == 0
    assert summary["dropped"] == summary["overwritten"] == 0
    assert 0 < summary["interrupts_off_cycles"] <= LONGEST_INTERRUPT


def test_lockstep_runs_are_identical_bit_by_bit(tmp_path):
    logs, streams = [], []
    for name in ("one", "two"):
        folder = tmp_path / name
        folder.mkdir()
        samples, _, _ = session(folder, 0.4, lambda s: 0.002 * (400 - s.count), PUSH)
        streams.append(samples)
        logs.append((folder / "truth.f64").read_bytes()[: 64 * 400])
    assert streams[0] == streams[1]
    assert logs[0] == logs[1]
    assert np.ptp(np.frombuffer(logs[0])) > 0.0


# --- the messages
@pytest.mark.parametrize("padded", [0, 62])
def test_requests_during_streaming_are_answered_and_losses_reported(padded):
    decoder, seen = Decoder(), []
    with opened() as board:
        os.write(board.fileno(), encode(Stream(1, padded)))
        while len(seen) < 200:
            new = heard(board.fileno(), decoder)
            seen += new
            for sample in (m for m in new if isinstance(m, Sample)):
                ask = QUESTIONS if sample.seq % 20 == 0 else ()
                os.write(board.fileno(), b"".join(map(encode, (Force(sample.seq, 0, 0.0), *ask))))
    samples = [m for m in seen if isinstance(m, Sample)]
    asked = sum(s.seq % 20 == 0 for s in samples[:-10])
    for kind in (Hello, Settings):
        assert sum(isinstance(m, kind) for m in seen) >= asked > 3
    gaps = [(b.seq - a.seq) & 0xFFFF for a, b in itertools.pairwise(samples)]
    for gap, sample in zip(gaps, samples[1:], strict=True):
        assert gap == 1 or sample.flags & BoardFlag.OVERRUN
        assert gap <= 4  # the two replies have 200 bytes with padding, which take 2.2 ms on the line
    assert decoder.bad_frames == 0
    assert board.summary["overwritten"] == board.summary["dropped"] == board.summary["unanswered"] == 0


def test_in_lockstep_a_lone_delimiter_is_an_answer_that_does_not_reach_the_chip():
    decoder, seen = Decoder(), 0
    with opened() as board:
        board.start_stream()
        while seen < 300:
            new = sum(isinstance(m, Sample) for m in heard(board.fileno(), decoder))
            os.write(board.fileno(), DELIMITER * new)
            seen += new
    assert board.summary["unanswered"] == 0
    # the board receives messages only when the port is opened and closed; some of them are repeated
    assert 0 < board.summary["received"] < 300
