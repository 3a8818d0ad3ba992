"""The measurements that a check can use. Each is a function that is applied to a recorded interval.

A function returns the value in SI with the half width of its 95 % confidence interval, or raises NotMeasured
with the reason and the remedy. Forces are the commanded ones; the force at the handle is not measured.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from hapkit_studio.analysis import oscillation, statistics
from hapkit_studio.errors import ParameterError
from hapkit_studio.formatting import number, on_screen
from hapkit_studio.lessons.samples import Samples, runs

Region = tuple[float, float] | None

PRESS, WINDOW, TOUCH, PASS = "press", "window", "touch", "pass"
_FIT_SECONDS = 0.015  # s: duration of the fits of the speed before and after a contact
_TREMBLE = 2.0  # a handle is at rest if its positions span at most this many sensor steps
_REST_SECONDS = 0.5
_PURRS = (15.0, 40.0)  # Hz: frequency range of the purring; the cat's pitch is 20 to 30 Hz
_PURR_SPAN = 6.0  # Hz: maximum span of the strong frequencies of one purr, whose frequency varies by 2.4 Hz
_CLEAR = 6.0  # minimum ratio of a spectral peak to the median of its band
_RINGS = (5.0, 400.0)  # Hz: frequency range of a ringing surface
_SWINGS = 6  # minimum number of extremes of a free oscillation for a measurement
_EXACT = 1e-4  # a confidence interval with a smaller relative width is not shown
# m/s: friction at speeds below the first value is compared with friction at speeds above the second value
_SLOW, _FAST = 0.005, 0.03
_STEADY = 0.02  # m/s: maximum change per sample in the velocity of an object that moves freely


class Measured(NamedTuple):
    """A value in SI and the half width of its 95 % confidence interval."""

    value: float
    half: float = 0.0


class NotMeasured(Exception):
    """An interval is not sufficient for a measurement; the message contains the reason and the remedy."""


@dataclass(frozen=True)
class Measurement:
    """A measurement with its name, unit and function, and its kind of interval.

    ``intervals``: "press" is a contact, or a window in a scene without a surface. "window" has a fixed
    duration. "touch" is a contact with a margin before and after it. "pass" is a passage through a region.
    """

    key: str
    label: str
    unit: str
    compute: Callable[[Samples, Region], Measured]
    intervals: str = WINDOW
    seconds: float = 3.0
    decimals: int | None = None
    needs_region: bool = False

    def text(self, value: float) -> str:
        """Format a value with its unit."""
        if self.decimals is not None:
            return f"{number(value, self.decimals)} {self.unit}".rstrip()
        if self.unit == "J":
            return f"{number(1e3 * value, 2)} mJ"
        return on_screen(value, self.unit, 3)

    def interval_text(self, found: Measured) -> str:
        """Format a value with its confidence interval."""
        if not found.half > _EXACT * abs(found.value) or not math.isfinite(found.half):
            return self.text(found.value)
        if self.decimals is not None:
            half = number(found.half, self.decimals)
            return f"{number(found.value, self.decimals)} ± {half} {self.unit}".rstrip()
        scale, unit = _screen_unit(self.unit, found.value)
        places = max(0, -math.floor(math.log10(scale * found.half)))
        return f"{number(scale * found.value, places)} ± {number(scale * found.half, places)} {unit}".rstrip()


def _screen_unit(unit: str, value: float) -> tuple[float, str]:
    if unit == "J":
        return 1e3, "mJ"
    return (1e3, f"m{unit}") if unit == "m" or (unit == "s" and abs(value) < 1.0) else (1.0, unit)


# --- rendered terms


def _identified(name: str) -> Callable[[Samples, Region], Measured]:
    """Return the function that identifies a term of the rendered force."""

    def compute(samples: Samples, region: Region) -> Measured:
        from hapkit_studio.analysis import identify  # imported late because it takes seconds

        known = samples.scene[0].force_terms(samples.scene[1]).terms if samples.scene else ()
        terms = None if name in known else (name,)
        try:
            part = identify.identify(identify.from_run(samples), terms=terms).rendered
        except ParameterError as error:
            raise NotMeasured(f"{error} Move for longer.") from None
        names = (name, f"{name}_in") if name == "damping" else (name,)
        found = next((e for e in part.estimates if e.key in names and math.isfinite(e.half)), None)
        if found is None or not found.determined:
            raise NotMeasured(
                (found.advice if found else part.advice)
                or "The value is uncertain. Move farther in both directions."
            )
        return Measured(found.value, found.half)

    return compute


def _delay(samples: Samples, region: Region) -> Measured:
    """Return the delay in s of a pure spring, from its identified damping −K(T/2 + delay)."""
    stiffness, damping = _identified("stiffness")(samples, None), _identified("damping")(samples, None)
    if not stiffness.value > 0.0:
        raise NotMeasured("The delay can be measured only on a spring or a wall. Set a stiffness above zero.")
    set_damping = samples.scene[1].get("damping", 0.0) if samples.scene else 0.0
    late = (set_damping - damping.value) / stiffness.value - 0.5 * samples.period
    return Measured(late, damping.half / stiffness.value)


def _slope(samples: Samples, region: Region) -> Measured:
    """Return the slope of force over position; it is positive for a restoring force."""
    depth = samples.depth
    selected = np.ones(len(samples), bool) if depth is None else depth > 0.0
    selected &= np.abs(samples.applied_force) > 0.0
    found = (
        statistics.line(samples.position, -samples.applied_force, selected) if selected.sum() > 32 else None
    )
    if found is None:
        raise NotMeasured("The force did not change. Press into the surface and change the depth.")
    return Measured(found.slope, found.half)


def _peak_force(samples: Samples, region: Region) -> Measured:
    return Measured(float(np.abs(samples.applied_force).max()))


def _work(samples: Samples, region: Region) -> Measured:
    """Return the work that the device does on the handle during its passage through the region."""
    moved = np.diff(samples.position)
    step = 0.5 * samples.quantum * float(np.abs(samples.applied_force).max())
    return Measured(float(samples.applied_force[:-1] @ moved), step)


# --- contact


def _energy_per_bounce(samples: Samples, region: Region) -> Measured:
    """Return the energy that the surface gives to the handle in one contact."""
    inside = _inside(samples)
    given = float(samples.energy[inside.stop - 1] - samples.energy[inside.start])
    return Measured(given, 0.5 * samples.quantum * float(np.abs(samples.applied_force).max()))


def _restitution(samples: Samples, region: Region) -> Measured:
    """Return the ratio of the speeds after and before a contact."""
    inside = _inside(samples)
    count = max(round(_FIT_SECONDS / samples.period), 4)
    before = _speed(samples.cut(slice(max(inside.start - count, 0), inside.start)))
    after = _speed(samples.cut(slice(inside.stop, inside.stop + count)))
    if abs(before.value) < 5.0 * before.half:
        raise NotMeasured("You were too slow. Hit the surface at 50 mm/s or faster.")
    ratio = abs(after.value / before.value)
    return Measured(
        ratio, ratio * math.hypot(before.half / before.value, after.half / max(abs(after.value), 1e-6))
    )


def _inside(samples: Samples) -> slice:
    found = runs(samples.depth > 0.0) if samples.depth is not None else []
    if not found:
        raise NotMeasured("The handle did not touch the surface.")
    return slice(found[0].start, found[-1].stop)


def _speed(samples: Samples) -> Measured:
    """Return the mean velocity from a straight line fitted to the positions, and its quantisation error."""
    if len(samples) < 4:
        raise NotMeasured("The contact is too close to the beginning or the end of the recording.")
    time = samples.time - samples.time.mean()
    spread = float(np.sqrt(np.sum(time**2)))
    slope = float(time @ samples.position) / spread**2
    return Measured(slope, 1.96 * samples.quantum / math.sqrt(12.0) / spread)


def _transient(index: int) -> Callable[[Samples, Region], Measured]:
    """Return the function that fits the ringing of a surface after the handle has hit it.

    ``index`` selects the result of the function: the frequency (1) or the decay (2).
    """

    def compute(samples: Samples, region: Region) -> Measured:
        from scipy.optimize import OptimizeWarning, curve_fit

        inside = _inside(samples)
        part = samples.cut(inside)
        if samples.scene is None or part.depth is None:
            raise NotMeasured(
                "The ringing can be measured only in the scene Hard surface. Choose this scene."
            )
        values = samples.scene[1]
        if "frequency" not in values:
            raise NotMeasured(
                "The ringing can be measured only in the scene Hard surface. Choose this scene."
            )
        since = part.time - part.time[0]
        rest = -part.force - values["stiffness"] * part.depth
        rest -= values["damping"] * np.maximum(part.velocity, 0.0)
        selected = (since < 0.2) & (np.abs(rest) < 0.98 * values["limit"])
        if selected.sum() < 20 or np.abs(rest[selected]).max() < 0.05:
            raise NotMeasured("There is no ringing. Hit the surface once, at 0.1 m/s.")
        time, force = since[selected], rest[selected]
        start = _strongest(time, force)

        def ringing(
            t: np.ndarray, strength: float, frequency: float, decay: float, phase: float
        ) -> np.ndarray:
            return strength * np.exp(-decay * t) * np.sin(math.tau * frequency * t + phase)

        best: tuple[float, Measured] | None = None
        for decay in (20.0, 60.0, 150.0):
            try:
                found, covariance = curve_fit(
                    ringing, time, force, (float(np.abs(force).max()), start, decay, 0.0), maxfev=2000
                )
            except (RuntimeError, OptimizeWarning):
                continue
            left = float(np.sum((ringing(time, *found) - force) ** 2))
            half = 1.96 * math.sqrt(abs(covariance[index, index]))
            if best is None or left < best[0]:
                best = left, Measured(abs(float(found[index])), half)
        if best is None or best[0] > 0.25 * float(np.sum(force**2)):
            raise NotMeasured(
                "The ringing after the hit is not clear. Hit the surface once, at 0.1 m/s, and stay inside."
            )
        return best[1]

    return compute


def _strongest(time: np.ndarray, values: np.ndarray) -> float:
    """Return the frequency in Hz of the strongest component of a short signal."""
    tried = np.geomspace(*_RINGS, 300)
    basis = np.exp(-2j * math.pi * tried[:, None] * time)
    return float(tried[int(np.abs(basis @ values).argmax())])


def _oscillation(samples: Samples) -> oscillation.Oscillation:
    found = oscillation.sustained(samples.time, samples.position)
    if found is None:
        raise NotMeasured("The handle does not oscillate all the time. Wait until it oscillates by itself.")
    return found


def _oscillation_frequency(samples: Samples, region: Region) -> Measured:
    found = _oscillation(samples)
    if not math.isfinite(found.frequency):
        raise NotMeasured("The oscillation has no clear frequency. Wait until the oscillation is steady.")
    return Measured(found.frequency, 0.1 / float(np.ptp(samples.time)))


def _oscillation_amplitude(samples: Samples, region: Region) -> Measured:
    return Measured(_oscillation(samples).amplitude, samples.quantum)


def _rest(samples: Samples, region: Region) -> Measured:
    """Return the peak-to-peak motion of the handle in the interval."""
    return Measured(float(np.ptp(samples.position)))


def _largest_push(samples: Samples, region: Region) -> Measured:
    """Return the largest distance of the handle from its rest position."""
    last = samples.between(float(samples.time[-1]) - _REST_SECONDS, float(samples.time[-1]))
    if np.ptp(last.position) > _TREMBLE * samples.quantum:
        moved = on_screen(float(np.ptp(last.position)), "m", 2)
        raise NotMeasured(f"The handle still moves by {moved}. Release it and wait until it rests.")
    return Measured(float(np.abs(samples.position - last.position.mean()).max()), samples.quantum)


def _purring(samples: Samples, region: Region) -> Measured:
    """Return the frequency of the purring in the applied force."""
    window = np.hanning(len(samples))
    force = samples.applied_force - samples.applied_force.mean()
    power = np.abs(np.fft.rfft(window * force)) ** 2
    frequency = np.fft.rfftfreq(len(samples), samples.period)
    band = (frequency >= _PURRS[0]) & (frequency <= _PURRS[1])
    strong = band & (power > 0.25 * power[band].max(initial=0.0))
    unclear = not strong.any() or power[band].max() < _CLEAR * np.median(power[band])
    if unclear or np.ptp(frequency[strong]) >= _PURR_SPAN:
        raise NotMeasured("The cat does not purr. Stroke it from head to tail at 1 to 10 cm/s.")
    found = float(np.average(frequency[strong], weights=power[strong]))
    return Measured(found, 1.0 / float(np.ptp(samples.time)))


def _vibration(samples: Samples, region: Region) -> Measured:
    """Return the dominant frequency of the applied force."""
    found = statistics.dominant(samples.time, samples.applied_force)
    if not math.isfinite(found):
        raise NotMeasured("The force has no clear frequency. Move at a constant speed.")
    return Measured(found, 0.5 / float(np.ptp(samples.time)))


def _spatial_period(samples: Samples, region: Region) -> Measured:
    """Return the distance in m between ridges of the force."""
    reach = float(np.ptp(samples.position))
    if reach < 50.0 * samples.quantum:
        raise NotMeasured("The handle hardly moves. Stroke across the ridges.")
    order = np.argsort(samples.position, kind="stable")
    place, force = samples.position[order], samples.applied_force[order]
    even = np.linspace(place[0], place[-1], 2048)
    known, at = np.unique(place, return_index=True)
    found = statistics.dominant(even, np.interp(even, known, force[at]))
    if not math.isfinite(found):
        raise NotMeasured("The force does not repeat over the position. Move slowly across more ridges.")
    return Measured(1.0 / found, 0.25 / found**2 / reach)


# --- sticking and slipping


def _slips(samples: Samples) -> tuple[np.ndarray, np.ndarray]:
    """Return the start times in s (n,) and distances in m (n,) of slips."""
    from scipy.ndimage import uniform_filter1d

    # The speed is averaged over 10 ms, because a single sensor step within a millisecond is not a slip.
    count = max(round(0.010 / samples.period), 1)
    speed = np.abs(uniform_filter1d(np.gradient(samples.position, samples.time), count))
    mean = float(np.ptp(samples.position) / np.ptp(samples.time))
    steps = samples.quantum / 0.010
    parts = [p for p in runs(speed > max(2.0 * mean, 2.0 * steps)) if p.start > 0 and p.stop < len(speed)]
    length = np.array([abs(samples.position[p.stop - 1] - samples.position[p.start]) for p in parts])
    selected = length > max(8.0 * samples.quantum, 0.25 * float(length.max(initial=0.0)))
    if selected.sum() < 4:
        raise NotMeasured(
            f"There are {int(selected.sum())} slips, but at least 4 are needed. Pull slowly, in one "
            "direction."
        )
    return samples.time[[p.start for p in parts]][selected], length[selected]


def _stick_slip_period(samples: Samples, region: Region) -> Measured:
    times, _ = _slips(samples)
    return _mean(np.diff(times))


def _stick_slip_amplitude(samples: Samples, region: Region) -> Measured:
    return _mean(_slips(samples)[1])


def _mean(values: np.ndarray) -> Measured:
    """Return the mean and the half width of its 95 % confidence interval, from Student's t."""
    from scipy.stats import t

    count = len(values)
    half = (
        float(np.std(values, ddof=1)) / math.sqrt(count) * float(t.ppf(0.975, count - 1))
        if count > 1
        else math.inf
    )
    return Measured(float(values.mean()), half)


