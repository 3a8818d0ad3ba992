"""The delay of a line from what the board says, against the age of the force as it really was."""

import numpy as np
import pytest

from hapkit_studio.devices.padding import effective_delay
from hapkit_studio.haptics import link
from hapkit_studio.protocol.framing import Decoder
from hapkit_studio.protocol.messages import Force, Stream
from tests.devices.ftdi_kit import PERIOD, FtdiKit
from tests.devices.test_padding import loop_with


def mean(samples):
    """Return what the loop's own measurement makes of samples."""
    kept, before = link.new_delays(), None
    for s in samples:
        follows = before is not None and (s.seq - before) & 0xFFFF == 1
        link.note_force_age(kept, s.seq, s.answered, 1e-6 * s.delay_us, PERIOD, follows)
        before = s.seq
    found = link.measured_delay(kept, link.OF_COMPUTER)
    return found.mean if found else None


@pytest.mark.parametrize("delay", [0.2, 1.0, 1.5, 3.25, 16.4, 60.0])
def test_a_loop_that_answers_every_sample(delay):
    assert mean(loop_with(delay)) == pytest.approx(delay * PERIOD, abs=1e-6)


@pytest.mark.parametrize("padded", [0, 62])
@pytest.mark.parametrize("latency", [0.001, 0.016])
def test_a_usb_chip_that_collects_samples(latency, padded):
    kit, decoder, taken = FtdiKit(latency), Decoder(), []
    data = kit(Stream(1, padded))
    while len(taken) < 400:
        new = decoder.feed(data)
        taken += new
        data = kit(Force(new[-1].seq, 0, 0.0))
    truth = np.mean(kit.ages[60:-20]) - PERIOD / 2
    assert mean(taken[60:]) == pytest.approx(truth, rel=0.02)
    assert mean(taken[60:]) == pytest.approx(effective_delay(taken[60:], PERIOD), rel=1e-9)


def test_what_is_only_known_to_be_long_is_not_measured():
    samples = loop_with(0.4, samples=50)
    gone = [s.__class__(**{**vars(s), "delay_us": 65535}) for s in samples]
    assert mean(gone) is None
    assert mean(gone + samples) == pytest.approx(0.4 * PERIOD, abs=1e-6)
