"""Every kit works with the real firmware: pins, direction, commanded force, and sensor counts."""

import os

import numpy as np
import pytest

from hapkit_studio.devices import profiles
from hapkit_studio.errors import ParameterError
from hapkit_studio.protocol.framing import encode
from hapkit_studio.protocol.messages import BoardFlag, MotorMap, Pins, Sensor
from tests.firmware import kits
from tests.firmware.vb import LONGEST_INTERRUPT, exchange, needs_board, opened, rows_of, session

pytestmark = needs_board

AMPLITUDE = 2.8
"""Amplitude of the commands in N, slightly below the usual kit's limit."""
POWER = {MotorMap.SQUARE: 2.0, MotorMap.LINEAR: 1.0, MotorMap.TABLE: 1.5}
"""Exponents of torque over duty of the motors in these tests."""
TABLE = tuple(round(255 * (k / 8) ** 1.5) for k in range(1, 9))
HALF = 0.53
"""Permitted error in duty steps: half a step, plus the firmware's rounding."""
START = 0.1
LATENCY = 5e-6
"""Distance in m that a handle at 1 m/s moves during the latency of the encoder's interrupt."""
SHAKE = ((0.040, 2.0, 0.5), (0.030, 5.0, 0.2), (0.010, 12.0, 0.25))
"""Amplitude in m, frequency in Hz and duration in s of three sines.

The peak speed of the second is 0.94 m/s, the peak acceleration of the third is 57 m/s².
"""


def wave(sample):
    """Return the force to send after a sample; over time, forces of both signs and all sizes occur."""
    return AMPLITUDE * np.sin(0.09 * sample.seq)


def play(folder, kit, seconds, law, script, **more):
    """Run a board with this kit; return samples, truth log and counters."""
    memory = folder / "eeprom"
    memory.write_bytes(kits.eeprom(kit))
    samples, log, summary = session(folder, seconds, law, script, options=kits.options(kit, memory, **more))
    assert summary["interrupts_off_cycles"] <= LONGEST_INTERRUPT
    assert summary["spi_hasty"] == summary["overruns"] == 0
    return samples, log, summary


# --- the motors
def drive(folder, kit, **more):
    """Command the wave; return the commanded forces (n,) and the resulting rows of the truth log."""
    samples, log, _ = play(folder, kit, 0.16, wave, ("0 position 0",), **more)
    rows = rows_of(samples, log)
    first = samples[0].seq
    answered = [k for k, s in enumerate(samples) if s.delay_us and s.answered >= first]
    asked = np.array([wave(samples[samples[k].answered - first]) for k in answered])
    assert len(asked) > 100
    return asked, rows[answered]


def force_at(kit, steps):
    """Return the force in N at ``steps`` (n,) of duty above the dead band.

    Between the points of a table the force is linear.
    """
    share = np.clip(steps / (255.0 - kit.dead_band), 0.0, 1.0)
    if kit.motor_map != MotorMap.TABLE:
        return profiles.full_force(kit) * share ** POWER[kit.motor_map]
    return profiles.full_force(kit) * np.interp(share, np.arange(9) / 8, np.array([0, *kit.table]) / 255.0)


def assert_nearest_step(kit, asked, rows):
    """Assert that the duty is the nearest step: half a step less is too little force, half more too much."""
    duty = np.abs(rows.duty)
    steps = np.where(duty > 0, duty - kit.dead_band, 0)
    wanted = np.minimum(np.abs(asked), min(kit.max_force, profiles.full_force(kit)))
    assert np.all((duty == 0) | (duty > kit.dead_band))
    assert np.all(np.sign(rows.duty[duty > 0]) == np.sign(asked[duty > 0]))
    assert np.all(force_at(kit, steps - HALF) <= wanted + 1e-4)
    assert np.all(wanted <= force_at(kit, steps + HALF) + 1e-4)


@pytest.mark.parametrize(
    ("pins", "sensor", "direction"),
    [
        (Pins.D5_D8, Sensor.MAGNETORESISTIVE, -1),
        (Pins.D5_D8, Sensor.AS5048A, 1),
        (Pins.D5_D8, Sensor.QUADRATURE, -1),
        (Pins.D3_D12, Sensor.MAGNETORESISTIVE, 1),
        (Pins.D3_D12, Sensor.MAGNETORESISTIVE, -1),
    ],
)
def test_every_wiring_gives_the_commanded_force(tmp_path, pins, sensor, direction):
    kit = kits.board(pins=pins, sensor=sensor, direction=direction)
    asked, rows = drive(tmp_path, kit)
    assert_nearest_step(kit, asked, rows)
    step = np.gradient(force_at(kit, np.arange(256.0)))[np.abs(rows.duty).astype(int)]
    assert np.all(np.abs(rows.motor_force - asked) <= 0.5 * step * 1.05 + 1e-4)
    assert rows.motor_force.max() > 2.7
    assert rows.motor_force.min() < -2.7


