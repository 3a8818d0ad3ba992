"""What a check answers: pass, or look at this and what to do."""

from dataclasses import dataclass

PASS, LOOK, FAIL, SKIP = "pass", "look", "fail", "skip"


@dataclass(frozen=True)
class Verdict:
    """One answer in words; remedy: what to do at LOOK, and at FAIL (a danger). key names the fault."""

    level: str
    words: str
    remedy: str = ""
    key: str = ""

    @property
    def good(self) -> bool:
        """Say whether there is nothing to do."""
        return self.level == PASS


def passed(words: str) -> Verdict:
    """Return a verdict that all is well."""
    return Verdict(PASS, words)


def look(key: str, words: str, remedy: str) -> Verdict:
    """Return a verdict that something is to be looked at."""
    return Verdict(LOOK, words, remedy, key)


def failed(key: str, words: str, remedy: str) -> Verdict:
    """Return a verdict that something is dangerous: nothing may be rendered before it is mended."""
    return Verdict(FAIL, words, remedy, key)


def skipped(words: str) -> Verdict:
    """Return the verdict on what was not tried: what is assumed then."""
    return Verdict(SKIP, words)
