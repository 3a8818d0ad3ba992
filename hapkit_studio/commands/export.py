"""The command that exports an environment with its values as an Arduino sketch."""

import argparse
import contextlib

from hapkit_studio.analysis.stability import on_board
from hapkit_studio.commands import base
from hapkit_studio.devices import profiles
from hapkit_studio.devices.hapkit import HapkitBoard
from hapkit_studio.dynamics.estimators import USUAL
from hapkit_studio.errors import ParameterError
from hapkit_studio.haptics.board_plan import ESTIMATORS
from hapkit_studio.protocol.messages import Origin
from hapkit_studio.workshop import sketch
from hapkit_studio.workshop.own import switched_off

OPTIONS = (
    base.ENVIRONMENT,
    base.TRUST,
    base.PARAMETER,
    base.option("-o", "--output", metavar="PATH", help="wall.ino makes the folder wall with wall.ino"),
    base.option("--force", action="store_true", help="overwrite an existing sketch"),
    base.option("--kit", metavar="KEY", help=", ".join(kit.key for kit in profiles.KITS)),
    base.option("--port", metavar="PORT", help="use the settings of the board on this port"),
    base.option("--rate", type=int, metavar="Hz", help=", ".join(map(str, sketch.RATES))),
    base.option("--estimator", default=USUAL, metavar="NAME", help=", ".join(ESTIMATORS)),
    base.option("--prints", type=int, default=10, metavar="1/s", help="lines on the serial monitor"),
)


def run(options: argparse.Namespace) -> base.Result:
    """Write the sketch; raise ParameterError or LawError for wrong input, DeviceError if a board fails."""
    found = base.environment_named(options.environment, options.trust)
    values = found.values(base.key_values(options.parameter))
    kit = _kit(options.kit, options.port)
    rate = sketch.usual_rate(found, values) if options.rate is None else options.rate
    spec = base.estimator_spec(options.estimator)
    sketch.check(rate, spec, options.prints)
    verdict = on_board.sketch_verdict(found, values, kit.board, rate, spec)
    warning = on_board.sketch_text(verdict, rate)
    text = sketch.text(found, values, kit, rate, spec, options.prints, warning)
    path = sketch.write_sketch(options.output or found.key, text, options.force)
    whose = f"{kit.board.label}, {'calibrated' if kit.calibrated else 'the usual numbers of such a kit'}"
    numbers = {
        "written": str(path),
        "kit": kit.board.label,
        "calibrated": kit.calibrated,
        "rate_Hz": rate,
        "stiffness_limit": verdict.limit,
        "stable": verdict.calm,
        "remarks": [{"line": remark.line, "text": remark.text} for remark in found.force.remarks],
    }
    lines = f"wrote {path}\nfor {whose}; open it in the Arduino IDE, board Arduino Uno, and upload"
    drifts = [str(remark) for remark in found.force.remarks]
    lines = "\n".join([lines, warning, *drifts, *switched_off(found)])
    return base.Result(lines, {"environment": found.key, **numbers})


def _kit(key: str | None, port: str | None) -> sketch.Kit:
    """Return the kit with a key, the kit of the board on a port, or the default kit."""
    if key and port:
        raise ParameterError("Name a kit or a port, not both.")
    if port is None:
        return sketch.Kit(profiles.named(key).board) if key else sketch.Kit()
    with contextlib.closing(HapkitBoard(port)) as board:
        board.open()
        settings = board.settings()
    return sketch.Kit(profiles.of_settings(settings), settings.origin in (Origin.STORED, Origin.UNSAVED))


COMMAND = base.Command("export", "write an environment as an Arduino sketch", run, OPTIONS, 36)
