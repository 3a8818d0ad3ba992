"""Does the motor go off at the E-stop, and after silence of the computer? Tried with a force of 0.05 N."""

from hapkit_studio.analysis.calibrate.verdict import Verdict, failed, passed
from hapkit_studio.devices.calibration import Bench, LateError
from hapkit_studio.protocol.messages import BoardFlag, Force, Release, Sample, Stop

_PUSHED, _SILENCE_SECONDS = 0.03, 0.12
_PATIENCE = 3.0


def stopping(bench: Bench) -> Verdict:
    """See the motor go off after the E-stop, and after silence of the computer; the force is 0.05 N."""
    duties: list[tuple[int, int]] = []
    bench.settings = bench.board.settings()
    for quiet in (False, True):
        duties.append(_after(bench, quiet))
    (stop_flags, stop_pwm), (quiet_flags, quiet_pwm) = duties
    if stop_pwm or not stop_flags & BoardFlag.STOPPED:
        words, key = "The motor did not go off at the E-stop.", "stop"
    elif quiet_pwm or not quiet_flags & BoardFlag.WATCHDOG:
        words, key = "The motor did not go off when the computer fell silent.", "watchdog"
    else:
        return passed("Motor off at E-stop, and when the computer falls silent.")
    return failed(key, words, "Pull the motor's supply. Flash the firmware again, then test again.")


def _after(bench: Bench, quiet: bool) -> tuple[int, int]:
    """Return flags and duty once the board was stopped, or left alone, while it pushed a little.

    Time counts from when the board heard it: the computer may have said it late.
    """
    board, said = bench.board, _Said()
    board.start_stream()
    try:
        for sample in board.samples(_PATIENCE):
            said.take(sample)
            if said.time < _PUSHED:
                board.tell(Force(sample.seq, 0, 0.05))
            elif not quiet:
                said.stopped_at = sample.seq if said.stopped_at is None else said.stopped_at
                board.tell(Stop(), Force(sample.seq, 0, 0.05))
            if said.time > _SILENCE_SECONDS and said.enough(quiet):
                break
    finally:
        board.stop_stream()
        board.tell(Release())
    if not said.obeyed:
        raise LateError
    return said.flags, said.pwm


class _Said:
    """What the board has said until now: time in s, when it heard its last force, whether it ever pushed."""

    def __init__(self) -> None:
        self.time = self.heard = 0.0
        self.flags = self.pwm = 0
        self.obeyed = False
        self.stopped_at: int | None = None  # number of the first sample that a stop came with
        self._last: Sample | None = None

    def take(self, sample: Sample) -> None:
        if self._last is not None:
            self.time += ((sample.time_us - self._last.time_us) & 0xFFFFFFFF) * 1e-6
            if sample.answered != self._last.answered:
                self.heard = self.time
        self.flags, self.pwm, self._last = sample.flags, sample.pwm, sample
        self.obeyed = self.obeyed or not sample.flags & BoardFlag.WATCHDOG

    def enough(self, quiet: bool) -> bool:
        """Say whether the board has had time to go off, or has gone on after it was stopped."""
        if quiet:
            return self.time > self.heard + _SILENCE_SECONDS - _PUSHED
        if self._last is None or self.stopped_at is None:
            return False
        went_on = (self._last.answered - self.stopped_at) & 0xFFFF < 0x8000
        return went_on or bool(self.flags & BoardFlag.STOPPED) or self.time > _PATIENCE
