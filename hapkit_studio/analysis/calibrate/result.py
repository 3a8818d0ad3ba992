"""The result of a check: passed, or a fault with its remedy."""

from dataclasses import dataclass

PASS, WARN, FAIL, SKIP = "pass", "look", "fail", "skip"


@dataclass(frozen=True)
class CheckResult:
    """Result of a check as text; remedy: what to do; key: identifies the fault.

    WARN: not dangerous. FAIL: dangerous, so rendering is blocked until it is repaired. SKIP: left out, the
    text states the assumption.
    """

    level: str
    words: str
    remedy: str = ""
    key: str = ""

    @property
    def good(self) -> bool:
        """Return True if there is nothing to do."""
        return self.level == PASS


def passed(words: str) -> CheckResult:
    return CheckResult(PASS, words)


def failed(key: str, words: str, remedy: str) -> CheckResult:
    return CheckResult(FAIL, words, remedy, key)


def warn(key: str, words: str, remedy: str) -> CheckResult:
    return CheckResult(WARN, words, remedy, key)
