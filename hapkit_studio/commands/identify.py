"""The command that identifies stiffness, damping, friction and mass from a recorded piece."""

import argparse
import math

from hapkit_studio.commands.base import Command, Result
from hapkit_studio.errors import ParameterError

_HELP = "what was rendered, and what the handle is, from a recording, with 95 % intervals"


def options(command: argparse.ArgumentParser) -> None:
    """Declare what ``identify`` takes."""
    command.add_argument("recording", metavar="CSV", help="a file written by: run … --csv run.csv")
    command.add_argument("--from", dest="begin", type=float, metavar="S", help="where the piece begins")
    command.add_argument("--to", dest="end", type=float, metavar="S", help="where the piece ends")
    command.add_argument(
        "--terms", metavar="LIST", help="of the rendered force: stiffness,damping,friction; none: the scene's"
    )
    command.add_argument("--released", action="store_true", help="no hand holds the handle in this piece")
    command.add_argument("--plot", metavar="PATH", help="draw force over position and velocity, with the fit")


def run(options: argparse.Namespace) -> Result:
    """Identify the piece; draw it where asked."""
    from hapkit_studio.analysis import identify as work

    for limit in (options.begin, options.end):
        if limit is not None and not math.isfinite(limit):
            raise ParameterError(f"A piece begins and ends at a number of seconds, not {limit:g} s.")
    terms = tuple(word.strip() for word in options.terms.split(",")) if options.terms is not None else None
    recording = work.from_csv(options.recording)
    found = work.identify(
        recording, begin=options.begin, end=options.end, terms=terms, released=options.released
    )
    written = []
    if options.plot:
        from hapkit_studio.charts.identify import identify_figure

        identify_figure(found, options.plot)
        written.append(str(options.plot))
    return Result(_text(found, written), _as_json(found, written))


def _text(found, written: list[str]) -> str:
    lines = [f"The piece from {found.begin:.3g} s to {found.end:.3g} s:"]
    for part in (found.rendered, found.handle):
        lines.append("")
        lines.append("What was rendered" if part.key == "rendered" else _handle_title(part))
        lines += [f"  {line}" for line in found.sentences(part)]
    return "\n".join(lines + [f"wrote {path}" for path in written])


def _handle_title(part) -> str:
    if not part.estimates:
        return "What the handle is"
    return "What the handle is, let go" if part.released else "What the handle is, the hand's mass with it"


def _as_json(found, written: list[str]) -> dict:
    return {
        "from_s": found.begin,
        "to_s": found.end,
        "parts": {part.key: _part(found, part) for part in (found.rendered, found.handle)},
        "written": written,
    }


def _part(found, part) -> dict:
    return {
        "estimates": [
            {
                "key": e.key,
                "unit": e.term.unit,
                "value": _finite(e.value),
                "low": _finite(e.low),
                "high": _finite(e.high),
                "set": e.asked,
                "expected": e.expected,
                "told": e.told,
            }
            for e in part.estimates
        ],
        "explained": _finite(part.explained),
        "motion_Hz": _finite(part.hertz),
        "used_s": part.seconds,
        "released": part.released,
        "left_out": part.left_out,
        "words": found.sentences(part),
    }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


COMMAND = Command("identify", _HELP, run, options, order=70)
