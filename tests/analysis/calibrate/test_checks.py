"""*Test my Hapkit* gives the correct result for good kits and for each fault, and changes no setting."""

from dataclasses import replace

import pytest

from hapkit_studio.analysis.calibrate import checks
from hapkit_studio.analysis.calibrate.checks import CHECKS, run_all
from hapkit_studio.analysis.calibrate.paddle import SweepResult
from hapkit_studio.analysis.identify import Estimate, Part
from hapkit_studio.devices.board_runner import BoardRunner, StoppedError
from hapkit_studio.devices.profiles import default, quantum_of
from hapkit_studio.protocol.messages import Force, Origin
from tests.devices.paddle_kit import PaddleKit


@pytest.fixture
def check(monkeypatch):
    """Return a function that runs some or all checks by key, and asserts that no setting has changed."""

    def checked(*keys, kit=None, **truth):
        made = kit or PaddleKit(**truth)
        made.origin = Origin.STORED
        runner = BoardRunner(made)
        runner.open()
        before = made.settings_now
        monkeypatch.setattr(checks, "CHECKS", [c for c in CHECKS if c.key in keys or not keys])
        report = run_all(runner)
        assert made.settings_now is before
        assert made.pwm == 0
        return report, made

    return checked


def test_a_good_kit_passes_every_check_in_half_a_minute(check):
    report, kit = check()
    assert report.good, report.text
    assert report.text == "Your Hapkit works correctly."
    assert list(report.results) == [check.key for check in CHECKS]
    assert kit.time < 30.0
    assert report.as_json()["pass"] is True


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kit", "key", "found"),
    [
        ({"sense": -1}, "direction", "opposite"),
        ({"supply": 0.0}, "direction", "no motion"),
        ({"noise": 8.0}, "sensor", "noisy"),
        ({"coulomb": 0.28}, "paddle", "friction"),
        ({"torque": 1.35 * 0.0183}, "paddle", "mass"),
        ({"dead": 40}, "paddle", "dead band"),
        ({"board": replace(default().board, quantum=41e-6)}, "settings", "scale"),
    ],
)
def test_each_fault_is_found_by_its_own_check(check, kit, key, found):
    report, _ = check(key, **kit)
    result = report.results[key]
    assert result.key == found, result
    assert result.remedy
    assert not report.good
    assert next(c.title for c in CHECKS if c.key == key).lower() in report.text


def test_an_undetermined_mass_does_not_pass(check, monkeypatch):
    found = (
        Estimate("mass", 0.05, 0.09, determined=False, advice="The value is uncertain."),
        *map(_known, ("viscous", "coulomb")),
    )
    swept = SweepResult(default().board, Part("handle", found), None)
    monkeypatch.setattr(checks, "sweep", lambda *_: swept)
    result = check("paddle")[0].results["paddle"]
    assert (result.key, result.text) == ("sweep", "Mass: The value is uncertain.")
    part = replace(swept.part, estimates=(_known("mass"), *found[1:]))
    monkeypatch.setattr(checks, "sweep", lambda *_: replace(swept, part=part))
    assert check("paddle")[0].good


def _known(key):
    value = getattr(default().board, key)
    return Estimate(key, value, 0.01 * value, value)


def test_a_stored_friction_that_stops_the_handle_is_reported_before_the_supply(check):
    stored = replace(default().board, coulomb=0.3)
    result = check("direction", board=stored, coulomb=0.3)[0].results["direction"]
    assert result.key == "no motion"
    assert "The dry friction (0.30 N, as stored) may hold the handle." in result.text
    assert result.remedy.index("cable that is too tight") < result.remedy.index("supply")


def test_an_encoder_too_coarse_for_mass_and_friction_is_not_a_fault(check):
    board = replace(default().board, counts_per_flip=24)
    report, _ = check("paddle", board=replace(board, quantum=quantum_of(board)), counts=24, magnet=7.5)
    assert "too coarse" in report.results["paddle"].text
    assert report.good


def test_checks_with_a_loop_are_skipped_if_the_direction_is_wrong(check):
    report, kit = check(direction=-1)
    assert report.results["paddle"].level == report.results["spring"].level == "skip"
    assert abs(kit.x) < 0.02


def test_a_board_that_does_not_stop_gets_no_further_force(check):
    kit = PaddleKit()
    kit.send_messages = lambda *messages, send=kit.send_messages: send(
        *[m for m in messages if type(m).__name__ != "Stop"]
    )
    report, _ = check(kit=kit)
    assert report.results["stopping"].key == "stop"
    assert max(kit.forces) <= 0.05


class Late(PaddleKit):
    """A kit whose computer is silent for 40 ms in the middle of each of the first ``times`` pushes."""

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


@pytest.mark.parametrize(("times", "found"), [(2, ""), (10**6, "late")])
def test_a_late_computer_is_retried_and_then_reported(check, times, found):
    report, kit = check("direction", kit=Late(times))
    result = report.results["direction"]
    assert result.key == found
    assert kit.times == 0 or "This computer was late" in result.text
    assert kit.times == 0 or "The kit is not the cause" in result.remedy


def test_a_delayed_last_force_does_not_count_as_a_failed_stop():
    kit, waiting = PaddleKit(), []
    hear, kit.send_messages = kit.send_messages, lambda *messages: waiting.append((kit.time, messages))

    def late(_kit):
        """Delay a message by 80 ms, as a busy computer would."""
        while waiting and kit.time >= waiting[0][0] + 0.080:
            hear(*waiting.pop(0)[1])

    kit.student = late
    runner = BoardRunner(kit)
    runner.open()
    result = checks.stopping(runner)
    assert result.good, result
    assert max(kit.forces) == pytest.approx(0.05)


def test_e_stop_ends_all_checks():
    runner = BoardRunner(PaddleKit())
    runner.open()
    with pytest.raises(StoppedError):
        run_all(runner, lambda check, result: runner.stop() if check.key == "direction" else None)
