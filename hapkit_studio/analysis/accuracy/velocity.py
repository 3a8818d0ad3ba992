"""Velocity estimators: the error of each estimator, computed with the loop's own tick.

The simulated Hapkit's sensor measures each test motion for 3 s at 1 kHz. Tremor and ramps start 0.3 counts
above an edge, so that counts are not periodic. The cost is that of the whole tick with the damping scene's
law and the simulated handle.
"""

import math
from collections.abc import Iterator
from functools import partial

import numpy as np

from hapkit_studio import environments
from hapkit_studio.analysis.accuracy.plan import Motion, Plan, Point, Run, Scene
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.estimators import ESTIMATORS
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.haptics import headless, rows

QUANTUM, RATE, SECONDS = SimulatedHapkit().quantum, 1000.0, 3.0
_START, _TREMOR = 0.3 * QUANTUM, 0.6 * QUANTUM
_TURNED_AT, _TURNING = 1.0, 0.02
Signal = tuple[np.ndarray, np.ndarray]
T = np.arange(round(SECONDS * RATE)) / RATE


def _sine(amplitude: float, frequency: float, start: float = 0.0) -> Signal:
    w = 2.0 * np.pi * frequency
    return start + amplitude * np.sin(w * T), amplitude * w * np.cos(w * T)


def _ramp(speed: float) -> Signal:
    return _START + speed * T, np.full_like(T, speed)


def _reversal(speed: float) -> Signal:
    """Return a motion in which a collision reverses the velocity along a cosine in 20 ms."""
    share = np.clip((T - _TURNED_AT) / _TURNING, 0.0, 1.0)
    turn = speed * _TURNING / np.pi * np.sin(np.pi * share)
    back = np.maximum(T - _TURNED_AT - _TURNING, 0.0)
    return speed * np.minimum(T, _TURNED_AT) + turn - speed * back, speed * np.cos(np.pi * share)


SIGNALS: dict[str, tuple[str, Signal]] = {
    "tremor": (f"Hand tremor ±{1e6 * _TREMOR:.0f} µm at 8 Hz", _sine(_TREMOR, 8.0, _START)),
    "slow": ("Steady 5 mm/s", _ramp(0.005)),
    "steady": ("Steady 100 mm/s", _ramp(0.1)),
    "swing": ("20 mm at 1 Hz", _sine(0.02, 1.0)),
    "shake": ("2 mm at 8 Hz", _sine(0.002, 8.0)),
    "reversal": ("Reversal at 200 mm/s", _reversal(0.2)),
}
JUDGED_FROM = round(0.3 * RATE)
SHORT = {key: key.upper() if key in ("iir", "foaw") else key.capitalize() for key in ESTIMATORS}
VARIANTS: tuple[tuple[str, dict[str, float]], ...] = (
    ("difference", {}),
    *(("iir", {"cutoff": cutoff}) for cutoff in (20.0, 35.5, 60.0, 120.0)),
    *(("butterworth", {"cutoff": cutoff}) for cutoff in (20.0, 60.0, 120.0)),
    *(("foaw", {"window": 16.0, "noise": noise}) for noise in (1.0, 0.5)),
    *(("kalman", {"q": q}) for q in (1e-3, 1e-2, 1e-1)),
)
# N: weakest vibration of a force that people feel; divided by the damping below, it gives the tolerance of
# the velocity
UNFELT = 0.020
_DAMPING = environments.named("damping").values()["damping"]
_REASON = (
    f"In the damping scene ({_DAMPING:g} N·s/m), this velocity error gives {1e3 * UNFELT:g} mN of force, "
    "too little to feel"
)


def label(key: str, options: dict[str, float]) -> str:
    """Return a short label of an estimator with its options."""
    written = {"cutoff": "{:g} Hz", "noise": "{:g} count", "q": "q = {:g}"}
    parts = [written[name].format(value) for name, value in options.items() if name in written]
    return " ".join([SHORT[key], *parts])


def estimated(spec: tuple[str, dict[str, float]], signal: str, times: int = 1) -> Motion:
    """Return the estimation of a signal's velocity; its error is the rms from JUDGED_FROM on."""
    position, velocity = SIGNALS[signal][1]
    device = SimulatedHapkit(damping=0.0, coulomb_force=0.0, max_force=math.inf)
    law = environments.named("damping")
    loop, body = headless.Scene(law, law.values(), device, LoopSettings(RATE, 0.0, spec)).prepare()
    out = headless.new_rows(T.size)

    def work() -> None:
        for _ in range(times):
            headless.run_prescribed(loop, body, position, velocity, out)

    def error() -> float:
        off = (out[:, rows.VELOCITY] - velocity)[JUDGED_FROM:]
        return float(np.sqrt(np.mean(off * off)))

    return work, error


def runs(scene: Scene) -> Iterator[Run]:
    """Yield the runs of every estimator with every option on one signal."""
    for spec in VARIANTS:
        yield Point(spec[0], label(*spec), 1.0 / RATE), partial(estimated, spec, scene.key), SECONDS


CONDITIONS = (("Sensor", f"{1e6 * QUANTUM:g} µm"), ("Rate", "1 kHz"), ("Judged", "from 0.3 s to 3 s"))
PLAN = Plan(
    "velocity",
    "Velocity",
    "Which velocity estimate is nearest to the true velocity, and at what cost?",
    SHORT,
    tuple(
        Scene(key, title, "RMS error of the velocity", UNFELT / _DAMPING, _REASON, "m/s", CONDITIONS)
        for key, (title, _) in SIGNALS.items()
    ),
    runs,
    order=20,
)
