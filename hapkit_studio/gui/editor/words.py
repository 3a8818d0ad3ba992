"""What the strip under a law says."""

from hapkit_studio.workshop.verdict import Verdict

_GOES_ON = "The old law goes on."


def of_verdict(verdict: Verdict) -> tuple[str, str]:
    """Return a trial's outcome in words, and their tone."""
    if not verdict.ok:
        more = len(verdict.problems) - 1
        others = f" ({more} more)" if more else ""
        return f"{verdict.problems[0]}{others} {_GOES_ON}", "danger"
    tried = (
        f"In force. Tried in {verdict.calls:,} calls, {verdict.ns_per_call:.0f} ns each."
        if verdict.calls
        else ""
    )
    if verdict.warnings:
        return " ".join(("In force.", *verdict.warnings)), "warn"
    return tried or "In force.", "ok"


def not_saved(error: OSError) -> str:
    """Say why a file could not be written."""
    return f"Not saved: {error.strerror or error}. What you typed is still here."
