"""The command that measures the frequency response of a scene in a loop: simulated, or on a board."""

import argparse
from typing import TYPE_CHECKING

import numpy as np

from hapkit_studio import devices
from hapkit_studio.analysis.bode import AMPLITUDE, COMPARED, CURVE_COLUMNS
from hapkit_studio.columns import Column, text_lines
from hapkit_studio.commands import base
from hapkit_studio.devices.base import Device
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.errors import ParameterError
from hapkit_studio.formatting import compact, hertz, with_unit
from hapkit_studio.haptics.board_plan import check_rate

if TYPE_CHECKING:
    from hapkit_studio.analysis.bode.result import Bode, Curve

NO_HAND = (
    "{title} has no hand that could drive its handle: omit --device, and describe its loop with --rate, "
    "--delay, --mass and --viscous."
)
_HANDLE = "mass", "viscous", "coulomb", "quantum"  # options of the handle, which a board sets itself
_OTHERWISE = "--rate", "--hand"
_PRINTED_EVERY = 3  # print only every third measured frequency
_COLUMNS = tuple(
    Column(title, lambda row, index=index: with_unit(float(row[index])), unit=unit)  # type: ignore[misc]
    for index, (title, unit) in enumerate((
        ("Frequency", "Hz"), ("|Z|", "N/m"), ("Phase", "°"), ("k", "N/m"), ("b", "N·s/m"),
        ("± 95 %", "N·s/m"), ("Coherence", ""),
    ))
)  # fmt: skip

OPTIONS = (
    base.ENVIRONMENT,
    base.TRUST,
    base.PARAMETER,
    base.option("--device", metavar="DEVICE", help="virtual-board; without: simulation"),
    base.option("--rate", metavar="Hz,Hz,…", help="of the loop, one or more; 1000"),
    base.option("--board-rate", type=float, metavar="Hz", help="of the board, by default the law's highest"),
    base.option("--amplitude", type=float, metavar="m", help=f"of the motion; {AMPLITUDE.default:g} or less"),
    base.option("--at", type=float, metavar="m", help="centre of the motion; by default at the scene"),
    *(given for given in base.SETTING_OPTIONS if given[0][0] not in _OTHERWISE),
    base.PLOT,
)


def run(options: argparse.Namespace) -> base.Result:
    """Measure the responses; draw them if requested."""
    # imported here because the import takes seconds
    from hapkit_studio.analysis.bode import on_board, simulation
    from hapkit_studio.charts.bode import bode_figure

    scene = base.environment_named(options.environment, options.trust)
    values = scene.values(base.key_values(options.parameter))
    device = _device(options)
    found = simulation.measure(scene, values, _settings(options, device), options.amplitude, options.at)
    if device.model is None:
        found = on_board.measure(found, options.board_rate, base.progress_line("motion"))
    return base.with_files(_text(found), found.as_json(), base.drawn(options.plot, bode_figure, found))


def _device(options: argparse.Namespace) -> Device:
    """Return a simulated device or the virtual board; raise ParameterError for invalid options."""
    check_rate(options.board_rate)
    device = devices.named(options.device) if options.device else SimulatedHapkit()
    if device.model is not None:
        if options.board_rate is not None:
            raise ParameterError("--board-rate is for --device virtual-board.")
        return device
    if not (device.has_board and device.simulated_hand):
        raise ParameterError(NO_HAND.format(title=device.title))
    own = next(iter(base.of_options(options, ("rate", *_HANDLE))), None)
    if own:
        raise ParameterError(f"{device.title} has its own {own}; leave the option out.")
    return device


def _settings(options: argparse.Namespace, device: Device) -> list[LoopSettings]:
    """Return the settings for each rate, with the handle of a simulated device."""
    model = device.model or SimulatedHapkit()
    given = {
        "mass": model.mass, "viscous": model.viscous, "coulomb": model.coulomb_force,
        "quantum": model.quantum,
        **base.of_options(options, (*_HANDLE, "delay", "estimator")),
    }  # fmt: skip
    usual = device.rate if device.model is not None and device.rate else LoopSettings.rate
    rates = [usual] if options.rate is None else base.numbers(options.rate, "Rates", "Hz", "1000,4000")
    return [LoopSettings(**given, rate=rate, controller=options.controller) for rate in rates]


def _text(found: "Bode") -> str:
    lines = [found.sentence, f"The handle was {found.driven}.", "", *text_lines(CURVE_COLUMNS, found.curves)]
    for curve in found.curves:
        lines += ["", f"{curve.name}{_error_text(curve)}"]
        one = curve.measured
        rows = zip(
            one.frequency, np.abs(one.impedance), np.degrees(np.angle(one.impedance)), one.stiffness,
            one.damping, curve.damping_interval, curve.coherence, strict=True,
        )  # fmt: skip
        lines += text_lines(_COLUMNS, list(rows)[::_PRINTED_EVERY])
        if curve.clamped:
            lines.append(
                f"The motor was at its limit in {compact(100.0 * curve.clamped, 2)} % of the samples."
            )
    return "\n".join(lines)


def _error_text(curve: "Curve") -> str:
    share, angle = curve.uncertainty
    highest = hertz(0.5 * COMPARED * curve.setting.rate)
    if curve.error is None:
        known = (
            f", each point known to {compact(100.0 * share, 2)} % up to {highest}" if share == share else ""
        )
        return f", by single sines{known}"
    share, angle = curve.error
    return f", within {compact(100.0 * share, 2)} % and {compact(angle, 2)}° of theory up to {highest}"


COMMAND = base.Command("bode", "draw the rendered impedance of a scene over frequency", run, OPTIONS, 65)