def _clicks(samples: Samples, region: Region) -> Measured:
    """Return the number of clicks."""
    if samples.scene is None or not samples.scene[0].counts:
        raise NotMeasured("This scene has no click. Choose the scene Button.")
    counted = samples.count(samples.scene[0].counts[0])
    assert counted is not None  # environments with ``counts`` have the counts in their state
    return Measured(float(np.sum(np.diff(counted) > 0.0)))


def _object(samples: Samples) -> np.ndarray:
    if not samples.moves:
        raise NotMeasured("There is no object in this scene.")
    return next(iter(samples.moves.values()))


def _free_swing(samples: Samples) -> tuple[np.ndarray, np.ndarray]:
    """Return the times in s and positions in m of the extremes of an object's free oscillation."""
    from scipy.signal import find_peaks

    place = _object(samples)
    free = runs(samples.applied_force == 0.0)
    longest = max(free, key=lambda part: part.stop - part.start, default=slice(0, 0))
    place, time = place[longest], samples.time[longest]
    if not len(place) or np.ptp(place) < 20e-6:
        raise NotMeasured("The object does not swing freely. Push it, move the handle away and wait.")
    away = place - 0.5 * (place.max() + place.min())
    least = 0.05 * float(np.ptp(away))
    found = np.sort(np.concatenate([find_peaks(s * away, prominence=least)[0] for s in (1.0, -1.0)]))
    if len(found) < _SWINGS:
        raise NotMeasured(
            f"The object swung {len(found)} times, but at least {_SWINGS} swings are needed. Wait longer."
        )
    return time[found], away[found]


