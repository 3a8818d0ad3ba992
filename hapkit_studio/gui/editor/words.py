"""What the strip under a law says."""

from hapkit_studio.workshop.verdict import Verdict

_GOES_ON = "The old law goes on."
_SINCE = "What was typed since is not saved."


def of_verdict(verdict: Verdict, unsaved: bool = False) -> tuple[str, str]:
    """Return a trial's outcome in words, and their tone; unsaved: the text has changed since."""
    since = (_SINCE,) if unsaved else ()
    if not verdict.ok:
        more = len(verdict.problems) - 1
        others = (f"({more} more)",) if more else ()
        return " ".join((str(verdict.problems[0]), *others, _GOES_ON, *since)), "danger"
    if verdict.warnings:
        return " ".join(("In force.", *verdict.warnings, *since)), "warn"
    cost = f"Tried in {verdict.calls:,} calls, {verdict.ns_per_call:.0f} ns each."
    return " ".join(("In force.", *((cost,) if verdict.calls else ()), *since)), "ok"


def not_saved(error: OSError) -> str:
    """Say why a file could not be written."""
    return f"Not saved: {error.strerror or error}. What you typed is still here."
