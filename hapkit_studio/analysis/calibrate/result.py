"""The result of a check: the check passed, or it found a fault that has a remedy."""

from dataclasses import dataclass

PASS, WARN, FAIL, SKIP = "pass", "warn", "fail", "skip"


@dataclass(frozen=True)
class CheckResult:
    """The result of a check as text. ``remedy`` says what to do, and ``key`` identifies the fault.

    WARN is not dangerous. FAIL is dangerous: rendering is blocked until the fault is repaired. SKIP means
    that the check was left out; the text states what is assumed instead.
    """

    level: str
    text: str
    remedy: str = ""
    key: str = ""

    @property
    def good(self) -> bool:
        """Return True if the check passed."""
        return self.level == PASS


def passed(text: str) -> CheckResult:
    return CheckResult(PASS, text)


def failed(key: str, text: str, remedy: str) -> CheckResult:
    return CheckResult(FAIL, text, remedy, key)


def warn(key: str, text: str, remedy: str) -> CheckResult:
    return CheckResult(WARN, text, remedy, key)
