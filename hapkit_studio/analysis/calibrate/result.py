"""The result of a check: passed, or what to look at and what to do."""

from dataclasses import dataclass

PASS, WARN, FAIL, SKIP = "pass", "look", "fail", "skip"


@dataclass(frozen=True)
class CheckResult:
    """What was found, in words; remedy: what to do; key: names the fault.

    WARN: something to look at, nothing is dangerous. FAIL: a danger, nothing may be rendered before it is
    repaired. SKIP: left out, the words say what is assumed.
    """

    level: str
    words: str
    remedy: str = ""
    key: str = ""

    @property
    def good(self) -> bool:
        """Say whether there is nothing to do."""
        return self.level == PASS


def passed(words: str) -> CheckResult:
    """Return the result of a check that found nothing wrong."""
    return CheckResult(PASS, words)


def warn(key: str, words: str, remedy: str) -> CheckResult:
    """Return the result of a check that found something to look at."""
    return CheckResult(WARN, words, remedy, key)
