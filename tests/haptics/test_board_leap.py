"""What the window says of an over-speed that the board saw: how fast the handle was."""

from hapkit_studio.protocol.messages import BoardFlag
from tests.haptics.board_support import undisturbed


@undisturbed()
def test_over_speed_after_a_leap_has_the_speed_of_the_leap(desk):
    """The board gives up its estimate at a leap: its counts tell how fast that was."""
    desk.go()
    desk.run(2)
    desk.count += 400
    desk.telemetry = {"flags": int(BoardFlag.OVER_SPEED), "velocity": 0.0}
    desk.run(1)
    speed = 400 * desk.engine.device.quantum / 1e-3
    assert speed > 5.0
    assert f"over-speed, {speed:.1f} m/s" in desk.engine.fault.text
