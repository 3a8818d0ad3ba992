"""A grating stroked at a constant speed, simulated sample by sample."""

import math

import numpy as np

from hapkit_studio import environments
from hapkit_studio.analysis.failures import base
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.hand import Prescribed
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.environments.texture import GRATING
from hapkit_studio.formatting import with_unit
from hapkit_studio.haptics import rows
from hapkit_studio.parameters import Parameter

AMPLITUDE = 0.25
WANTED = 10  # number of samples, or of sensor counts, that a ridge needs
_FASTEST = 1.5  # m/s: speed of the fastest mouse swipe
WAVELENGTH = Parameter(
    "wavelength", "Wavelength", "m", 0.005, 0.0005, 0.02, "Distance from one ridge to the next", "λ"
)
SPEED = Parameter("speed", "Speed", "m/s", 0.5, 0.0, 100.0, "Speed of the stroke", "v")


def grating(wavelength: float, amplitude: float = AMPLITUDE) -> dict[str, float]:
    """Return the values of a grating."""
    values = environments.named("texture").values()
    return {**values, "kind": float(GRATING), "wavelength": wavelength, "amplitude": amplitude}


def swipe(speed: float) -> str:
    """Describe a mouse stroke with this speed in m/s by its time over the scene's 100 mm."""
    seconds = with_unit(0.1 / max(speed, 1e-3), "s", 2)
    fast = f"in {seconds}" if speed < _FASTEST else f"as fast as you can ({seconds} would be needed)"
    return f"Hold the handle and swipe over all 100 mm {fast}, then slowly, and compare."


def stroke(
    wavelength: float, speed: float, rate: float, quantum: float, samples: int, start: float = 0.0
) -> np.ndarray:
    """Return the rows (samples, …) of a handle that moves at ``speed`` m/s, starting at ``start`` m."""
    device = SimulatedHapkit(quantum=quantum, max_force=math.inf)
    hand = Prescribed(lambda t: start + speed * t)
    return base.render("texture", grating(wavelength), device, LoopSettings(rate), samples, hand)


def live(speed: float, case: base.Case) -> base.Live:
    """Return the live settings of the grating, in a loop so slow that a hand can exceed the limit."""
    return base.Live("texture", grating(case["wavelength"]), {"rate": case["rate"]}, advice=swipe(speed))


def ridges(out: np.ndarray, case: base.Case, what: str, shown: int) -> base.Evidence:
    """Return the force of ``shown`` samples, and the fewest samples or readings in a whole ridge."""
    place = out[:, rows.TRUE_POSITION] if what == "samples" else np.unique(out[:, rows.POSITION])
    # add a tolerance for rounding errors at a ridge's edge
    ridge = np.floor(place / case["wavelength"] + 1e-9).astype(int)
    counts = np.bincount(ridge - ridge.min())[1:-1]
    least = int(counts.min()) if len(counts) else len(place)
    peak = with_unit(100.0 * least_peak(out, case["wavelength"]), "%")
    text = f"the worst ridge gets {least} {what}; the weakest ridge gives {peak} of its force"
    force, step = out[:shown, rows.FORCE], 1.0 / case["rate"]
    return base.Evidence(force, step, "force", "N", least >= WANTED, float(least), what, text, held=True)


def least_peak(out: np.ndarray, wavelength: float) -> float:
    """Return the smallest peak force over complete ridges, as a fraction of the amplitude."""
    ridge = np.floor(out[:, rows.TRUE_POSITION] / wavelength + 1e-9).astype(int)
    peaks = np.full(ridge.max() - ridge.min() + 1, -np.inf)
    np.maximum.at(peaks, ridge - ridge.min(), out[:, rows.FORCE])
    return float(peaks[1:-1].min() / AMPLITUDE) if len(peaks) > 2 else float(peaks.max() / AMPLITUDE)
