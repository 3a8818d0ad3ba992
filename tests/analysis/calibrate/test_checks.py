"""Test my Hapkit: right about kits that are well and about each that is not, and changes nothing."""

from dataclasses import replace

import pytest

from hapkit_studio.analysis.calibrate import checks
from hapkit_studio.analysis.calibrate.checks import CHECKS, run_all
from hapkit_studio.devices.board_runner import BoardRunner, StoppedError
from hapkit_studio.devices.profiles import default, quantum_of
from hapkit_studio.protocol.messages import Force, Origin
from tests.devices.paddle_kit import PaddleKit


def checked(**kit):
    made = PaddleKit(**kit)
    made.origin = Origin.STORED
    runner = BoardRunner(made)
    runner.open()
    before = made.settings_now
    report = run_all(runner)
    assert made.settings_now is before
    assert made.pwm == 0
    return report, made


def test_a_kit_that_is_well_passes_everything_in_half_a_minute():
    report, kit = checked()
    assert report.good, report.words
    assert report.words == "Your Hapkit works as it should."
    assert list(report.results) == [check.key for check in CHECKS]
    assert kit.time < 30.0
    assert report.as_json()["pass"] is True


@pytest.mark.parametrize(
    ("kit", "check", "key"),
    [
        ({"direction": -1}, "direction", "opposite"),
        ({"sense": -1}, "direction", "opposite"),
        ({"supply": 0.0}, "direction", "no motion"),
        ({"noise": 8.0}, "sensor", "noisy"),
        ({"coulomb": 0.28}, "paddle", "friction"),
        ({"mass": 0.1}, "paddle", "mass"),
        ({"torque": 0.5 * 0.0183}, "paddle", "mass"),
        ({"torque": 1.35 * 0.0183}, "paddle", "mass"),
        ({"dead": 40}, "paddle", "dead band"),
        ({"board": replace(default().board, quantum=41e-6)}, "settings", "scale"),
    ],
)
def test_each_defect_is_found_where_it_belongs(kit, check, key):
    report, _ = checked(**kit)
    result = report.results[check]
    assert result.key == key, result
    assert result.remedy
    assert not report.good
    assert CHECKS[[c.key for c in CHECKS].index(check)].title.lower() in report.words


def test_a_stored_friction_that_holds_the_handle_is_named_before_the_supply():
    result = checked(board=replace(default().board, coulomb=0.3), coulomb=0.3)[0].results["direction"]
    assert result.key == "no motion"
    assert "Dry friction of 0.30 N is stored" in result.words
    assert result.remedy.index("cable that is too tight") < result.remedy.index("supply")
    assert "friction" not in checked(supply=0.0)[0].results["direction"].words


def test_an_encoder_is_too_coarse_for_mass_and_friction_and_no_fault():
    board = replace(
        default().board, counts_per_flip=24, quantum=quantum_of(replace(default().board, counts_per_flip=24))
    )
    report, _ = checked(board=board, counts=24, magnet=7.5)
    assert "too coarse" in report.results["paddle"].words
    assert report.good


def test_what_moves_by_itself_is_left_out_where_the_direction_is_wrong():
    report, kit = checked(direction=-1)
    assert report.results["paddle"].level == report.results["spring"].level == "skip"
    assert abs(kit.x) < 0.02


def test_a_board_that_does_not_go_off_gets_no_more_force():
    kit = PaddleKit()
    kit.send_messages = lambda *messages, send=kit.send_messages: send(
        *[m for m in messages if type(m).__name__ != "Stop"]
    )
    runner = BoardRunner(kit)
    runner.open()
    report = run_all(runner)
    assert report.results["stopping"].key == "stop"
    assert max(kit.forces) <= 0.05


class Late(PaddleKit):
    """A kit whose computer says nothing for 40 ms in the middle of every push, so many times."""

    def __init__(self, times):
        super().__init__()
        self.times, self.mute = times, 0

    def send_messages(self, *messages):
        pushed = max((abs(m.force) for m in messages if isinstance(m, Force)), default=0.0)
        if pushed >= 0.1 and self.times and not self.mute and abs(self.pwm):
            self.times, self.mute = self.times - 1, 40
        if not self.mute or not pushed:
            super().send_messages(*messages)
        self.mute = max(self.mute - 1, 0)


def test_a_computer_that_was_late_twice_tries_again():
    kit = Late(2)
    kit.origin = Origin.STORED
    runner = BoardRunner(kit)
    runner.open()
    report = run_all(runner)
    assert kit.times == 0
    assert report.good, report.results


def test_a_computer_that_is_always_late_is_told_so_and_not_the_kit():
    runner = BoardRunner(Late(10**6))
    runner.open()
    result = run_all(runner).results["direction"]
    assert result.key == "late"
    assert "This computer was late" in result.words
    assert "No fault of the kit" in result.remedy


def test_a_board_that_heard_its_last_force_late_is_no_board_that_stays_on():
    kit, waiting = PaddleKit(), []
    hear, kit.send_messages = kit.send_messages, lambda *messages: waiting.append((kit.time, messages))

    def late(_kit):
        """Pass everything on 80 ms later, as a computer does that was away for a while."""
        while waiting and kit.time >= waiting[0][0] + 0.080:
            hear(*waiting.pop(0)[1])

    kit.student = late
    runner = BoardRunner(kit)
    runner.open()
    result = checks.stopping(runner)
    assert result.good, result
    assert max(kit.forces) == pytest.approx(0.05)


def test_e_stop_ends_all_of_it():
    runner = BoardRunner(PaddleKit())
    runner.open()
    with pytest.raises(StoppedError):
        run_all(runner, lambda check, result: runner.stop() if check.key == "direction" else None)
