"""What trying out an environment's file found: problems at their lines, warnings, the cost of a call."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Problem:
    """What keeps an environment from the loop: the line it stands on, 0 for none, and its words."""

    line: int
    text: str

    def __str__(self) -> str:
        return f"Line {self.line}: {self.text}." if self.line else f"{self.text[:1].upper()}{self.text[1:]}."


@dataclass(frozen=True)
class Verdict:
    """A trial's outcome; the environment may go to the loop where there is no problem.

    ns_per_call and calls are 0 where the law was not called.
    """

    problems: tuple[Problem, ...] = ()
    warnings: tuple[str, ...] = ()
    ns_per_call: float = 0.0
    calls: int = 0

    @property
    def ok(self) -> bool:
        return not self.problems

    def as_json(self) -> dict:
        """Return plain words and numbers, which from_json takes back."""
        problems = [[p.line, p.text] for p in self.problems]
        return {**vars(self), "ok": self.ok, "problems": problems, "warnings": list(self.warnings)}

    @classmethod
    def from_json(cls, found: dict) -> "Verdict":
        """Return the verdict of as_json's object; raise ValueError, TypeError or KeyError for any other."""
        problems = tuple(Problem(int(line), str(text)) for line, text in found["problems"])
        warnings = tuple(str(w) for w in found["warnings"])
        return cls(problems, warnings, float(found["ns_per_call"]), int(found["calls"]))


def failed(text: str, line: int = 0) -> Verdict:
    """Return the verdict of one problem."""
    return Verdict((Problem(line, text),))
