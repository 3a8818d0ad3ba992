"""The command that identifies stiffness, damping, friction and mass from a recording."""

import argparse
import math
from typing import TYPE_CHECKING

from hapkit_studio import api
from hapkit_studio.commands.base import PLOT, Command, Result, drawn, option, with_files
from hapkit_studio.errors import ParameterError
from hapkit_studio.formatting import compact
from hapkit_studio.tables import UNITS, parse_column

if TYPE_CHECKING:
    from hapkit_studio.analysis.identify import Identified, Recording

_COLUMN = "of a foreign table: its {} as NAME:UNIT, in {}"
_HELP = "identify the rendered law and the handle from a recording, with 95 % intervals"


OPTIONS = (
    option(
        "recording", metavar="FILE", help="a session, a CSV of the studio's, or a table of another program"
    ),
    option("--from", dest="begin", type=float, metavar="s", help="start of the piece"),
    option("--to", dest="end", type=float, metavar="s", help="end of the piece"),
    option(
        "--terms", metavar="LIST", help="of the rendered force: stiffness,damping,friction; none: the scene's"
    ),
    *(
        option(f"--{quantity}", metavar="COLUMN", help=_COLUMN.format(quantity, ", ".join(units)))
        for quantity, units in UNITS.items()
    ),
    option("--released", action="store_true", help="no hand holds the handle in this piece"),
    PLOT,
)


def run(options: argparse.Namespace) -> Result:
    """Identify the parameters in a recording; draw the result if requested."""
    from hapkit_studio.analysis import identify as work  # imported here because the import takes seconds
    from hapkit_studio.charts.identify import identify_figure

    for limit in (options.begin, options.end):
        if limit is not None and not math.isfinite(limit):
            raise ParameterError(f"A piece begins and ends at a number of seconds, not {limit:g} s.")
    terms = tuple(word.strip() for word in options.terms.split(",")) if options.terms is not None else None
    given = {quantity: getattr(options, quantity) for quantity in UNITS}
    columns = {quantity: parse_column(quantity, text) for quantity, text in given.items() if text is not None}
    recording = api.open_recording(options.recording, columns)
    found = work.identify(
        recording, begin=options.begin, end=options.end, terms=terms, released=options.released
    )
    return with_files(_text(found, recording), found.as_json(), drawn(options.plot, identify_figure, found))


def _text(found: "Identified", recording: "Recording") -> str:
    lines = [f"The piece from {compact(found.begin, 3)} s to {compact(found.end, 3)} s:"]
    if recording.later:
        changes = f"The settings changed at {recording.change_times} s; a piece has no change in it."
        lines.insert(0, changes)
    handle = "Properties of the handle"
    if found.handle.estimates:
        handle += ", let go" if found.handle.released else ", the hand's mass with it"
    for title, part in (("Properties of the scene", found.rendered), (handle, found.handle)):
        lines += ["", title, *(f"  {line}" for line in found.sentences(part))]
    return "\n".join([*lines, "", found.force_known])


COMMAND = Command("identify", _HELP, run, OPTIONS, 70)
