"""Test my Hapkit: the wizard's checks again, in half a minute, without changing anything on the board."""

import contextlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from hapkit_studio.analysis.calibrate import trials
from hapkit_studio.analysis.calibrate.sensor import NOISY, noise_of
from hapkit_studio.analysis.calibrate.stopping import stopping
from hapkit_studio.analysis.calibrate.verdict import (
    FAIL,
    LOOK,
    PASS,
    SKIP,
    Verdict,
    failed,
    look,
    passed,
    skipped,
)
from hapkit_studio.devices import calibration_moves as moves
from hapkit_studio.devices.calibration import Bench, DoubtError, LateError, StoppedError
from hapkit_studio.devices.profiles import numbered, quantum_of
from hapkit_studio.errors import NoDataError
from hapkit_studio.protocol.messages import BoardFlag, Origin

SECONDS = 30.0
"""What all of it takes, about."""
SPRING = 100.0
"""N/m: a spring that every kit renders without growing."""
_SWEEP_SECONDS = 8.0
_ALIKE = 0.3
_STICKY = 0.25
_HOLDS = 0.2
"""N of dry friction that may hold a handle against the strongest pulse."""
_REMEDY_STICKY = "Look for a cable that is too tight, a dry bearing, a sector that rubs."
_COARSE = 0.2e-3
"""m per count from which a sweep of a few mm tells neither mass nor friction: an encoder's."""
_TRIES = 3


@dataclass(frozen=True)
class Check:
    """One check of a kit, what it is about; ``run`` gets the bench and says what it found."""

    key: str
    title: str
    about: str
    run: Callable[[Bench], Verdict]
    motor: bool = False


def settings(bench: Bench) -> Verdict:
    """Say whether the board has settings of its own, and whether scale and radii agree."""
    now = bench.settings = bench.board.settings()
    kit = numbered(now.profile)
    ratio = now.quantum / quantum_of(now)
    if now.origin == Origin.DAMAGED:
        return look(
            "damaged",
            "The board's stored settings are damaged; it uses the usual kit's.",
            "Run Set up my Hapkit, or put a calibration file on the board again.",
        )
    if abs(ratio - 1.0) > 0.1:
        return look(
            "scale",
            f"Scale and radii differ: {ratio:.2f} × the travel per count that the radii make.",
            "Run Set up my Hapkit, step 2.",
        )
    if now.origin != Origin.STORED:
        words = "Nothing is stored on the board: it takes itself for the usual kit."
        return look("not stored", words, "Run Set up my Hapkit.")
    return passed(f"“{now.label}”, {kit.title if kit else 'a kit of its own'}, stored on the board.")


def sensor(bench: Bench) -> Verdict:
    """Watch the sensor at rest."""
    track = bench.watch(1.0)
    noise = noise_of(track.raw)
    lost = len(track) / max(1, int((track.seq[-1] - track.seq[0]) % 65536) + 1)
    if noise > NOISY:
        return look(
            "noisy",
            f"The reading jumps by {noise:.0f} counts at rest (limit {NOISY:.0f}).",
            "Bring the magnet nearer to the chip, not touching. Keep the motor's wires away from it.",
        )
    if np.ptp(track.position) > 0.5e-3:
        words = f"The handle moved {1e3 * np.ptp(track.position):.1f} mm while it should rest."
        return look("moving", words, "Take the hands off, level the kit, test again.")
    if np.any(track.flags & int(BoardFlag.SENSOR)):
        return look("sensor", "Readings came that cannot be right.", "Check the sensor's plug and magnet.")
    return passed(f"Reads {int(np.median(track.raw))}, steady; {100.0 * lost:.1f} % of the samples arrived.")


def direction(bench: Bench) -> Verdict:
    """Push both ways."""
    found = trials.push_both_ways(bench)
    if found.agrees is False:
        words = found.verdict.words + " A spring would run away."
        return failed("opposite", words, "Run Set up my Hapkit, step 3, or Device, Flip direction.")
    if found.verdict.key == "no motion" and bench.now.coulomb > _HOLDS:
        words = f"{found.verdict.words} Dry friction of {bench.now.coulomb:.2f} N is stored: it may hold it."
        return look("no motion", words, f"{_REMEDY_STICKY} Else: {found.verdict.remedy}")
    return found.verdict


def paddle(bench: Bench) -> Verdict:
    """Sweep, and compare mass and friction with what is stored."""
    swept = trials.sweep(bench, _SWEEP_SECONDS)
    now, part = bench.now, swept.part
    if not part.estimates and now.quantum > _COARSE:
        count = f"One count is {1e3 * now.quantum:.1f} mm"
        return passed(f"Swept. {count}: too coarse to tell mass and friction.")
    if not part.estimates:
        return look("sweep", part.advice, "Level the kit, let the handle go in the middle, test again.")
    mass, dry = part["mass"], part["coulomb"]
    damping = part["viscous"].value
    words = f"Mass {1e3 * mass.value:.0f} g, damping {damping:.2f} N·s/m, friction {dry.value:.2f} N"
    if swept.board.dead_band != now.dead_band:
        remedy = "Run Set up my Hapkit, step 5: small forces are too small."
        return look("dead band", f"The motor begins to turn at duty {swept.board.dead_band} of 255.", remedy)
    if dry.low > max(2.0 * now.coulomb, _STICKY):
        return look("friction", f"{words}; stored is {now.coulomb:.2f} N.", _REMEDY_STICKY)
    if max(mass.value / now.mass, now.mass / mass.value) - 1.0 > _ALIKE + mass.half / now.mass:
        stored = f"{words}; stored is {1e3 * now.mass:.0f} g."
        return look("mass", stored, "The motor's strength or the handle has changed: run steps 4 and 5.")
    stored = f"{1e3 * now.mass:.0f} g, {now.viscous:.2f} N·s/m, {now.coulomb:.2f} N"
    return passed(f"{words}; stored, and near enough: {stored}.")


