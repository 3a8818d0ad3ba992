"""Every kit through the real firmware: the right pins, the right direction, the force that was asked for."""

import os

import numpy as np
import pytest

from hapkit_studio.devices import profiles
from hapkit_studio.devices.virtual_board import VirtualBoard
from hapkit_studio.errors import ParameterError
from hapkit_studio.protocol.framing import encode
from hapkit_studio.protocol.messages import MotorMap, Pins, Sensor
from tests.firmware import kits
from tests.firmware.vb import chip, needs_board, needs_compiler, run
from tests.firmware.vb_host import exchange, rows_of, session

pytestmark = needs_board

AMPLITUDE = 2.8
"""N, a little less than the usual kit's limit."""
POWER = {MotorMap.SQUARE: 2.0, MotorMap.LINEAR: 1.0, MotorMap.TABLE: 1.5}
"""With which the torque of the test's motors grows with the duty."""
TABLE = tuple(round(255 * (k / 8) ** 1.5) for k in range(1, 9))
HALF = 0.53
"""Half a step of the duty, and what the firmware's whole numbers leave out."""


def wave(sample):
    """Ask for forces of both signs and all sizes."""
    return AMPLITUDE * np.sin(0.09 * sample.seq)


def drive(folder, kit, seconds=0.16, **more):
    """Ask for the wave; return what was asked (n,) and the rows of the truth log with what came of it."""
    memory = folder / "eeprom"
    memory.write_bytes(kits.eeprom(kit))
    script = ("0 position 0",)  # held still
    samples, log, summary = session(folder, seconds, wave, script, options=kits.options(kit, memory, **more))
    rows = rows_of(samples, log)
    first = samples[0].seq
    answered = [k for k, s in enumerate(samples) if s.delay_us and s.answered >= first]
    asked = np.array([wave(samples[samples[k].answered - first]) for k in answered])
    assert len(asked) > 100
    assert summary["interrupts_off_cycles"] <= 250
    return asked, rows[answered]


def force_at(kit, steps):
    """Return the force in N of steps (n,) of duty above the dead band, straight between a table's points."""
    share = np.clip(steps / (255.0 - kit.dead_band), 0.0, 1.0)
    if kit.motor_map != MotorMap.TABLE:
        return profiles.full_force(kit) * share ** POWER[kit.motor_map]
    return profiles.full_force(kit) * np.interp(share, np.arange(9) / 8, np.array([0, *kit.table]) / 255.0)


def assert_nearest_step(kit, asked, rows):
    """The duty is the nearest step: half a step less is too little, half a step more too much."""
    duty = np.abs(rows.duty)
    steps = np.where(duty > 0, duty - kit.dead_band, 0)
    wanted = np.minimum(np.abs(asked), kit.max_force)
    wanted = np.minimum(wanted, profiles.full_force(kit))
    assert np.all((duty == 0) | (duty > kit.dead_band))
    assert np.all(np.sign(rows.duty[duty > 0]) == np.sign(asked[duty > 0]))
    assert np.all(force_at(kit, steps - HALF) <= wanted + 1e-4)
    assert np.all(wanted <= force_at(kit, steps + HALF) + 1e-4)


@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize(
    ("pins", "sensor"),
    [
        (Pins.D5_D8, Sensor.MAGNETORESISTIVE),
        (Pins.D5_D8, Sensor.AS5048A),
        (Pins.D5_D8, Sensor.QUADRATURE),
        (Pins.D3_D12, Sensor.MAGNETORESISTIVE),
    ],
)
def test_every_wiring_gives_the_force_that_was_asked_for(tmp_path, pins, sensor, direction):
    kit = kits.board(pins=pins, sensor=sensor, direction=direction)
    asked, rows = drive(tmp_path, kit)
    assert_nearest_step(kit, asked, rows)
    step = np.gradient(force_at(kit, np.arange(256.0)))[np.abs(rows.duty).astype(int)]
    assert np.all(np.abs(rows.motor_force - asked) <= 0.5 * step * 1.05 + 1e-4)
    assert rows.motor_force.max() > 2.7
    assert rows.motor_force.min() < -2.7


