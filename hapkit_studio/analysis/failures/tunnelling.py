"""A bump that is crossed between two samples: the faster the handle, the less of a thin bump is rendered."""

import math

import numpy as np

from hapkit_studio.analysis.failures import base, spring
from hapkit_studio.analysis.failures.stroking import swipe
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.environments.bump_valley import BUMP
from hapkit_studio.formatting import with_unit
from hapkit_studio.haptics import rows

WANTED = 4
# number of sampling phases at which throws reach the bump; the worst phase decides
PHASES = 64
# N: peak force of the bump, so weak that the handle's speed does not change
PEAK = 0.002
_COSINE = 1.0
# % of the bump's height: upper end of the chart
MOST_SHOWN = 120.0


def limit(case: base.Case) -> float:
    """Return the limit w/(4 T) in m/s, with the bump's width w and the period T."""
    return case["width"] * case["rate"] / WANTED


def throws(speed: float, case: base.Case) -> list[np.ndarray]:
    """Return the rows of throws over the bump, one per sampling phase."""
    travel = speed / case["rate"]
    given = {"peak_force": PEAK, "width": case["width"], "profile": _COSINE}
    count, found = math.ceil(case["width"] / travel) + 4, []
    for phase in (np.arange(PHASES) + 0.5) / PHASES:
        start = BUMP - 0.5 * case["width"] - (1.0 + phase) * travel
        device = SimulatedHapkit(case["mass"], 0.0, 0.0, 0.0, math.inf, start, speed)
        out = base.render("bump_valley", given, device, LoopSettings(case["rate"]), count)
        # exclude the far half, where the force changes sign
        found.append(out[out[:, rows.TRUE_POSITION] < 0.0])
    return found


def least_peak(runs: list[np.ndarray]) -> float:
    """Return the smallest peak of the absolute force over all throws, as a fraction of the full peak."""
    return min(float(np.abs(out[:, rows.FORCE]).max()) for out in runs) / PEAK


def missed(runs: list[np.ndarray], case: base.Case) -> float:
    """Return the largest energy error of a throw over the bump, in % of the bump's height."""
    works = (np.sum(out[:-1, rows.FORCE] * np.diff(out[:, rows.TRUE_POSITION])) for out in runs)
    return 100.0 * max(abs(float(work)) for work in works) / (PEAK * 2.0 / math.tau * case["width"])


def shown(speed: float, case: base.Case) -> float:
    """Return the largest energy error in %, NaN if it exceeds the chart."""
    energy = missed(throws(speed, case), case)
    return energy if energy <= MOST_SHOWN else math.nan


def probe(speed: float, case: base.Case) -> base.Evidence:
    """Throw the handle over the bump at one speed, at every sampling phase."""
    runs = throws(speed, case)
    felt = [int(np.count_nonzero(out[:, rows.FORCE])) for out in runs]
    least, peak = min(felt), with_unit(100.0 * least_peak(runs), "%")
    energy = with_unit(missed(runs, case), "%", 2)
    text = f"the worst throw gets {least} samples; the weakest throw gives {peak} of the force"
    text += f"; the energy changes by up to {energy}"
    force, step = 100.0 * runs[felt.index(least)][:, rows.FORCE] / PEAK, 1.0 / case["rate"]
    holds = least >= WANTED
    return base.Evidence(force, step, "force", "% of the peak", holds, least, "samples", text, held=True)


def theory(speed: float, case: base.Case) -> float:
    """Return the smallest peak in % over all phases, for samples of a sine that are v T/w apart."""
    stretch = speed / (case["width"] * case["rate"])
    offsets = np.linspace(0.0, 1.0, 401)[:, None]
    places = stretch * (offsets + np.arange(math.ceil(1.0 / stretch) + 1))
    waves = np.where(places < 1.0, np.abs(np.sin(math.tau * places)), 0.0)
    return 100.0 * float(waves.max(axis=1).min())


def live(speed: float, case: base.Case) -> base.Live:
    """Return the live settings of the bump, with the case's width if the window allows it."""
    values = base.within("bump_valley", {"peak_force": 1.0, "width": case["width"], "profile": _COSINE})
    return base.Live("bump_valley", values, {"rate": case["rate"]}, advice=swipe(speed))


FAILURE = base.Failure(
    key="tunnelling",
    title="A bump crossed between two samples",
    summary="A handle that is fast enough crosses a narrow bump with little force or none",
    formula="v ≤ w/(4T), with speed v, width w of the bump and period T; above w/T the handle can pass "
    "without any sample on the bump",
    explanation="Between two samples the handle moves by v T, and nothing in between is rendered. A bump "
    "of width w needs four samples, one for each quarter of its wave, to give at least 71 % of its force. "
    "With two it may give almost nothing, and at v = w/T or faster, the handle can pass without a single "
    "sample on the bump. The force missed uphill differs from the force missed downhill, so the crossing "
    "also gains or loses energy.",
    knob=base.Parameter(
        "speed", "Speed", "m/s", 1.0, 1e-3, 500.0, "Speed at which the handle is thrown", "v"
    ),
    limit=limit,
    probe=probe,
    plot=base.Plot(
        "speed, m/s",
        np.geomspace(0.2, 6.0, 26),
        (
            base.Curve("theory for the worst throw", theory, base.THEORY),
            base.Curve("peak force, simulation", lambda v, case: 100.0 * least_peak(throws(v, case))),
            base.Curve("energy gained or lost", shown, base.OTHER),
        ),
        "w/(4T)",
        lambda case: {"w/T: no sample": WANTED * limit(case)},
        log_x=True,
        y_label="worst throw, % of the peak or of the energy",
        level=None,
    ),
    options=(
        base.Parameter(
            "width", "Width of the bump", "m", 0.005, 5e-4, 0.04, "Width of the bump at its base", "w"
        ),
        spring.MASS,
        spring.RATE,
    ),
    live=live,
    span=(0.2, 5.0),
    order=14,
)
