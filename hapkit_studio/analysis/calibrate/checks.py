"""Test my Hapkit: run the wizard's checks in half a minute, without changing the board's settings."""

import contextlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from hapkit_studio.analysis.calibrate import motions
from hapkit_studio.analysis.calibrate.motor import push_both_ways
from hapkit_studio.analysis.calibrate.paddle import sweep
from hapkit_studio.analysis.calibrate.result import FAIL, PASS, SKIP, WARN, CheckResult, passed, warn
from hapkit_studio.analysis.calibrate.sensor import NOISY, noise_of, too_noisy
from hapkit_studio.devices.board_runner import (
    AbortedError,
    BoardRunner,
    CancelledError,
    ForceLimitError,
    LateError,
    StoppedError,
)
from hapkit_studio.devices.profiles import numbered, quantum_of
from hapkit_studio.protocol.messages import BoardFlag, Force, Origin, Release, Sample, Stop

SPRING = 100.0
"""N/m: a virtual spring that every kit renders stably."""
_SWEEP_SECONDS = 8.0
_MASS_TOLERANCE = 0.3
_MUCH_FRICTION = 0.25
_HOLDING_FRICTION = 0.2
"""N: dry friction that may hold a handle against the strongest pulse."""
_FRICTION_REMEDY = "Look for a cable that is too tight, a dry bearing, or a sector that rubs."
_SWEEP_REMEDY = "Put the kit on a level surface, release the handle in the middle, and test again."
_COARSE_QUANTUM = 0.2e-3
"""m: size of a count; with a coarser sensor (an encoder), a sweep determines neither mass nor friction."""
_TRIES = 3
_PUSHED_SECONDS, _SILENCE_SECONDS, _PATIENCE = 0.03, 0.12, 3.0
"""s: duration of the push, of the silence, and time-out, in the test of stopping."""


@dataclass(frozen=True)
class Check:
    """One check of a kit, with its title; ``run`` returns the result."""

    key: str
    title: str
    about: str
    run: Callable[[BoardRunner], CheckResult]


def settings(runner: BoardRunner) -> CheckResult:
    """Check that the board is calibrated, and that scale and radii agree."""
    now = runner.read_settings()
    kit = numbered(now.profile)
    ratio = now.quantum / quantum_of(now)
    if now.origin == Origin.DAMAGED:
        return warn(
            "damaged",
            "The board's stored settings are damaged; it uses the default settings.",
            "Run Set up my Hapkit, or write a calibration file to the board.",
        )
    if abs(ratio - 1.0) > 0.1:
        return warn(
            "scale",
            f"Scale and radii disagree: with the scale, the handle moves {ratio:.2f} × as far per count as "
            "with the radii.",
            "Run Set up my Hapkit, step Zero and scale.",
        )
    if now.origin != Origin.STORED:
        text = "Nothing is stored on the board, so it uses the values of the usual kit."
        return warn("not stored", text, "Run Set up my Hapkit.")
    return passed(f"“{now.label}”, {kit.title if kit else 'another kit'}, stored on the board.")


def sensor(runner: BoardRunner) -> CheckResult:
    """Check the sensor at rest."""
    track = runner.record(1.0)
    noise = noise_of(track.raw)
    lost = len(track) / max(1, int((track.seq[-1] - track.seq[0]) % 65536) + 1)
    if noise > NOISY:
        return too_noisy(noise)
    if np.ptp(track.position) > 0.5e-3:
        text = f"The handle moved {1e3 * np.ptp(track.position):.1f} mm although it should rest."
        return warn("moving", text, "Take your hands off, put the kit on a level surface, and test again.")
    if np.any(track.flags & int(BoardFlag.SENSOR)):
        return warn("sensor", "Some readings are impossible.", "Check the sensor's plug and magnet.")
    return passed(
        f"The sensor reads {int(np.median(track.raw))} and is steady. {100.0 * lost:.1f} % of the samples "
        "arrived."
    )


def stopping(runner: BoardRunner) -> CheckResult:
    """Check that the motor stops after an E-stop and when the computer is silent, at a force of 0.05 N."""
    stop_flags, stop_pwm = _flags_after(runner, silent=False)
    silence_flags, silence_pwm = _flags_after(runner, silent=True)
    if stop_pwm or not stop_flags & BoardFlag.STOPPED:
        text, key = "The E-stop did not switch the motor off.", "stop"
    elif silence_pwm or not silence_flags & BoardFlag.WATCHDOG:
        text, key = "The motor did not switch off when the computer stopped sending.", "watchdog"
    else:
        return passed(_STOPPING)
    remedy = "Disconnect the motor's power supply. Flash the firmware again, then test again."
    return CheckResult(FAIL, text, remedy, key)


