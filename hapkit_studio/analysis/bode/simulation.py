"""The rendered impedance in simulation: the exact loop with imposed handle motion."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hapkit_studio.analysis.bode import AMPLITUDE
from hapkit_studio.analysis.bode.drive import Drive
from hapkit_studio.analysis.bode.result import Bode, Curve, Spectra, linear_law
from hapkit_studio.analysis.simulated_handle import simulated_handle
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.environments.base import Environment, Values
from hapkit_studio.haptics import patience, rows
from hapkit_studio.haptics.headless import Scene, new_rows, run_prescribed

_PRESSED = 1.1  # depth in a surface as a multiple of the amplitude, so that the motion stays inside
_REPEATS = 16  # a stiff wall limits the motion to a few sensor steps, so many repeats are averaged
_SMALLER = 0.8  # factor on the amplitude for the next attempt after the motor saturated


def measure(
    environment: Environment,
    values: Values,
    settings: Sequence[LoopSettings],
    amplitude: float | None = None,
    place: float | None = None,
    max_force: float = SimulatedHapkit.max_force,
) -> Bode:
    """Return the response of a scene in several loops.

    ``amplitude`` is in m; None uses the default, reduced until the motor stays below its limit ``max_force``
    in N. ``place`` is in m; None uses the scene's centre, or a point inside its surface. A nonlinear law is
    excited by single sines. Raise ParameterError for an invalid amplitude, and LawError if the law is too
    slow.
    """
    reach = AMPLITUDE.default if amplitude is None else AMPLITUDE.check(amplitude)
    while True:
        at = environment.touched_at(values, _PRESSED * reach) if place is None else place
        sines = linear_law(environment, values, at, reach) is None
        drives = [Drive(at, reach, s.rate, sines, _REPEATS) for s in settings]
        curves = [
            _curve(environment, values, *each, max_force) for each in zip(settings, drives, strict=True)
        ]
        clamped = any(curve.clamped for curve in curves)
        if amplitude is not None or not clamped or _SMALLER * reach < AMPLITUDE.low:
            return Bode(environment, values, at, reach, tuple(curves))
        reach *= _SMALLER


def _curve(
    environment: Environment, values: Values, setting: LoopSettings, drive: Drive, max_force: float
) -> Curve:
    device = replace(simulated_handle(setting), max_force=max_force)
    r, body = Scene(environment, values, device, setting).prepare()
    out = new_rows(round(drive.motions * drive.slot * setting.rate))
    times = np.arange(len(out) + 1) / setting.rate
    position = drive.position(times)
    run_prescribed(r, body, position, np.gradient(position) * setting.rate, out)
    patience.check(r, environment.title)
    spectra, law = Spectra(drive), linear_law(environment, values, drive.place, drive.amplitude)
    for motion in range(drive.motions):
        first = round(drive.begin(motion) * setting.rate)
        part = slice(first, first + drive.samples)
        edges = times[first : first + drive.samples + 1] + setting.delay
        spectra.add(motion, times[part], position[part], edges, out[part, rows.APPLIED_FORCE])
    clamped = np.mean(out[:, rows.FLAGS].astype(int) & rows.CLAMPED != 0)
    return spectra.curve("simulated", setting, float(clamped), law)
