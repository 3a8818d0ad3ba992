"""Predict a failure in the program's window, on a device with friction, quantisation and a force limit."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from hapkit_studio import environments
from hapkit_studio.analysis.failures.base import Live
from hapkit_studio.analysis.stability.behaviour import behaviour
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.hand import gripping
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.formatting import on_screen, with_unit
from hapkit_studio.haptics import headless, rows

# s: time for which the mouse holds the handle; time observed after the release; last part of this time, which
# is evaluated
GRIP_SECONDS, WATCHED, END = 0.6, 4.0, 0.5
# m peak to peak: smallest visible oscillation
SEEN = 0.5e-3
# m: position at which the mouse lets go. At the motor's limit of 3 N, the handle stays 15 mm behind the
# pointer of a medium grip (200 N/m).
POINTER = 0.035
FROM, THROW = -0.03, 0.25  # m, m/s: start position and pointer speed of a throw
FARTHEST = 0.06  # m: largest position that the pointer reaches
_WHY = (
    "Dry friction and the motor's force limit of 3 N calm the handle. The stability limit on this page is "
    "computed without them."
)


def let_go(live: Live, pointer: float = POINTER, column: int = rows.TRUE_POSITION) -> float:
    """Return a column's peak-to-peak value after the mouse pulled to ``pointer`` m and let go."""
    out, rate = _released(live, lambda t: pointer * np.clip(2.0 * t / GRIP_SECONDS, 0.0, 1.0), GRIP_SECONDS)
    return float(np.ptp(out[-round(END * rate) :, column]))


def thrown(live: Live, wall: float) -> float:
    """Return the ratio of the speeds after and before a bounce off a wall at the position ``wall`` in m."""
    out, _ = _released(
        live, lambda t: FROM + THROW * np.maximum(t - GRIP_SECONDS, 0.0), GRIP_SECONDS + (wall - FROM) / THROW
    )
    x, speed = out[:, rows.TRUE_POSITION], out[:, rows.TRUE_VELOCITY]
    there = int(np.argmax(x > wall))
    back = there + int(np.argmax(x[there:] < wall))
    return float(-speed[back] / speed[there])


def _scene(live: Live) -> headless.Scene:
    """Return the live settings as a scene of the headless loop, with the window's device."""
    environment = environments.named(live.environment)
    values = environment.values(live.values)
    device = SimulatedHapkit().reduced(environment.needed_at(values))
    return headless.Scene(environment, values, device, LoopSettings().changed(**live.loop))


def _released(live: Live, target: Callable, release: float) -> tuple[np.ndarray, float]:
    """Return the rows (n, …) and their rate in Hz while a medium grip follows target(t) and then lets go."""
    scene, hand = _scene(live), gripping(target, grip=live.grip, release=release)
    rate = scene.loop.rate
    return headless.render(scene, hand, round((GRIP_SECONDS + WATCHED) * rate))[0], rate


def behind(place: float, stiffness: float) -> float:
    """Return the pointer position in m at which a spring in N/m and a medium grip balance at ``place`` m."""
    force = min(stiffness * place, SimulatedHapkit.max_force)
    return min(place + force / gripping().stiffness, FARTHEST)


def pulled(
    make: Callable[[float], Live], value: float, bound: float, key: str, unit: str, pointer: float = POINTER
) -> Live:
    """Return ``make(value)`` with an instruction that states what the released handle does.

    ``make`` returns the live scene for a value of the knob, whose limit is ``bound``. ``key`` is the
    parameter that the knob sets.
    """
    live = make(value)
    cut = value > 1.001 * live.values[key]
    most = f" The slider in the window ends at {with_unit(live.values[key], unit, 4)}." if cut else ""
    does = behaviour(_scene(live), None)
    why = f" {_WHY}" if does.calm and value > bound else ""
    outcome = ". The handle comes to rest." if does.calm else f". {does.sentence(in_hand=False)}"
    return replace(live, advice=f"Drag to {on_screen(pointer, 'm')} and let go{outcome}{why}{most}")
