"""A failure shown: tried just inside its limit and just outside, and charted."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

from hapkit_studio.analysis.failures.base import Case, Chart, Evidence, Failure, quiet
from hapkit_studio.analysis.sweeps import Progress
from hapkit_studio.errors import ParameterError


@dataclass(frozen=True)
class Try:
    """One value of the knob, and what it showed."""

    value: float
    evidence: Evidence


@dataclass(frozen=True)
class Shown:
    """A failure in one case: its limit, a try that should hold and one that should fail, the chart if any."""

    failure: Failure
    case: Case
    limit: float
    inside: Try
    outside: Try
    chart: Chart | None = None

    @property
    def as_theory_says(self) -> bool:
        """Say whether the inner try holds and the outer one fails."""
        return self.inside.evidence.holds and not self.outside.evidence.holds


def show(
    failure: Failure,
    given: Mapping[str, object] | None = None,
    *,
    chart: bool = True,
    progress: Progress = quiet,
) -> Shown:
    """Return a failure tried on both sides of its limit; raise ParameterError for options without a limit."""
    case = failure.case(given)
    if not 0.0 < failure.limit(case) < math.inf:
        what = "fails" if failure.limit(case) else "holds"
        raise ParameterError(f"{failure.title}: nothing {what} with these options, change one of them.")
    values = failure.inside(case), failure.outside(case)
    inside, outside = (Try(value, failure.probe(value, case)) for value in values)
    curve = failure.curve(case, progress) if chart else None
    return Shown(failure, case, failure.limit(case), inside, outside, curve)