def _object_growth(samples: Samples, region: Region) -> Measured:
    """Return the growth rate of an object's free oscillation in 1/s.

    It is negative if the oscillation decays.
    """
    from scipy.stats import linregress, t

    time, away = _free_swing(samples)
    swing = np.abs(np.diff(away))
    fit = linregress(time[:-1], np.log(swing))
    return Measured(float(fit.slope), float(fit.stderr * t.ppf(0.975, len(swing) - 2)))


def _object_frequency(samples: Samples, region: Region) -> Measured:
    time, _ = _free_swing(samples)
    half = _mean(np.diff(time))
    return Measured(0.5 / half.value, 0.5 * half.half / half.value**2)


def _object_restitution(samples: Samples, region: Region) -> Measured:
    """Return the ratio of an object's speeds after and before a bounce, averaged over all bounces."""
    place = _object(samples)
    speed = np.gradient(place, samples.time)
    steady = np.abs(np.gradient(speed)) < _STEADY * samples.period
    moving = steady & (np.abs(speed) > 0.01) & (samples.applied_force == 0.0)
    flights = [float(np.median(speed[part])) for part in runs(moving) if part.stop - part.start > 20]
    pairs = [(a, b) for a, b in pairwise(flights) if a * b < 0.0]
    if not pairs:
        raise NotMeasured("The object did not bounce. Push it towards a wall and move the handle away.")
    ratios = np.array([abs(b / a) for a, b in pairs])
    return Measured(float(ratios.mean()), _mean(ratios).half if len(ratios) > 1 else 0.0)


