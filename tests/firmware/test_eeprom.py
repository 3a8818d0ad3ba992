"""Settings in the firmware's EEPROM survive restarts, damage, and power cuts during saving."""

import os
import select
import signal

import numpy as np
import pytest

from hapkit_studio.devices.profiles import of_settings
from hapkit_studio.devices.virtual_board import firmware
from hapkit_studio.protocol.framing import Decoder, encode
from hapkit_studio.protocol.messages import Alive, Origin, Pins, Save, Sensor, SettingsRequest
from tests.firmware import kits
from tests.firmware.vb import needs_board, opened, run
from tests.waiting import wait_until

pytestmark = needs_board

BLOCK = len(kits.block(kits.board()))


@pytest.fixture
def memory(tmp_path):
    return tmp_path / "eeprom"


def settings_after(memory, **options):
    """Return the settings of a board that is switched on with an EEPROM, then off."""
    args = [word for name, value in options.items() for word in (f"--{name}", str(value))]
    with opened("fast", options=("--eeprom", str(memory), *args)) as board:
        return board.settings()


def test_a_new_board_has_the_default_kit_and_writes_nothing(memory):
    settings = settings_after(memory)
    assert settings.origin == Origin.DEFAULT
    assert memory.read_bytes() == b"\xff" * kits.SIZE


def test_saved_settings_survive_a_kill_in_the_layout_of_this_test(memory):
    # these numbers are exact in single precision
    kit = kits.board(
        pins=Pins.D3_D12, zero=-321, sense=-1, max_force=1.5, motor_constant=0.03125, dead_band=7
    )
    with opened("fast", options=("--eeprom", str(memory))) as board:
        assert board.configure(kit).origin == Origin.UNSAVED
        stored = board.save()
        assert stored.origin == Origin.STORED
        saved = board.status()["time"]
        wait_until(lambda: board.status()["time"] > saved + 0.1)
        os.kill(board.pid, signal.SIGKILL)
    again = settings_after(memory)
    assert again == stored
    assert of_settings(again).pack() == kit.pack()
    assert memory.read_bytes()[kits.PLACES[0] :][:BLOCK] == kits.block(kit)


def test_a_block_written_by_this_test_is_read(memory):
    kit = kits.board(sensor=Sensor.AS5048A, label="elsewhere")
    for place in (0, 1):
        memory.write_bytes(kits.eeprom(kit, place))
        settings = settings_after(memory, sensor="as5048a")
        assert settings.origin == Origin.STORED
        assert of_settings(settings).pack() == kit.pack()


@pytest.mark.parametrize("pins", Pins)
def test_the_enables_of_both_boards_are_held_low(memory, tmp_path, pins):
    memory.write_bytes(kits.eeprom(kits.board(pins=pins)))
    ports = run(firmware(), tmp_path, "--seconds", "0.01", "--eeprom", str(memory)).summary["ports"]
    # D3, D5, D6 and D11 enable the motors of both boards; with either board's pins they are outputs and low
    assert ports["ddrd"] & 0x68 == 0x68
    assert ports["ddrb"] & 0x08
    assert not ports["portd"] & 0x68
    assert not ports["portb"] & 0x08
    assert bool(ports["ddrb"] & 0x10) == (pins == Pins.D3_D12)  # D12 is an output only with these pins


def test_damage_is_reported_and_defaults_are_used(memory):
    kit = kits.board(max_force=4.5)
    damaged = bytearray(kits.eeprom(kit))
    damaged[kits.PLACES[0] + 20] ^= 0x10
    memory.write_bytes(damaged)
    settings = settings_after(memory)
    assert settings.origin == Origin.DAMAGED
    assert settings.max_force == 3.0


# --- power cuts
def pass_time(board, message):
    """Send a message; return after the board has handled it and 20 ms of board time have passed."""
    before = board.status()["time"]
    os.write(board.fileno(), encode(message))
    wait_until(lambda: board.status()["time"] > before + 0.019)


def read(board):
    """Return received bytes without advancing board time."""
    data = b""
    while select.select([board.fileno()], [], [], 0.0)[0]:
        data += os.read(board.fileno(), 4096)
    return data


def ask(board):
    """Return the current settings, and ignore replies to earlier messages."""
    # this message may be lost, because after a reset the board does not receive for a moment
    pass_time(board, Alive())
    read(board)
    pass_time(board, SettingsRequest())
    (found,) = Decoder().feed(read(board))
    return of_settings(found)


def test_a_reset_while_saving_leaves_the_old_or_the_new_settings(memory):
    # saving 73 bytes at 3.4 ms each takes 0.25 s; in lockstep, board time stops between messages
    seen = []
    with opened(options=("--eeprom", str(memory))) as board:
        old = ask(board)
        for cut in range(16):
            new = kits.board(max_force=1.0 + 0.125 * cut, zero=1000 * cut, label=f"save {cut}" * (cut % 2))
            pass_time(board, new)
            pass_time(board, Save())
            for _ in range(cut):
                pass_time(board, Alive())
            board.send("reset")
            found = ask(board)
            assert found.pack() in (old.pack(), new.pack()), cut
            seen.append(found.pack() == new.pack())
            old = found
    assert np.array_equal(seen, np.sort(seen))  # early cuts keep the old settings, late cuts the new ones
    assert not seen[0]
    assert seen[-1]
