"""The firmware as the Arduino IDE builds it, which knows nothing of the Makefile: it fits, talks, renders."""

import subprocess

import numpy as np
import pytest

from hapkit_studio import environments
from hapkit_studio.devices.virtual_board import VirtualBoard
from hapkit_studio.laws.machine import ARENA
from tests.firmware import sketches
from tests.firmware.board_runs import program, render
from tests.firmware.test_firmware import FREE, SKETCH, stack_counted
from tests.firmware.vb import QUANTUM

pytestmark = sketches.needs_ide

FLASH, RAM = 24000, 2048
AT_ZERO = ("--magnet", str(921 - 51))
"""The magnet sits so that the sensor begins anew at the handle's zero."""
STIFFNESS, WALL = 400.0, 0.004
TO_AND_FRO = [f"{k * 0.1:.1f} position {0.009 if k % 2 else -0.01} 0.08" for k in range(200)]
"""Whenever the scene begins, 0.25 s later both sides of the wall have been seen."""
FADED_IN = 0.05


@pytest.fixture(scope="module")
def elf(archive, tmp_path_factory):
    return sketches.build_folder(SKETCH, archive, tmp_path_factory.mktemp("ide"))


@pytest.mark.slow
def test_it_fits_the_chip(elf):
    said = subprocess.run(["avr-size", "-A", elf], capture_output=True, text=True, check=True).stdout
    size = {line.split()[0]: int(line.split()[1]) for line in said.splitlines() if line.startswith(".")}
    assert 10_000 < size[".text"] + size[".data"] <= FLASH
    assert ARENA < size[".data"] + size[".bss"] + size[".noinit"] <= RAM - stack_counted() - FREE


def test_it_says_who_it_is_and_leaves_nothing_out(elf):
    board = VirtualBoard("lockstep", firmware=elf)
    board.open()
    try:
        assert board.hello.build == "arduino-ide"
        assert board.hello.arena == ARENA
    finally:
        board.close()


def test_its_wall_pushes_as_a_wall(elf, tmp_path):
    """400 N/m from 4 mm on, nothing before: the force in effect answers the reading before."""
    values = environments.named("wall").values({"stiffness": STIFFNESS, "position": WALL})
    law = program(environments.named("wall"), values, 4000, ARENA)
    run = render(tmp_path, law, 4000, 0.45, TO_AND_FRO, options=AT_ZERO, firmware=elf)
    began, ended = (run.telemetry[k].time_us * 1e-6 for k in (0, -1))
    rows = run.truth[(run.truth.time > began + FADED_IN) & (run.truth.time < ended)]
    wanted = np.minimum(0.0, -STIFFNESS * (rows.position - WALL))[:-1]
    error = np.abs(rows.motor_force[1:] - wanted)
    assert wanted.min() < -1.9
    assert np.mean(wanted == 0.0) > 0.3
    assert np.all(error <= sketches.pwm_step(rows.duty[1:]) + 1.01 * STIFFNESS * QUANTUM)
    assert run.skipped == 0
