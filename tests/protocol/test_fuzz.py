"""A small, fixed part of `make fuzz`: nothing crashes, decoders agree, the CRC errs as often as expected."""

import shutil

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hapkit_studio.protocol.framing import DELIMITER, encode, frame
from tests.protocol import fuzz
from tests.protocol.strategies import any_message, bodies

pytestmark = pytest.mark.skipif(shutil.which("g++") is None, reason="no g++")
INPUTS, FRAMES, NOISE = 80_000, 8_000, 2_000_000


@pytest.fixture(scope="module")
def folder():
    return fuzz.build("decoder")


@pytest.mark.slow
def test_firmware_and_machine_survive_fuzzing():
    folder = fuzz.build("firmware", "machine")
    fuzz.firmware(INPUTS, 1, folder)
    fuzz.machine(INPUTS, 1, folder)


@pytest.mark.slow
def test_decoders_agree_and_the_crc_misses_damage_at_its_theoretical_rate(folder):
    lines = fuzz.agreement(FRAMES, 1, folder)
    assert lines.damaged > FRAMES // 2
    assert lines.false <= fuzz.at_most(lines.damaged)


pieces = st.one_of(
    any_message.map(encode), bodies.map(frame), st.binary(max_size=100), st.just(b"\x41" * 300)
)


@pytest.mark.slow
@settings(max_examples=100)
@given(parts=st.lists(pieces, max_size=12))
def test_decoders_agree_on_hypothesis_inputs(folder, parts):
    fuzz.Three(folder).check(b"".join(parts) + DELIMITER)


@pytest.mark.slow
def test_noise_passes_at_the_crcs_rate(folder):
    """The rate is 2^-16 of the frames; a much lower rate would mean that the noise is not random."""
    assert fuzz.at_least(NOISE) <= fuzz.noise(NOISE, 1, folder) <= fuzz.at_most(NOISE)
