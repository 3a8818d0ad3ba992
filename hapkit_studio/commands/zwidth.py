"""The command that measures the Z-width: by simulation, or on a device with a pressing hand."""

import argparse
import contextlib
import math
import sys
from dataclasses import replace
from functools import partial

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
from hapkit_studio.charts.style import new_figure
from hapkit_studio.charts.zwidth import zwidth_figure
from hapkit_studio.commands import base
from hapkit_studio.devices.base import Device
from hapkit_studio.errors import ParameterError
from hapkit_studio.haptics.engine import Engine

# options of the handle, which are also fields of LoopSettings; a board sets them itself
_HANDLE = ("mass", "viscous", "coulomb", "quantum")
_SHORT = {"virtual": "virtual-board"}


OPTIONS = (
    base.option("--device", metavar="DEVICE", help="simulated, virtual, a port; without: simulation"),
    base.option("--damping", metavar="B,B,…", help="virtual dampings in N·s/m, e.g. 0,1,2,5"),
    base.option("--speed", type=float, metavar="m/s", help=f"at which the wall is hit; {SPEED.default:g}"),
    base.option("--push", type=float, metavar="N", help=f"into the wall; {PUSH.default:g}"),
    base.option(
        "--max-force",
        type=float,
        metavar="N",
        help=f"the motor's limit; by default none, on a device {DEVICE_FORCE.default:g}",
    ),
    *base.SETTING_OPTIONS,
    base.PLOT,
)


def run(options: argparse.Namespace) -> base.Result:
    """Measure the Z-width; draw it if requested."""
    if options.plot:
        new_figure(options.plot, (1.0, 1.0))  # check the path first, because the measurement takes a minute
    result = _on_device(options) if options.device else _simulated(options)
    return base.with_files(text(result), result.as_json(), base.drawn(options.plot, zwidth_figure, result))


def _simulated(options: argparse.Namespace) -> ZWidth:
    force = math.inf if options.max_force is None else MAX_FORCE.check(options.max_force)
    protocol = Protocol(**base.of_options(options, ("speed", "push")), max_force=force)
    levels = dampings(options.damping, SIMULATED_DAMPING)
    return simulation.compute(
        base.setting_of(options), levels, protocol, progress=base.progress_line("damping")
    )


def _on_device(options: argparse.Namespace) -> ZWidth:
    """Measure on a device that is opened for this measurement; the force is zero afterwards."""
    hit = {"hit": options.speed} if options.speed is not None else {}
    limits = TrialLimits(**base.of_options(options, ("max_force", "push")), **hit)
    levels = dampings(options.damping, DEVICE_DAMPING)
    with contextlib.closing(Engine(_device(options), "wall")) as engine:
        if options.hand is not None:
            engine.set_loop(hand=options.hand)
        engine.start()
        loop = base.of_options(options, ("rate", "delay", "estimator"))
        engine.set_loop(**loop, controller=options.controller)
        engine.set_loop(model="everything")
        instruct = partial(print, file=sys.stderr, flush=True)
        return on_device.measure(
            engine, levels, limits, progress=base.progress_line("trial"), instruct=instruct
        )


def _device(options: argparse.Namespace) -> Device:
    device = devices.named(_SHORT.get(options.device, options.device))
    given = base.of_options(options, _HANDLE)
    if device.model is None:
        if given:
            raise ParameterError(f"{device.title} has its own {next(iter(given))}; leave the option out.")
        return device.unpaced()
    own = {"viscous": "damping", "coulomb": "coulomb_force"}
    changes = {own.get(name, name): value for name, value in given.items()}
    return replace(device.model, end_stops=math.inf, **changes)


def dampings(given: str | None, usual: tuple[float, ...]) -> tuple[float, ...]:
    """Return the dampings in N·s/m in a text such as ``0,1,2``; raise ParameterError for an invalid text."""
    return usual if given is None else base.numbers(given, "Dampings", "N·s/m", "0,1,2,5")


COMMAND = base.Command("zwidth", "measure the stiffest wall at each virtual damping", run, OPTIONS, 60)
