"""Velocity estimators: how far each is from the true velocity, rendered by the loop's own tick.

The motions are seen by the simulated Hapkit's sensor for 3 s at 1 kHz. A tremor and the ramps begin 0.3 of a
count above an edge of the sensor, so that counts come in no rhythm. The cost is the whole tick's, with the
damping scene's law and the simulated handle: what a loop pays.
"""

import math
from collections.abc import Callable
from functools import cache, partial

import numpy as np

from hapkit_studio import environments
from hapkit_studio.analysis.accuracy.plan import Default, Method, Plan, Run, Scene
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.estimators import ESTIMATORS, USUAL, parse
from hapkit_studio.haptics import headless, rows
from hapkit_studio.haptics.settings import LoopSettings

QUANTUM, RATE, SECONDS = SimulatedHapkit().quantum, 1000.0, 3.0
_START = 0.3 * QUANTUM
_TURNED_AT, _TURNING = 1.0, 0.02

Signal = tuple[np.ndarray, np.ndarray]
T = np.arange(round(SECONDS * RATE)) / RATE


def sine(amplitude: float, frequency: float, start: float = 0.0) -> Signal:
    """Return position and velocity of a swing of so many m and Hz."""
    w = 2.0 * np.pi * frequency
    return start + amplitude * np.sin(w * T), amplitude * w * np.cos(w * T)


def ramp(speed: float) -> Signal:
    """Return position and velocity of a steady motion."""
    return _START + speed * T, np.full_like(T, speed)


def reversal(speed: float) -> Signal:
    """Return position and velocity of a motion that a blow turns round along a cosine, in 20 ms."""
    share = np.clip((T - _TURNED_AT) / _TURNING, 0.0, 1.0)
    turn = speed * _TURNING / np.pi * np.sin(np.pi * share)
    back = np.maximum(T - _TURNED_AT - _TURNING, 0.0)
    return speed * np.minimum(T, _TURNED_AT) + turn - speed * back, speed * np.cos(np.pi * share)


SIGNALS: dict[str, Callable[[], Signal]] = {
    "tremor": cache(lambda: sine(0.6 * QUANTUM, 8.0, _START)),
    "slow": cache(lambda: ramp(0.005)),
    "steady": cache(lambda: ramp(0.1)),
    "swing": cache(lambda: sine(0.02, 1.0)),
    "shake": cache(lambda: sine(0.002, 8.0)),
    "reversal": cache(lambda: reversal(0.2)),
}


JUDGED_FROM = round(0.3 * RATE)
_WHOLE_TURNS = slice(500, 2500)
SHORT = {"difference": "Difference", "iir": "IIR", "butterworth": "Butterworth", "foaw": "FOAW"}
SHORT |= {"kalman": "Kalman"}
VARIANTS: tuple[tuple[str, dict[str, float]], ...] = (
    ("difference", {}),
    *(("iir", {"cutoff": cutoff}) for cutoff in (20.0, 35.5, 60.0, 120.0)),
    *(("butterworth", {"cutoff": cutoff}) for cutoff in (20.0, 60.0, 120.0)),
    *(("foaw", {"window": 16.0, "noise": noise}) for noise in (1.0, 0.5)),
    *(("kalman", {"q": q}) for q in (1e-3, 1e-2, 1e-1)),
)
# A force that shakes by less than 20 mN counts as rest; the damping scene makes that of so many m/s.
UNFELT = 0.020
_DAMPING = environments.named("damping").values()["damping"]
_REASON = (
    f"At the damping scene's {_DAMPING:g} N·s/m this is {1e3 * UNFELT:g} mN, a vibration too weak to be felt"
)


def label(key: str, options: dict[str, float]) -> str:
    """Return an estimator with its options, short."""
    if key in ("iir", "butterworth"):
        return f"{SHORT[key]} {options['cutoff']:g} Hz"
    if key == "foaw":
        return f"FOAW {options['noise']:g} count" + ("" if options["noise"] <= 1.0 else "s")
    return f"Kalman q = {options['q']:g}" if key == "kalman" else SHORT[key]


def prepared(spec: tuple[str, dict[str, float]], signal: str) -> Callable[[], np.ndarray]:
    """Return what renders a signal once, and returns its telemetry rows."""
    position, velocity = SIGNALS[signal]()
    device = SimulatedHapkit(damping=0.0, coulomb_force=0.0, max_force=math.inf)
    law = environments.named("damping")
    loop, body = headless.Scene(law, law.values(), device, LoopSettings(RATE, 0.0, spec)).prepare()
    out = headless.new_rows(T.size)

    def work() -> np.ndarray:
        headless.run_prescribed(loop, body, position, velocity, out)
        return out

    return work


def estimated(spec: tuple[str, dict[str, float]], signal: str) -> np.ndarray:
    """Return the velocity (n,) in m/s that the loop saw."""
    return prepared(spec, signal)()[:, rows.VELOCITY]


@cache
def _lag(variant: int) -> float:
    """Return by how many s the estimate is late at 8 Hz: the phase of its fundamental, over whole turns."""
    wave = np.exp(-16j * np.pi * T[_WHOLE_TURNS])
    found = estimated(VARIANTS[variant], "shake")[_WHOLE_TURNS]
    ratio = np.sum(found * wave) / np.sum(SIGNALS["shake"]()[1][_WHOLE_TURNS] * wave)
    return float(-np.angle(ratio) / (16.0 * np.pi))


def runs(scene: Scene) -> list[Run]:
    """Return every estimator with every option on one signal."""
    signal, found = scene.key, []
    for variant, spec in enumerate(VARIANTS):
        key, options = spec
        off = (estimated(spec, signal) - SIGNALS[signal]()[1])[JUDGED_FROM:]
        rms, most = float(np.sqrt(np.mean(off * off))), float(np.abs(off).max())
        named, extra = tuple(options.items()), (("max_error_m_per_s", most), ("lag_s", _lag(variant)))
        work = partial(prepared, spec, signal)
        found.append(Run(key, label(key, options), 1.0 / RATE, rms, work, SECONDS, named, extra))
    return found


def _scene(key: str, title: str) -> Scene:
    default = Default(USUAL, 1.0 / RATE, tuple(parse(USUAL)[1].items()))
    conditions = (
        ("Sensor", f"{1e6 * QUANTUM:g} µm"),
        ("Rate", "1 kHz"),
        ("Judged", "from 0.3 s to 3 s"),
        ("Reference", "the true velocity"),
    )
    return Scene(
        key, title, "RMS error of the velocity", UNFELT / _DAMPING, _REASON, default, "m/s", conditions
    )


PLAN = Plan(
    "velocity",
    "Velocity",
    tuple(Method(key, SHORT[key]) for key in ESTIMATORS),
    (
        _scene("tremor", "Tremor, 0.6 counts, 8 Hz"),
        _scene("slow", "Steady 5 mm/s"),
        _scene("steady", "Steady 100 mm/s"),
        _scene("swing", "20 mm at 1 Hz"),
        _scene("shake", "2 mm at 8 Hz"),
        _scene("reversal", "Reversal of 200 mm/s"),
    ),
    runs,
    order=20,
)
