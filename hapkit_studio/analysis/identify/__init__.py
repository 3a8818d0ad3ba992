"""System identification from a recording: the rendered impedance, and the handle's mass and friction.

``identify(from_run(run))``, ``identify(from_csv("run.csv"))``, ``identify(of_rows(rows, setup))``.
"""

import math
from dataclasses import dataclass
from typing import Any

from hapkit_studio.analysis.identify import texts
from hapkit_studio.analysis.identify.estimates import TERMS, Estimate, Part, Points, Term
from hapkit_studio.analysis.identify.handle import handle
from hapkit_studio.analysis.identify.recording import Handle, Recording, Setup, from_csv, from_run, of_rows
from hapkit_studio.analysis.identify.rendered import rendered
from hapkit_studio.analysis.identify.windows import lay
from hapkit_studio.analysis.statistics import dominant
from hapkit_studio.errors import ParameterError
from hapkit_studio.formatting import plain

__all__ = ["TERMS", "Estimate", "Handle", "Identified", "Part", "Points", "Recording", "Setup", "Term"]
__all__ += ["from_csv", "from_run", "identify", "of_rows", "texts"]

RENDERED_TERMS = ("stiffness", "damping", "friction")


@dataclass(frozen=True)
class Identified:
    """The result of ``identify`` for the recording from ``begin`` to ``end`` in s.

    ``hertz`` is the dominant frequency of the position, NaN without a clear peak. ``noise`` is the
    standard deviation in m of the position noise beyond quantisation; it is 0 without such noise.
    """

    rendered: Part
    handle: Part
    setup: Setup
    samples: int
    begin: float
    end: float
    hertz: float = math.nan
    noise: float = 0.0

    def sentences(self, part: Part) -> list[str]:
        """Return a part's results as sentences, one per line."""
        return texts.sentences(part, self.setup, self.samples) + self._noise_remark(part)

    def notes(self, part: Part) -> list[str]:
        """Return the remarks below a table of a part's numbers, one per line."""
        return texts.notes(part, self.setup, self.samples) + self._noise_remark(part)

    def _noise_remark(self, part: Part) -> list[str]:
        return [texts.noisy(self.noise, self.setup)] if self.noise and part.estimates else []

    @property
    def force_known(self) -> str:
        """Return a sentence that says that the force is the command, not a measurement."""
        return texts.force_known(self.setup)

    def surprises(self, part: Part) -> bool:
        """Return True if a rendered value differs from both the setting and the loop's expected value."""
        return part.key == "rendered" and any(texts.surprising(e) for e in part.estimates)

    def as_json(self) -> dict[str, Any]:
        """Return the estimates of both parts with their intervals, without the points of the fits.

        Numbers are in SI units unless a key names a unit.
        """
        parts = {part.key: self._part_json(part) for part in (self.rendered, self.handle)}
        setup = dict(texts.conditions(self.setup, self.handle.released))
        found = {"from_s": self.begin, "to_s": self.end, "parts": parts, "setup": setup}
        return plain(found | {"position_noise_m": self.noise, "force": self.force_known})

    def _part_json(self, part: Part) -> dict[str, Any]:
        return {
            "estimates": [
                {"key": e.key, "unit": e.term.unit, "value": e.value, "low": e.low, "high": e.high}
                | {"set": e.asked, "expected": e.expected, "determined": e.determined}
                for e in part.estimates
            ],
            "explained": part.explained,
            "motion_Hz": self.hertz,
            "used_s": part.seconds,
            "released": part.released,
            "left_out": part.left_out,
            "text": self.sentences(part),
        }


def identify(
    recording: Recording,
    *,
    begin: float | None = None,
    end: float | None = None,
    terms: tuple[str, ...] | None = None,
    released: bool = False,
) -> Identified:
    """Identify the part of a recording from ``begin`` to ``end`` in s; by default the whole recording.

    ``terms`` are some of RENDERED_TERMS; None uses those of the environment. ``released`` states that no hand
    holds the handle; it is needed if the recording has no information about a hand. If the settings change
    and neither begin nor end is given, the longest part with constant settings is used. Raise ParameterError
    for an unknown term, or if this part of the recording is too short or irregular.
    """
    unknown = [term for term in terms or () if term not in RENDERED_TERMS]
    if unknown or terms == ():
        raise ParameterError(f"The terms must be from {', '.join(RENDERED_TERMS)}, not {', '.join(unknown)}.")
    whole = begin is None and end is None and recording.later
    piece = (recording.longest() if whole else recording.between(begin, end)).check()
    grid = lay(piece)
    chosen = tuple(term for term in RENDERED_TERMS if term in terms) if terms else None
    return Identified(
        rendered(grid, piece.setup, chosen),
        handle(grid, piece.setup, released),
        piece.setup,
        len(grid),
        float(piece.time[0]),
        float(piece.time[-1]),
        dominant(piece.time, piece.position),
        math.sqrt((grid.step**2 - piece.setup.quantum**2) / 12.0),
    )
