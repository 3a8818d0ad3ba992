"""What was identified as one object, for programs."""

import math
from typing import TYPE_CHECKING, Any

from hapkit_studio.analysis.identify.part import Estimate, Part

if TYPE_CHECKING:
    from hapkit_studio.analysis.identify import Identified


def as_json(found: "Identified") -> dict[str, Any]:
    """Return both answers with their intervals; SI units, seconds and hertz said in the keys."""
    parts = {part.key: _part(found, part) for part in (found.rendered, found.handle)}
    return {"from_s": found.begin, "to_s": found.end, "parts": parts}


def _part(found: "Identified", part: Part) -> dict[str, Any]:
    return {
        "estimates": [_estimate(e) for e in part.estimates],
        "explained": _finite(part.explained),
        "motion_Hz": _finite(part.hertz),
        "used_s": part.seconds,
        "released": part.released,
        "left_out": part.left_out,
        "words": found.sentences(part),
    }


def _estimate(e: Estimate) -> dict[str, Any]:
    return {
        "key": e.key,
        "unit": e.term.unit,
        "value": _finite(e.value),
        "low": _finite(e.low),
        "high": _finite(e.high),
        "set": e.asked,
        "expected": e.expected,
        "told": e.told,
    }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
