"""The command that measures the Z-width: by simulation, or on a device with a hand that presses."""

import argparse
import math

from hapkit_studio.analysis import zwidth
from hapkit_studio.analysis.setting import Setting
from hapkit_studio.analysis.zwidth_protocol import MAX_FORCE, PUSH, SPEED, USUAL_DAMPING, Protocol
from hapkit_studio.analysis.zwidth_result import ZWidth, text
from hapkit_studio.commands.base import Command, Result, progress_line
from hapkit_studio.commands.given import ESTIMATOR_HELP, estimator_spec
from hapkit_studio.dynamics.hand import GRIPS
from hapkit_studio.errors import ParameterError

_USUAL = Setting()


def options(command: argparse.ArgumentParser) -> None:
    """Declare what ``zwidth`` takes."""
    command.add_argument("--damping", metavar="B,B,…", help="virtual dampings in N·s/m, e.g. 0,1,2,5")
    command.add_argument("--mass", type=float, default=_USUAL.mass, metavar="KG", help="of the handle")
    command.add_argument("--viscous", type=float, default=_USUAL.viscous, metavar="N·S/M", help="its own")
    command.add_argument("--coulomb", type=float, default=_USUAL.coulomb, metavar="N", help="its friction")
    command.add_argument("--quantum", type=float, default=_USUAL.quantum, metavar="M", help="of the sensor")
    command.add_argument("--rate", type=float, default=_USUAL.rate, metavar="HZ")
    command.add_argument("--delay", type=float, default=_USUAL.delay, metavar="S", help="sample to force")
    command.add_argument("--estimator", default="difference", metavar="NAME", help=ESTIMATOR_HELP)
    command.add_argument("--hand", default=_USUAL.hand, metavar="GRIP", help=", ".join(GRIPS))
    command.add_argument("--speed", type=float, default=SPEED.default, metavar="M/S", help=SPEED.help)
    command.add_argument("--push", type=float, default=PUSH.default, metavar="N", help=PUSH.help)
    command.add_argument("--max-force", type=float, metavar="N", help="the motor's limit")
    command.add_argument("--plot", metavar="PATH", help="write a picture")


def run(options: argparse.Namespace) -> Result:
    """Measure the Z-width; draw it where asked."""
    result = _simulated(options)
    written = []
    if options.plot:
        from hapkit_studio.charts.zwidth import zwidth_figure

        zwidth_figure(result, options.plot)
        written.append(str(options.plot))
    words = [text(result), *(f"wrote {path}" for path in written)]
    return Result("\n".join(words), {**result.as_json(), "written": written})


def _simulated(options: argparse.Namespace) -> ZWidth:
    fields = ("mass", "viscous", "coulomb", "quantum", "rate", "delay", "hand")
    given = {field: getattr(options, field) for field in fields}
    setting = Setting(**given, estimator=estimator_spec(options.estimator))
    force = math.inf if options.max_force is None else MAX_FORCE.check(options.max_force)
    protocol = Protocol(SPEED.check(options.speed), PUSH.check(options.push), max_force=force)
    return zwidth.compute(setting, dampings(options.damping), protocol, progress=progress_line("damping"))


def dampings(given: str | None) -> tuple[float, ...]:
    """Return the dampings in N·s/m of ``0,1,2``; raise ParameterError."""
    if given is None:
        return USUAL_DAMPING
    try:
        return tuple(float(word) for word in given.split(","))
    except ValueError:
        raise ParameterError(f"Dampings are numbers in N·s/m as 0,1,2,5, not {given!r}.") from None


COMMAND = Command("zwidth", "measure the stiffest wall at each virtual damping", run, options, order=60)