def spring(bench: Bench) -> Verdict:
    """Render a spring, knock the handle, see it come to rest."""
    track = moves.spring(bench, SPRING)
    late = track.position[track.time > 1.2]
    size = float(np.ptp(late))
    if size > 1e-3:
        words = f"A spring of {SPRING:.0f} N/m still moves by {1e3 * size:.1f} mm after a second."
        return look("spring", words, "Lower the delay (low-latency mode, frame padding), tighten the cable.")
    return passed(f"A spring of {SPRING:.0f} N/m comes to rest.")


CHECKS = (
    Check("settings", "Settings", "What the board has stored, and whether it fits together.", settings),
    Check("sensor", "Sensor", "Steady at rest; no sample lost.", sensor),
    Check(
        "stopping",
        "Stopping",
        "Motor off at E-stop, and when the computer falls silent.",
        stopping,
        motor=True,
    ),
    Check("direction", "Direction", "Pulses of 0.3 N at most, both ways.", direction, motor=True),
    Check("paddle", "Mass and friction", "A gentle sweep, within ± 25 mm.", paddle, motor=True),
    Check("spring", "Spring", "A spring of 100 N/m comes to rest.", spring, motor=True),
)
_NEEDED = ("stopping", "direction")


@dataclass(frozen=True)
class Report:
    """All verdicts by the key of their check, in order."""

    verdicts: dict[str, Verdict]

    @property
    def good(self) -> bool:
        """Say whether every check passed."""
        return all(verdict.good for verdict in self.verdicts.values())

    def as_json(self) -> dict[str, Any]:
        """Return everything for programs."""
        return {"pass": self.good, "checks": {k: vars(v) | {} for k, v in self.verdicts.items()}}

    @property
    def dangerous(self) -> bool:
        """Say whether a check failed so that nothing may be rendered on this kit."""
        return any(verdict.level == FAIL for verdict in self.verdicts.values())

    @property
    def words(self) -> str:
        """Return the whole in one line."""
        if self.good:
            return "Your Hapkit is well."
        left_out = self._titles(SKIP)
        rest = f" Not tested until then: {left_out}." if left_out else ""
        if self.dangerous:
            return f"Do not use this Hapkit yet. Mend first: {self._titles(FAIL)}.{rest}"
        rest = rest or (" All else is well." if self._titles(PASS) else "")
        return f"Look at: {self._titles(LOOK)}.{rest}"

    def _titles(self, level: str) -> str:
        """Return the checks with a verdict of a level, in words."""
        return ", ".join(c.title.lower() for c in CHECKS if self._level(c.key) == level)

    def _level(self, key: str) -> str:
        return self.verdicts[key].level if key in self.verdicts else ""


def run_all(
    bench: Bench, said: Callable[[Check, Verdict | None], None] = lambda check, verdict: None
) -> Report:
    """Run every check; said(check, None) as one begins, then its verdict. Raise StoppedError, PortGoneError.

    Where stopping or direction fail, what moves the handle in a loop is left out.
    """
    verdicts: dict[str, Verdict] = {}
    for check in CHECKS:
        said(check, None)
        blocked = [key for key in _NEEDED if key in verdicts and not verdicts[key].good]
        if check.motor and blocked:
            verdict = skipped("Left out until the checks above pass.")
        else:
            verdict = _safely(check, bench)
        verdicts[check.key] = verdict
        said(check, verdict)
    return Report(verdicts)


def _safely(check: Check, bench: Bench) -> Verdict:
    """Return a check's verdict; a doubt that stopped it is one. Where the computer was late, try again."""
    for _ in range(_TRIES - 1):
        with contextlib.suppress(LateError):
            return _once(check, bench)
    try:
        return _once(check, bench)
    except LateError:
        words = f"This computer was late, {_TRIES} times: the board switched its motor off, as it must."
        return look("late", words, "No fault of the kit. Close other programs, then test again.")


def _heard(check: Check, bench: Bench) -> Verdict:
    """Run a check; where samples stop coming, once more: a board may miss one order to stream."""
    try:
        return check.run(bench)
    except NoDataError:
        return check.run(bench)


def _once(check: Check, bench: Bench) -> Verdict:
    try:
        return _heard(check, bench)
    except (StoppedError, LateError):
        raise
    except DoubtError as doubt:
        return look("doubt", str(doubt), "Level the kit, hands off, handle in the middle. Then test again.")
