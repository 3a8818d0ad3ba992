"""Servo rate: the accuracy of a wall at several rates, and the cost of the ticks of one second.

The wall has 800 N/m, the highest stiffness that students choose on a Hapkit. A hand taps on it. The handle's
path is compared with the path at a wall that is rendered at FINE_RATE.
"""

import math
from collections.abc import Iterator
from functools import cache, partial

import numpy as np

from hapkit_studio import environments
from hapkit_studio.analysis.accuracy.plan import FELT, Motion, Plan, Point, Run, Scene, board_cycles
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.hand import SCRIPTS
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.haptics import headless, rows

RATES = (250.0, 500.0, 1000.0, 2000.0, 4000.0, 8000.0, 10_000.0)
STIFFNESS = 800.0
TAP_SECONDS = 0.8
DELAYS = {"prompt": 0.0, "late": 1e-3}  # s: without a delay, and with the delay of a USB port
LABELS = {"prompt": "No delay", "late": "1 ms delay"}
FINE_RATE = 1_000_000.0  # Hz: a multiple of all other rates
DEVICE = SimulatedHapkit(quantum=0.0)  # the sensor is ideal, so that only the rate has an effect


def _scene(rate: float, delay: float) -> headless.Scene:
    law = environments.named("wall")
    return headless.Scene(law, law.values({"stiffness": STIFFNESS}), DEVICE, LoopSettings(rate, delay))


@cache
def continuous() -> np.ndarray:
    """Return the handle's path in m at FINE_RATE, with a value every 25 µs."""
    count = round(TAP_SECONDS * FINE_RATE) + 1
    return headless.render_every(_scene(FINE_RATE, 0.0), SCRIPTS["tap"], count, 25)[:, rows.TRUE_POSITION]


def tap(rate: float, delay: float, times: int = 1) -> Motion:
    """Return the motion of the handle in a tap on the wall.

    Its error is the largest distance from the handle's true path, divided by the deepest penetration.
    """
    made = headless.prepare_run(_scene(rate, delay), SCRIPTS["tap"], round(times * TAP_SECONDS * rate))

    def error() -> float:
        true, place = continuous(), environments.named("wall").values()["position"]
        rendered = made.out[:, rows.TRUE_POSITION]
        at = np.arange(rendered.size) * round(FINE_RATE / 25.0 / rate)
        return float(np.abs(rendered - true[at]).max() / (true.max() - place))

    return made.run, error


def runs(scene: Scene) -> Iterator[Run]:
    """Yield the runs of every rate, with and without the delay."""
    for method, delay in DELAYS.items():
        for rate in RATES:
            cycles = math.nan if delay else board_cycles("wall", "damping_mode", "into", rate)
            point = Point(method, LABELS[method], 1.0 / rate, cycles=cycles)
            yield point, partial(tap, rate, delay), TAP_SECONDS


CONDITIONS = (
    ("Wall", f"{STIFFNESS:,g} N/m"), ("Handle", "0.044 kg, 0.5 N·s/m, an ideal sensor"),
    ("Hand", "taps, medium grip"), ("Reference", "the same wall at 1 MHz"),
)  # fmt: skip
_REASON = f"{FELT}. Force is proportional to depth"
_ERROR = "largest error / deepest penetration"
PLAN = Plan(
    "servo",
    "Servo rate",
    "How accurate is a wall at each servo rate, and at what cost?",
    LABELS,
    (Scene("contact", "A tap on a wall", _ERROR, 0.02, _REASON, "", CONDITIONS),),
    runs,
    order=30,
)
