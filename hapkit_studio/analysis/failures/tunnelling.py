"""A bump crossed between two looks: the faster the handle, the less of a thin bump is there at all."""

import math

import numpy as np

from hapkit_studio import environments
from hapkit_studio.analysis.failures import base
from hapkit_studio.analysis.failures.spring import MASS, RATE
from hapkit_studio.analysis.failures.stroking import swipe
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.environments.bump_valley import BUMP
from hapkit_studio.formatting import with_unit
from hapkit_studio.haptics import headless, rows
from hapkit_studio.haptics.settings_writer import LoopSettings

WANTED = 4
# Throws that differ in where between two samples the bump begins; the worst one counts.
PHASES = 64
# So weak a bump that the handle keeps its speed.
PEAK = 0.002
_COSINE = 1.0
# Energies beyond this many percent of the hill's height are off the chart.
MOST_SHOWN = 120.0
_SHARES = np.geomspace(0.2, 6.0, 26)


def limit(case: base.Case) -> float:
    """Return w/(4 T) in m/s."""
    return case["width"] * case["rate"] / WANTED


def thrown(speed: float, case: base.Case, phase: float) -> np.ndarray:
    """Return the rows of one throw over the bump; phase, 0 to 1: where between samples it begins."""
    values = environments.named("bump_valley").values()
    values |= {"peak_force": PEAK, "width": case["width"], "profile": _COSINE}
    way = speed / case["rate"]
    start = BUMP - 0.5 * case["width"] - (1.0 + phase) * way
    device = SimulatedHapkit(case["mass"], 0.0, 0.0, 0.0, math.inf, start, speed)
    scene = headless.Scene(environments.named("bump_valley"), values, device, LoopSettings(case["rate"]))
    out = headless.render(scene, None, math.ceil(case["width"] / way) + 4)[0]
    # beyond the middle the valley begins
    return out[out[:, rows.TRUE_POSITION] < 0.0]


def inside(out: np.ndarray) -> int:
    """Return how many samples felt the bump."""
    return int(np.count_nonzero(out[:, rows.ASKED]))


def throws(speed: float, case: base.Case) -> list[np.ndarray]:
    """Return the rows of throws at every phase."""
    return [thrown(speed, case, (k + 0.5) / PHASES) for k in range(PHASES)]


def least_peak(runs: list[np.ndarray]) -> float:
    """Return the least share of the peak force that a throw was given, up the bump or down."""
    return min(float(np.abs(out[:, rows.ASKED]).max()) for out in runs) / PEAK


def probe(speed: float, case: base.Case) -> base.Evidence:
    """Throw the handle over the bump at one speed, at every phase."""
    runs = throws(speed, case)
    worst = min(runs, key=inside)
    least = inside(worst)
    energy = with_unit(100.0 * missed(runs) / case["width"], "%", 2)
    peak = with_unit(100.0 * least_peak(runs), "%")
    words = f"{least} samples at the least, {peak} of the force; energy off by {energy}"
    force = 100.0 * worst[:, rows.ASKED] / PEAK
    time = np.arange(len(worst)) / case["rate"]
    return base.Evidence(
        time, force, "force", "% of the peak", least >= WANTED, float(least), "samples", words, held=True
    )


def missed(runs: list[np.ndarray]) -> float:
    """Return the most energy that a throw gains or loses over the bump, as a share of the hill's height."""
    hill = PEAK * 2.0 / math.tau
    found = []
    for out in runs:
        place, force = out[:, rows.TRUE_POSITION], out[:, rows.ASKED]
        found.append(abs(float(np.sum(force[:-1] * np.diff(place)))))
    return max(found) / hill


def curve(case: base.Case, progress: base.Progress) -> base.Chart:
    """Return over the speed how much of the bump the worst throw feels, and the energy it gains or loses."""
    speeds, peaks, energies = limit(case) * _SHARES, [], []
    for done, speed in enumerate(speeds, 1):
        runs = throws(float(speed), case)
        peaks.append(100.0 * least_peak(runs))
        energy = 100.0 * missed(runs) / case["width"]
        energies.append(energy if energy <= MOST_SHOWN else np.nan)
        progress(done, len(speeds))
    lines = (
        base.Line("worst sample, theory", speeds, 100.0 * _theory(speeds, case), base.THEORY),
        base.Line("peak force, rendered", speeds, np.array(peaks)),
        base.Line("energy gained or lost", speeds, np.array(energies), base.OTHER),
    )
    marks = (base.Mark("w/(4T)", limit(case)), base.Mark("w/T: unseen", WANTED * limit(case)))
    return base.Chart("speed, m/s", "worst throw, % of the whole", lines, marks, log_x=True)


def _theory(speeds: np.ndarray, case: base.Case) -> np.ndarray:
    """Return the least largest |sin| that samples a stretch u = v T/w apart can have in one wave."""
    u = speeds / (case["width"] * case["rate"])
    offsets = np.linspace(0.0, 1.0, 401)[:, None]
    least = []
    for step in u:
        places = step * (offsets + np.arange(math.ceil(1.0 / step) + 1))
        waves = np.where(places < 1.0, np.abs(np.sin(math.tau * places)), 0.0)
        least.append(waves.max(axis=1).min())
    return np.array(least)


def live(speed: float, case: base.Case) -> base.Live:
    """Return the bump in the window, as narrow as it can be set."""
    arguments = {"peak_force": 1.0, "width": case["width"], "profile": _COSINE}
    advice = swipe(speed)
    return base.Live(
        "bump_valley", base.within("bump_valley", arguments), {"rate": case["rate"]}, "medium", advice
    )


FAILURE = base.Failure(
    key="tunnelling",
    title="A bump crossed between two looks",
    summary="Thrown fast enough, the handle passes a thin bump with hardly a force, or none",
    formula="v ≤ w/(4T); beyond w/T it can pass unseen",
    explanation="Between two looks the handle moves by v T, and what lies there is not rendered. A bump "
    "of width w needs four samples, one for each quarter of its wave, to give at least 71 % of its "
    "force; with two it may give nearly nothing, and from v = w/T on the handle can pass without a "
    "single sample on it. What is left out up the hill is not what is left out down, so the crossing "
    "also gains or loses energy.",
    knob=base.Parameter("speed", "Speed", "m/s", 1.0, 1e-3, 500.0, "Of the throw", "v"),
    limit=limit,
    probe=probe,
    curve=curve,
    options=(
        base.Parameter("width", "Width of the bump", "m", 0.005, 5e-4, 0.04, "From foot to foot", "w"),
        MASS,
        RATE,
    ),
    live=live,
    span=(0.2, 5.0),
    order=14,
)