@pytest.mark.parametrize("dead_band", [0, 25])
@pytest.mark.parametrize("motor_map", MotorMap)
def test_every_motor_gives_the_force_that_was_asked_for(tmp_path, motor_map, dead_band):
    kit = kits.board(motor_map=motor_map, dead_band=dead_band, table=TABLE, motor_constant=0.0217)
    asked, rows = drive(tmp_path, kit, **{"motor-power": POWER[motor_map]})
    assert_nearest_step(kit, asked, rows)
    # of the table's straight pieces, the torque of this motor leaves itself less than 2 % of the largest
    bend = 0.02 * profiles.full_force(kit) if motor_map == MotorMap.TABLE else 0.0
    steps = np.abs(rows.duty) - dead_band
    step = force_at(kit, steps + 1.0) - force_at(kit, steps)
    assert np.all(np.abs(rows.motor_force - asked) <= step + bend + 1e-4)


def test_the_force_limit_is_the_settings_own(tmp_path):
    kit = kits.board(max_force=1.25)
    _, rows = drive(tmp_path, kit)
    assert np.abs(rows.motor_force).max() == pytest.approx(1.25, abs=0.5 * 1.25 / 80)


@pytest.mark.parametrize(("kit", "wired"), [(0, 3), (1, 5)], ids=["D5 for D3", "D3 for D5"])
def test_a_motor_on_the_other_pins_stays_off(tmp_path, kit, wired):
    settings = kits.board(pins=Pins(kit))
    memory = tmp_path / "eeprom"
    memory.write_bytes(kits.eeprom(settings))
    options = (*kits.options(settings, memory), "--pins", str(wired))
    _, log, _ = session(tmp_path, 0.1, wave, options=options)
    assert len(log) > 100
    assert not log.duty.any()


@needs_compiler
@pytest.mark.parametrize(("a", "b"), [(0x23, 0x01), (0x21, 0x04)], ids=["fast PWM", "prescaler 64"])
def test_an_unknown_mode_of_timer_2_ends_the_virtual_board_loudly(tmp_path, a, b):
    elf = chip("mode2", tmp_path, CONTROL_A=a, CONTROL_B=b)
    outcome = run(elf, tmp_path, "--seconds", "0.1", "--pins", "3")
    assert outcome.code == 3
    assert f"D3 is driven by timer 2 in a mode that is not modelled: TCCR2A = 0x{a:02x}" in outcome.errors
    assert run(elf, tmp_path, "--seconds", "0.1").code == 0  # on D5 nobody minds


def test_new_settings_switch_the_motor_off_and_hold_at_once(tmp_path):
    board = VirtualBoard("lockstep", log=tmp_path / "truth.f64")
    board.open()
    try:
        board.start_stream()
        exchange(board.fileno(), 0.02, lambda s: 1.0)
        assert board.status()["motor_force"] > 0.9
        board.stop_stream()
        board.configure(kits.board(direction=-1))
        assert board.status()["duty"] == 0
        board.start_stream()
        exchange(board.fileno(), 0.02, lambda s: 1.0)
        assert board.status()["motor_force"] < -0.9  # the virtual board's wiring has not changed
        os.write(board.fileno(), encode(kits.board(pins=Pins.D3_D12)))
        exchange(board.fileno(), 0.02, lambda s: 1.0)
        assert board.status()["duty"] == 0
    finally:
        board.close()


def test_settings_that_no_kit_has_change_nothing(tmp_path):
    board = VirtualBoard("lockstep")
    board.open()
    try:
        before = board.settings()
        for wrong in (
            kits.board(pins=Pins.D3_D12, sensor=Sensor.AS5048A),
            kits.board(max_force=5.05),
            kits.board(motor_constant=float("nan")),
            kits.board(table=(32, 64, 96, 95, 159, 191, 223, 255)),
        ):
            with pytest.raises(ParameterError):
                board.configure(wrong)
            assert board.settings().origin == before.origin
        again = board.settings()
        assert again.pack()[:-1] == before.pack()[:-1]
    finally:
        board.close()