def _flags_after(runner: BoardRunner, silent: bool) -> tuple[int, int]:
    """Push slightly, then stop the motor or send nothing more; return the resulting status flags and duty.

    The waiting time starts when the board receives a command, because the computer may send it late.
    """
    board, obeyed = runner.board, False
    # s on the board's clock: the current time, and the time of the last force command received
    time = heard = 0.0
    last: Sample | None = None
    stopped: int | None = None  # number of the first sample after a stop
    try:
        with contextlib.closing(runner.samples(_PATIENCE)) as samples:
            for sample in samples:
                runner.check_stopped()
                if last is not None:
                    time += ((sample.time_us - last.time_us) & 0xFFFFFFFF) * 1e-6
                    heard = time if sample.answered != last.answered else heard
                last = sample
                obeyed = obeyed or not sample.flags & BoardFlag.WATCHDOG
                enough = time > heard + _SILENCE_SECONDS - _PUSHED_SECONDS
                if time < _PUSHED_SECONDS:
                    board.send_messages(Force(sample.seq, 0, 0.05))
                elif not silent:
                    stopped = sample.seq if stopped is None else stopped
                    board.send_messages(Stop(), Force(sample.seq, 0, 0.05))
                    went_on = (sample.answered - stopped) & 0xFFFF < 0x8000
                    enough = went_on or bool(sample.flags & BoardFlag.STOPPED) or time > _PATIENCE
                if enough and time > _SILENCE_SECONDS:
                    break
    finally:
        board.send_messages(Release())
    if last is None or not obeyed:
        raise LateError
    return last.flags, last.pwm


def direction(runner: BoardRunner) -> CheckResult:
    """Check the direction by pushing both ways."""
    found = push_both_ways(runner)
    if found.agrees is False:
        text = found.result.text + " A spring would push the handle away."
        remedy = "Run Set up my Hapkit, step Direction, or choose Device, Reverse the handle's direction."
        return CheckResult(FAIL, text, remedy, "opposite")
    if found.result.key == "no motion" and runner.settings.coulomb > _HOLDING_FRICTION:
        friction = f"The dry friction ({runner.settings.coulomb:.2f} N, as stored) may hold the handle."
        text = f"{found.result.text} {friction}"
        remedy = f"{_FRICTION_REMEDY} If you find none of these: {found.result.remedy}"
        return warn("no motion", text, remedy)
    return found.result


def paddle(runner: BoardRunner) -> CheckResult:
    """Sweep the handle, and compare mass and friction with the stored values."""
    swept = sweep(runner, _SWEEP_SECONDS)
    now, part = runner.settings, swept.part
    if not part.estimates and now.quantum > _COARSE_QUANTUM:
        count = f"One sensor step is {1e3 * now.quantum:.1f} mm"
        return passed(f"The test motion worked. {count}, which is too coarse to measure mass and friction.")
    if not part.estimates:
        return warn("sweep", part.advice, _SWEEP_REMEDY)
    mass, dry = part["mass"], part["coulomb"]
    if not mass.determined:
        return warn("sweep", f"Mass: {mass.advice}", _SWEEP_REMEDY)
    damping = part["viscous"].value
    text = f"Mass {1e3 * mass.value:.0f} g, damping {damping:.2f} N·s/m, friction {dry.value:.2f} N"
    if swept.board.dead_band != now.dead_band:
        remedy = "Small forces are too weak now. Run Set up my Hapkit, step Friction."
        return warn("dead band", f"The motor begins to turn at duty {swept.board.dead_band} of 255.", remedy)
    if dry.low > max(2.0 * now.coulomb, _MUCH_FRICTION):
        return warn("friction", f"{text}; stored: {now.coulomb:.2f} N.", _FRICTION_REMEDY)
    if max(mass.value / now.mass, now.mass / mass.value) - 1.0 > _MASS_TOLERANCE + mass.half / now.mass:
        stored = f"{text}; stored: {1e3 * now.mass:.0f} g."
        changed = "The motor's strength or the handle has changed"
        remedy = f"{changed}: run Set up my Hapkit, steps Strength and Friction."
        return warn("mass", stored, remedy)
    stored = f"{1e3 * now.mass:.0f} g, {now.viscous:.2f} N·s/m, {now.coulomb:.2f} N"
    return passed(f"{text}; stored: {stored}.")


