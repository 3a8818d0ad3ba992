"""Named kits: complete, different, within what a board takes, and as the reference says."""

import math
import re
from pathlib import Path

import pytest

from hapkit_studio.devices import profiles
from hapkit_studio.errors import ParameterError
from hapkit_studio.protocol.messages import Board, MotorMap, Sensor

HEADER = Path(__file__).resolve().parents[2] / "firmware" / "hapkit" / "profile.h"


def constant(name: str) -> float:
    """Return one number of the firmware's own profile."""
    found = re.search(rf"\b{name} = ([0-9.]+)", HEADER.read_text())
    assert found, name
    return float(found[1])


def test_keys_numbers_and_labels_differ():
    for of in (lambda k: k.key, lambda k: k.board.profile, lambda k: k.board.label, lambda k: k.title):
        assert len({of(kit) for kit in profiles.KITS}) == len(profiles.KITS)


@pytest.mark.parametrize("kit", profiles.KITS, ids=lambda kit: kit.key)
def test_a_kit_can_travel_on_the_wire_and_is_plausible(kit):
    assert Board.unpack(kit.board.pack()).counts_per_flip == kit.board.counts_per_flip
    assert 1e-6 < kit.board.quantum < 1e-3
    assert kit.board.max_force <= profiles.full_force(kit.board)
    assert kit.note.endswith(".")


def test_the_default_is_the_firmwares_own():
    board = profiles.default().board
    for name, value in (
        ("kHandleRadius", board.handle_radius),
        ("kPulleyRadius", board.pulley_radius),
        ("kSectorRadius", board.sector_radius),
        ("kMotorConstant", board.motor_constant),
        ("kMaxForce", board.max_force),
        ("kCountsPerFlip", board.counts_per_flip),
    ):
        assert constant(name) == pytest.approx(value), name


def test_travel_per_count_and_full_force_are_those_of_the_reference():
    usual, short = profiles.named("hapkit3").board, profiles.named("hapkit3-short").board
    assert usual.quantum == pytest.approx(20.7e-6, rel=0.003)
    assert short.quantum == pytest.approx(16.1e-6, rel=0.003)
    assert profiles.full_force(usual) == pytest.approx(3.01, rel=0.002)
    assert profiles.full_force(short) == pytest.approx(3.87, rel=0.002)
    assert profiles.full_force(profiles.named("hapkit3-maxon").board) == pytest.approx(4.93, rel=0.002)
    assert profiles.full_force(profiles.named("hapkit2013").board) == pytest.approx(7.98, rel=0.002)
    assert profiles.named("hapkit2013").board.quantum == pytest.approx(12.8e-6, rel=0.005)


def test_a_sensor_that_repeats_every_turn_has_twice_the_travel_between_repeats():
    half = profiles.default().board
    whole = profiles.named("hapkit-hall").board
    assert whole.sensor == Sensor.AS5048A
    assert whole.quantum * 16384 == pytest.approx(2.0 * half.quantum * 921)
    encoder = profiles.named("hapkit-encoder").board
    assert encoder.motor_map == MotorMap.LINEAR
    assert encoder.quantum * 48 == pytest.approx(2.0 * math.pi * 0.090 * 0.005 / 0.075)


def test_an_unknown_kit_is_named_with_those_there_are():
    with pytest.raises(ParameterError, match=r"hapkit9.*hapkit3"):
        profiles.named("hapkit9")
    assert profiles.numbered(200) is None
