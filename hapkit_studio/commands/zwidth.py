"""The command that measures the Z-width: by simulation, or on a device with a hand that presses."""

import argparse
import math
import sys

from hapkit_studio import devices
from hapkit_studio.analysis.zwidth import (
    DEVICE_DAMPING,
    DEVICE_FORCE,
    MAX_FORCE,
    PUSH,
    SIMULATED_DAMPING,
    SPEED,
    on_device,
    simulation,
)
from hapkit_studio.analysis.zwidth.guarded_device import TrialLimits
from hapkit_studio.analysis.zwidth.result import Protocol, ZWidth, text
from hapkit_studio.charts.zwidth import zwidth_figure
from hapkit_studio.commands.base import (
    Command,
    Result,
    of_options,
    progress_line,
    setting_of,
    setting_options,
)
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.devices.virtual_board import VirtualBoard
from hapkit_studio.errors import ParameterError
from hapkit_studio.figures import new_figure
from hapkit_studio.haptics.engine import Engine

# What a setting and the command call the same; a board has its own.
_HANDLE = ("mass", "viscous", "coulomb", "quantum")
_SHORT = {"virtual": "virtual-board"}


def options(command: argparse.ArgumentParser) -> None:
    """Declare what ``zwidth`` takes."""
    numbers = (
        ("speed", "m/s", f"at which the wall is hit; {SPEED.default:g}"),
        ("push", "N", f"into the wall; {PUSH.default:g}"),
        ("max-force", "N", f"the motor's limit; none, on a device {DEVICE_FORCE.default:g}"),
    )
    command.add_argument("--device", metavar="DEVICE", help="simulated, virtual, a port; without: simulation")
    command.add_argument("--damping", metavar="B,B,…", help="virtual dampings in N·s/m, e.g. 0,1,2,5")
    for name, unit, words in numbers:
        command.add_argument(f"--{name}", type=float, metavar=unit, help=words)
    setting_options(command)
    command.add_argument("--plot", metavar="PATH", help="write a picture")


def run(options: argparse.Namespace) -> Result:
    """Measure the Z-width; draw it where asked."""
    if options.plot:
        new_figure(options.plot, (1.0, 1.0))  # before a minute of pressing, not after
    result = _on_device(options) if options.device else _simulated(options)
    written = []
    if options.plot:
        zwidth_figure(result, options.plot)
        written.append(str(options.plot))
    words = [text(result), *(f"wrote {path}" for path in written)]
    return Result("\n".join(words), {**result.as_json(), "written": written})


def _simulated(options: argparse.Namespace) -> ZWidth:
    force = math.inf if options.max_force is None else MAX_FORCE.check(options.max_force)
    protocol = Protocol(**of_options(options, ("speed", "push")), max_force=force)
    levels = dampings(options.damping, SIMULATED_DAMPING)
    return simulation.compute(setting_of(options), levels, protocol, progress=progress_line("damping"))


def _on_device(options: argparse.Namespace) -> ZWidth:
    """Measure on a device of its own; Ctrl+C, too, leaves it with a zero command."""
    hit = {"hit": options.speed} if options.speed is not None else {}
    limits = TrialLimits(**of_options(options, ("max_force", "push")), **hit)
    levels = dampings(options.damping, DEVICE_DAMPING)
    device = _device(options)
    engine = Engine(device, "wall")
    if options.hand is not None:
        engine.set_grip(options.hand)
    engine.start()
    try:
        loop = of_options(options, ("rate", "delay", "estimator"))
        engine.set_loop(**loop, controller=options.controller)
        engine.set_model("everything")
        watch = progress_line("trial")
        return on_device.measure(engine, levels, limits, progress=watch, say=_say)
    finally:
        engine.close()


def _device(options: argparse.Namespace) -> object:
    device = devices.named(_SHORT.get(options.device, options.device))
    given = of_options(options, _HANDLE)
    if not isinstance(device, SimulatedHapkit):
        if given:
            raise ParameterError(f"{device.title} has its own {next(iter(given))}; leave the option out.")  # type: ignore[attr-defined]
        # as fast as it goes: nobody watches, and a busy machine changes nothing it does
        return VirtualBoard("lockstep") if isinstance(device, VirtualBoard) else device
    own = {"viscous": "damping", "coulomb": "coulomb_force"}
    return SimulatedHapkit(**{own.get(name, name): value for name, value in given.items()})


def _say(words: str) -> None:
    print(words, file=sys.stderr, flush=True)


def dampings(given: str | None, usual: tuple[float, ...]) -> tuple[float, ...]:
    """Return the dampings in N·s/m of ``0,1,2``; raise ParameterError."""
    if given is None:
        return usual
    try:
        return tuple(float(word) for word in given.split(","))
    except ValueError:
        raise ParameterError(f"Dampings are numbers in N·s/m as 0,1,2,5, not {given!r}.") from None


COMMAND = Command("zwidth", "measure the stiffest wall at each virtual damping", run, options, order=60)