def spring(runner: BoardRunner) -> CheckResult:
    """Render a spring, knock the handle, and check that it settles."""
    track = motions.spring(runner, SPRING)
    late = track.position[track.time > 1.2]
    size = float(np.ptp(late))
    if size > 1e-3:
        text = (
            f"On a spring of {SPRING:.0f} N/m, the handle still moves by {1e3 * size:.1f} mm after a second."
        )
        return warn(
            "spring",
            text,
            "Lower the USB delay: set the latency timer to 1 ms, or let Set up my Hapkit fill the USB "
            "packets. Tighten the cable.",
        )
    return passed(f"On a spring of {SPRING:.0f} N/m, the handle comes to rest.")


_STOPPING = "The motor switches off at an E-stop and if the computer stops sending."
CHECKS = (
    Check(
        "settings",
        "Settings",
        "Reads the settings stored on the board and checks that scale and radii agree.",
        settings,
    ),
    Check(
        "sensor", "Sensor", "Checks that the reading is steady at rest and that no sample is lost.", sensor
    ),
    Check("stopping", "Stopping", _STOPPING, stopping),
    Check(
        "direction",
        "Direction",
        "Pushes the handle with pulses of at most 0.3 N in both directions.",
        direction,
    ),
    Check("paddle", "Mass and friction", "Moves the handle gently by up to 25 mm to both sides.", paddle),
    Check("spring", "Spring", "Checks that the handle comes to rest on a spring of 100 N/m.", spring),
)
_NEEDED = ("stopping", "direction")
"""Checks that must pass before any later check may move the handle."""


@dataclass(frozen=True)
class Report:
    """The results of all checks in order, by the key of the check."""

    results: dict[str, CheckResult]

    @property
    def good(self) -> bool:
        """Return True if every check passed."""
        return all(result.good for result in self.results.values())

    def as_json(self) -> dict[str, Any]:
        """Return the report as an object of JSON data."""
        return {"pass": self.good, "checks": {k: vars(v) | {} for k, v in self.results.items()}}

    @property
    def dangerous(self) -> bool:
        """Return True if a failed check makes rendering on this kit unsafe."""
        return any(result.level == FAIL for result in self.results.values())

    @property
    def text(self) -> str:
        """Return a one-line summary."""
        if self.good:
            return "Your Hapkit works correctly."
        left_out = self._titles(SKIP)
        rest = f" Not tested yet: {left_out}." if left_out else ""
        if self.dangerous:
            return f"Do not use this Hapkit yet. First repair: {self._titles(FAIL)}.{rest}"
        rest = rest or (" Everything else is fine." if self._titles(PASS) else "")
        return f"Look at these checks: {self._titles(WARN)}.{rest}"

    def _titles(self, level: str) -> str:
        """Return the titles of the checks with this level, as text."""
        titles = {check.key: check.title.lower() for check in CHECKS}
        return ", ".join(titles[key] for key, result in self.results.items() if result.level == level)


def run_all(
    runner: BoardRunner, report: Callable[[Check, CheckResult | None], None] = lambda check, result: None
) -> Report:
    """Run every check; call report(check, None) when a check starts, and report(check, result) when it ends.

    If the check of stopping or of direction fails, checks with a control loop are skipped. Raise StoppedError
    after an E-stop, CancelledError if the user cancels, and PortGoneError without a board.
    """
    results: dict[str, CheckResult] = {}
    for check in CHECKS:
        report(check, None)
        if all(results[key].good for key in _NEEDED if key in results):
            results[check.key] = _run_check(check, runner)
        else:
            results[check.key] = CheckResult(SKIP, "Not tested until the checks above pass.")
        report(check, results[check.key])
    return Report(results)


def _run_check(check: Check, runner: BoardRunner) -> CheckResult:
    """Return a check's result, also if the check was aborted; retry if the computer was late."""
    for _ in range(_TRIES):
        try:
            return check.run(runner)
        except LateError:
            continue
        except (StoppedError, CancelledError):
            raise
        except ForceLimitError as error:
            return CheckResult(WARN, str(error))
        except AbortedError as error:
            return warn("aborted", str(error), _SWEEP_REMEDY)
    text = f"This computer was late {_TRIES} times, so the board switched the motor off, as it should."
    return warn("late", text, "The kit is not the cause. Close other programs, then test again.")