@pytest.mark.parametrize("dead_band", [0, 25])
@pytest.mark.parametrize("motor_map", MotorMap)
def test_every_motor_gives_the_commanded_force(tmp_path, motor_map, dead_band):
    kit = kits.board(motor_map=motor_map, dead_band=dead_band, table=TABLE, motor_constant=0.0217)
    asked, rows = drive(tmp_path, kit, **{"motor-power": POWER[motor_map]})
    assert_nearest_step(kit, asked, rows)
    # the chords of the table differ from this motor's torque by less than 2 % of the largest torque
    bend = 0.02 * profiles.full_force(kit) if motor_map == MotorMap.TABLE else 0.0
    steps = np.abs(rows.duty) - dead_band
    step = force_at(kit, steps + 1.0) - force_at(kit, steps)
    assert np.all(np.abs(rows.motor_force - asked) <= step + bend + 1e-4)


@pytest.mark.parametrize(("pins", "wired"), [(Pins.D5_D8, 3), (Pins.D3_D12, 5)])
def test_a_motor_on_other_pins_stays_off(tmp_path, pins, wired):
    _, log, _ = play(tmp_path, kits.board(pins=pins), 0.1, wave, (), pins=wired)
    assert len(log) > 100
    assert not log.duty.any()


def test_new_settings_switch_the_motor_off_and_apply_at_once_and_invalid_ones_are_ignored():
    def push():
        exchange(board.fileno(), 0.02, lambda s: 1.0)
        return board.status()

    with opened() as board:
        board.start_stream()
        assert push()["motor_force"] > 0.9
        board.stop_stream()
        before = board.configure(kits.board(direction=-1))
        assert board.status()["duty"] == 0
        for wrong in (
            kits.board(pins=Pins.D3_D12, sensor=Sensor.AS5048A),
            kits.board(max_force=5.05),
            kits.board(motor_constant=float("nan")),
            kits.board(table=(32, 64, 96, 95, 159, 191, 223, 255)),
        ):
            with pytest.raises(ParameterError):
                board.configure(wrong)
            assert board.settings().pack()[:-1] == before.pack()[:-1]
        board.start_stream()
        assert push()["motor_force"] < -0.9  # the virtual board's wiring has not changed
        os.write(board.fileno(), encode(kits.board(pins=Pins.D3_D12)))
        assert push()["duty"] == 0


# --- the sensors
def follow(folder, kit, pieces=SHAKE, seconds=1.1, **more):
    """Move the handle; return samples, their rows of the truth log, and the counters."""
    samples, log, summary = play(folder, kit, seconds, lambda s: 0.0, kits.motion(START, pieces), **more)
    return samples, rows_of(samples, log), summary


def error(kit, samples, rows):
    """Return the absolute errors (n,) in counts of the motion since the first sample."""
    counts = np.array([s.count for s in samples])
    return np.abs(counts - counts[0] - (rows.position - rows.position[0]) / kit.quantum)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("sensor", "counts", "sense"),
    [
        (Sensor.MAGNETORESISTIVE, 921, 1),
        (Sensor.MAGNETORESISTIVE, 873, -1),
        (Sensor.AS5048A, 16384, 1),
        (Sensor.QUADRATURE, 48, 1),
        (Sensor.QUADRATURE, 1024, -1),
    ],
)
def test_counts_are_within_one_of_the_handles_motion_and_raw_readings_are_sent(
    tmp_path, sensor, counts, sense
):
    kit = kits.board(sensor=sensor, counts_per_flip=counts, sense=sense)
    samples, rows, _ = follow(tmp_path, kit)
    assert np.ptp(rows.position) == pytest.approx(0.08, rel=1e-3)
    assert np.abs(np.diff(rows.position)).max() > 0.9e-3
    late = LATENCY / kit.quantum if sensor == Sensor.QUADRATURE else 1e-6
    assert error(kit, samples, rows).max() <= 1.0 + late
    assert not any(s.flags & BoardFlag.SENSOR for s in samples)
    moved = np.array([s.raw for s in samples], np.uint16) - rows.converter.astype(np.int16).view(np.uint16)
    assert np.ptp(moved.view(np.int16)) <= (1 + late if sensor == Sensor.QUADRATURE else 0)


def test_bit_errors_on_the_bus_never_reach_the_position(tmp_path):
    kit = kits.board(sensor=Sensor.AS5048A)
    samples, rows, summary = follow(tmp_path, kit, **{"spi-flip": 0.02, "seed": 3})
    assert summary["spi_turned"] > 20
    step = np.abs(np.diff(rows.position)).max() / kit.quantum
    worst = error(kit, samples, rows)
    assert worst.max() <= 3.0 * step  # a bit error may also spoil the next two readings
    flagged = np.array([bool(s.flags & BoardFlag.SENSOR) for s in samples])
    assert np.all(worst[~flagged] <= 1.0 + 1e-6)
    assert 0.01 < flagged.mean() < 0.15