def _object_speed(samples: Samples, region: Region) -> Measured:
    return Measured(float(np.abs(np.gradient(_object(samples), samples.time)).max()))


def _rate(samples: Samples, region: Region) -> Measured:
    gaps = np.diff(samples.time)
    mean = float(gaps.mean())
    return Measured(1.0 / mean, 1.96 * float(gaps.std()) / mean**2 / math.sqrt(len(gaps)))


def _position(samples: Samples, region: Region) -> Measured:
    return Measured(float(samples.position.mean()), 1.96 * float(samples.position.std()))


def _travel(samples: Samples, region: Region) -> Measured:
    return Measured(float(np.ptp(samples.position)))


def _friction_ratio(samples: Samples, region: Region) -> Measured:
    """Return the ratio of the largest force on a slow handle to the median force on a fast handle.

    The ratio depends on the friction model: it is 1 for Coulomb friction, more with static or Stribeck
    friction, and less with viscous friction.
    """
    count = max(round(0.020 / samples.period), 1)
    if len(samples) <= count:
        raise NotMeasured("The recording is too short.")
    moved = samples.position[count:] - samples.position[:-count]
    speed = np.abs(moved) / (count * samples.period)
    force = np.abs(samples.applied_force[count // 2 : count // 2 + len(moved)])
    fast, slow = force[speed > max(_FAST, 0.5 * speed.max())], force[speed < _SLOW]
    if len(fast) < count:
        raise NotMeasured(f"You moved at up to {on_screen(float(speed.max()), 'm/s', 2)}. Move faster.")
    if not len(slow):
        raise NotMeasured("Change direction slowly, so that the handle nearly stops at each turn.")
    level = float(np.median(fast))
    if level == 0.0:
        raise NotMeasured("The moving handle felt no force. Set a friction above zero.")
    value = float(slow.max()) / level
    # Samples within 20 ms of one another are not independent.
    return Measured(value, value * 1.96 * float(fast.std()) / level / math.sqrt(max(len(fast) / count, 1.0)))


def _peak_speed(samples: Samples, region: Region) -> Measured:
    """Return the highest speed, averaged over 20 ms to suppress quantisation."""
    count = max(round(0.020 / samples.period), 1)
    if len(samples) <= count:
        raise NotMeasured("The recording is too short.")
    moved = samples.position[count:] - samples.position[:-count]
    return Measured(float(np.abs(moved).max()) / (count * samples.period))


def _table(entries: Sequence[Measurement]) -> dict[str, Measurement]:
    return {entry.key: entry for entry in entries}


MEASUREMENTS = _table(
    (
        Measurement("stiffness", "Stiffness", "N/m", _identified("stiffness"), PRESS),
        Measurement("damping", "Damping", "N·s/m", _identified("damping"), PRESS),
        Measurement("friction", "Friction", "N", _identified("friction")),
        Measurement(
            "friction_ratio", "Friction ratio (slow / fast)", "", _friction_ratio, seconds=5.0, decimals=2
        ),
        Measurement("slope", "Slope", "N/m", _slope, PRESS),
        Measurement("peak_force", "Peak force", "N", _peak_force, PRESS),
        Measurement("work", "Work", "J", _work, PASS, needs_region=True),
        Measurement("energy_per_bounce", "Energy per bounce", "J", _energy_per_bounce, TOUCH),
        Measurement("restitution", "Speed after / before a hit", "", _restitution, TOUCH, decimals=2),
        Measurement("transient_frequency", "Ringing frequency", "Hz", _transient(1), TOUCH),
        Measurement("transient_decay", "Decay of the ringing", "1/s", _transient(2), TOUCH),
        Measurement(
            "oscillation_frequency", "Oscillation frequency", "Hz", _oscillation_frequency, seconds=1.0
        ),
        Measurement(
            "oscillation_amplitude", "Oscillation amplitude", "m", _oscillation_amplitude, seconds=1.0
        ),
        Measurement("rest", "Range of the movement", "m", _rest, seconds=1.0),
        Measurement("largest_push", "Farthest distance from rest", "m", _largest_push),
        Measurement("purring", "Purring frequency", "Hz", _purring, seconds=2.5),
        Measurement("vibration", "Vibration frequency", "Hz", _vibration, seconds=0.5),
        Measurement("spatial_period", "Distance between ridges", "m", _spatial_period),
        Measurement("stick_slip_period", "Stick–slip period", "s", _stick_slip_period, seconds=5.0),
        Measurement("stick_slip_amplitude", "Slip distance", "m", _stick_slip_amplitude, seconds=5.0),
        Measurement("clicks", "Number of clicks", "", _clicks, decimals=0),
        Measurement("object_growth", "Growth rate of the swing", "1/s", _object_growth, seconds=10.0),
        Measurement("object_frequency", "Swing frequency", "Hz", _object_frequency, seconds=6.0),
        Measurement(
            "object_restitution",
            "Speed after / before a bounce",
            "",
            _object_restitution,
            seconds=6.0,
            decimals=3,
        ),
        Measurement("object_speed", "Speed of the object", "m/s", _object_speed),
        Measurement("delay", "Delay", "s", _delay, PRESS),
        Measurement("rate", "Rate", "Hz", _rate, seconds=1.0),
        Measurement("position", "Position", "m", _position, seconds=1.0),
        Measurement("travel", "Distance moved", "m", _travel),
        Measurement("peak_speed", "Peak speed", "m/s", _peak_speed),
    )
)


@dataclass(frozen=True)
class Need:
    """A required movement: a function that measures it, its unit, and a message if it is too small."""

    compute: Callable[[Samples], float]
    unit: str
    sentence: str

    def short(self, value: float, least: float) -> str:
        """Return the sentence that compares the movement with the required one."""
        return self.sentence.format(on_screen(value, self.unit, 2), on_screen(least, self.unit, 3))


NEEDS = {
    "depth": Need(
        lambda s: 0.0 if s.depth is None else max(float(s.depth.max()), 0.0),
        "m",
        "You pressed {} deep. Press at least {} deep.",
    ),
    "travel": Need(lambda s: float(np.ptp(s.position)), "m", "You moved {}. Move at least {}."),
    "speed": Need(
        lambda s: _peak_speed(s, None).value if s.time[-1] - s.time[0] > 0.05 else 0.0,
        "m/s",
        "You moved at up to {}. Move at {} or faster.",
    ),
    "force": Need(
        lambda s: float(np.abs(s.applied_force).max()), "N", "The force reached {}. Press with at least {}."
    ),
    "seconds": Need(
        lambda s: float(s.time[-1] - s.time[0]), "s", "The movement lasted {}. Continue for at least {}."
    ),
}
"""The requirements that a check can have on the movement, by name."""
