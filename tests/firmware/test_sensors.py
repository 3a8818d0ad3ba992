"""Every sensor through the real firmware: counts against where the handle is, and what goes wrong with it."""

import numpy as np
import pytest

from hapkit_studio.protocol.messages import BoardFlag, Sensor
from tests.firmware import kits
from tests.firmware.vb import needs_board
from tests.firmware.vb_host import rows_of, session

pytestmark = needs_board

START = 0.1
LATENCY = 5e-6
"""m that a handle at 1 m/s moves from an edge of the encoder to the end of its interrupt."""
SHAKE = ((0.040, 2.0, 0.5), (0.030, 5.0, 0.2), (0.010, 12.0, 0.25))
"""40 mm at 2 Hz, then 0.94 m/s, then 57 m/s^2."""


def follow(folder, kit, pieces=SHAKE, seconds=1.1, **more):
    """Move the handle; return samples, their rows of the truth log, and the counters."""
    memory = folder / "eeprom"
    memory.write_bytes(kits.eeprom(kit))
    script = kits.motion(START, pieces)
    options = kits.options(kit, memory, **more)
    samples, log, summary = session(folder, seconds, lambda s: 0.0, script, options=options)
    return samples, rows_of(samples, log), summary


def error(kit, samples, rows):
    """Return the counts (n,) less those that the handle has moved since the first sample."""
    counts = np.array([s.count for s in samples])
    return counts - counts[0] - (rows.position - rows.position[0]) / kit.quantum


@pytest.mark.parametrize(
    ("sensor", "counts", "sense"),
    [
        (Sensor.MAGNETORESISTIVE, 921, 1),
        (Sensor.MAGNETORESISTIVE, 873, -1),
        (Sensor.AS5048A, 16384, 1),
        (Sensor.AS5048A, 16384, -1),
        (Sensor.QUADRATURE, 48, 1),
        (Sensor.QUADRATURE, 1024, -1),
    ],
)
def test_counts_follow_the_handle_within_one(tmp_path, sensor, counts, sense):
    kit = kits.board(sensor=sensor, counts_per_flip=counts, sense=sense)
    samples, rows, summary = follow(tmp_path, kit)
    assert np.ptp(rows.position) == pytest.approx(0.08, rel=1e-3)
    assert np.abs(np.diff(rows.position)).max() > 0.9e-3
    late = LATENCY / kit.quantum if sensor == Sensor.QUADRATURE else 1e-6
    assert np.abs(error(kit, samples, rows)).max() <= 1.0 + late
    assert not any(s.flags & BoardFlag.SENSOR for s in samples)
    assert summary["interrupts_off_cycles"] <= 250
    assert summary["spi_hasty"] == 0
    assert summary["overruns"] == 0


@pytest.mark.parametrize("sensor", [Sensor.MAGNETORESISTIVE, Sensor.AS5048A])
@pytest.mark.parametrize("position", [-0.0090, 0.0090])
def test_after_a_start_the_zero_is_its_nearest_repeat(tmp_path, sensor, position):
    kit = kits.board(sensor=sensor, zero=kits.COUNTS[sensor] * 7 + 400)
    # at position 0 the sensor reads its zero: 349 counts above where it begins, 51
    magnet = 349 if sensor == Sensor.MAGNETORESISTIVE else 400
    samples, rows, _ = follow(tmp_path, kit, (), 0.02, position=position, magnet=magnet)
    assert rows.position[0] == position
    assert samples[-1].count == pytest.approx(position / kit.quantum, abs=1.0)


def test_an_encoder_begins_at_zero_wherever_it_stands(tmp_path):
    kit = kits.board(sensor=Sensor.QUADRATURE, zero=12345)
    samples, *_ = follow(tmp_path, kit, (), 0.02, position=0.03)
    assert {s.count for s in samples} == {0}


def test_readings_are_handed_on_as_they_are(tmp_path):
    for sensor in Sensor:
        folder = tmp_path / sensor.name
        folder.mkdir()
        samples, rows, _ = follow(folder, kits.board(sensor=sensor), SHAKE[1:2], 0.3)
        moved = np.array([s.raw for s in samples], np.uint16) - rows.converter.astype(np.int16).view(
            np.uint16
        )
        assert np.ptp(moved.view(np.int16)) <= (1 if sensor == Sensor.QUADRATURE else 0)


# --- what goes wrong
def test_bits_turned_on_the_bus_never_reach_the_position(tmp_path):
    kit = kits.board(sensor=Sensor.AS5048A)
    more = {"spi-flip": 0.02, "seed": 3}
    samples, rows, summary = follow(tmp_path, kit, **more)
    assert summary["spi_turned"] > 20
    step = np.abs(np.diff(rows.position)).max() / kit.quantum
    worst = np.abs(error(kit, samples, rows))
    assert worst.max() <= 3.0 * step  # an error bit costs up to two readings more
    flagged = np.array([bool(s.flags & BoardFlag.SENSOR) for s in samples])
    assert np.all(worst[~flagged] <= 1.0 + 1e-6)
    assert 0.01 < flagged.mean() < 0.15


def test_a_sensor_that_is_not_there_is_told(tmp_path):
    kit = kits.board(sensor=Sensor.AS5048A)
    samples, *_ = follow(tmp_path, kit, (), 0.1, **{"sensor-absent": 1})
    assert all(s.flags & BoardFlag.SENSOR for s in samples[1:])
    assert {s.count for s in samples} == {0}


def test_readings_half_a_turn_off_are_bridged(tmp_path):
    kit = kits.board()
    samples, rows, summary = follow(tmp_path, kit, **{"sensor-jump": 0.01, "seed": 5})
    assert summary["misread"] > 5
    # what is not far off cannot be told from a handle that speeds up, by an eighth of the range at most
    assert np.abs(error(kit, samples, rows)).max() <= 921 / 8 + 5.0
    assert np.abs(error(kit, samples, rows)[-5:]).max() <= 1.0 + 1e-6
    assert any(s.flags & BoardFlag.SENSOR for s in samples)
