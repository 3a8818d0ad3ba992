"""Evaluates a check on recorded samples: chooses the newest suitable interval and describes the result."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

from hapkit_studio import environments
from hapkit_studio.dynamics.loop_settings import DELAY, ESTIMATOR, RATE
from hapkit_studio.formatting import on_screen
from hapkit_studio.lessons.lesson import Check
from hapkit_studio.lessons.measurements import (
    MEASUREMENTS,
    NEEDS,
    PASS,
    PRESS,
    TOUCH,
    Measured,
    Measurement,
    NotMeasured,
)
from hapkit_studio.lessons.samples import Samples, runs
from hapkit_studio.parameters import AnyParameter, Choice

CORRECT, WRONG, WAITING = "correct", "wrong", "waiting"
_MARGIN = 0.030  # s: this time before and after a contact belongs to the contact's interval
# s: contacts that are separated by a shorter pause are one contact, because the handle may chatter on the
# surface
_MERGED = 0.050
_LONGEST = 10.0  # s: maximum length of an interval
# maximum number of intervals that are tried, because a check is evaluated many times per minute
_MOST_TRIED = 40
_STEPS = 4  # successive windows are shifted by 1 / _STEPS of their length
_ROUNDING = 1e-12  # relative rounding error: 2.1 mm / 1000 is not 0.0021 m
_ENOUGH = 0.95  # minimum fraction of a window's length that must have been recorded


@dataclass(frozen=True)
class Result:
    """The result of a check: its state, a sentence, and the value in SI.

    The value comes with the half width of its 95 % confidence interval.

    ``start`` and ``stop`` are the limits of the evaluated interval in s after the start of the recording; NaN
    if no interval was evaluated. ``stamp`` is a hash of the interval's samples.
    """

    state: str
    text: str
    value: float = math.nan
    half: float = math.nan
    start: float = math.nan
    stop: float = math.nan
    stamp: str = ""

    @property
    def correct(self) -> bool:
        """Return True if the check has passed."""
        return self.state == CORRECT


def evaluate(check: Check, samples: Samples) -> Result:
    """Evaluate a check on the newest suitable interval."""
    entry = MEASUREMENTS[check.measure]
    setting = ""
    short: tuple[float, str] | None = None
    advice: tuple[Samples, str] | None = None
    tried = 0
    for segment in samples.segments():
        if wrong := _wrong_setting(check, segment):
            setting = setting or wrong
            continue
        for part in _intervals(check, entry, segment):
            if tried >= _MOST_TRIED:
                break
            tried += 1
            reached, text = _reached(check, entry, part)
            if text:
                if short is None or reached > short[0]:
                    short = reached, text
                continue
            try:
                return judge(check, entry.compute(part, check.between), part)
            except NotMeasured as error:
                advice = advice or (part, str(error))
    if advice is not None:
        part, text = advice
        return Result(WAITING, text, start=float(part.time[0]), stop=float(part.time[-1]))
    if short is not None:
        return Result(WAITING, short[1])
    return Result(WAITING, setting or _nothing(check, entry))


def evaluate_interval(check: Check, part: Samples) -> Result:
    """Evaluate a check on one interval, such as the one stored with an answer."""
    if not len(part):
        return Result(WAITING, "The interval to be evaluated has no samples.")
    if wrong := _wrong_setting(check, part):
        return Result(WAITING, wrong)
    try:
        return judge(check, MEASUREMENTS[check.measure].compute(part, check.between), part)
    except NotMeasured as error:
        return Result(WAITING, str(error))


def judge(check: Check, found: Measured, part: Samples) -> Result:
    """Compare a measured value with the check's expectation."""
    entry = MEASUREMENTS[check.measure]
    measured = f"{entry.label}: {entry.interval_text(found)}."
    state, message = _verdict(check, entry, found, part)
    text = f"{measured} {message}"
    if state == WRONG and check.wrong:
        text = f"{text} {check.wrong}"
    return Result(
        state, text, found.value, found.half, float(part.time[0]), float(part.time[-1]), part.stamp()
    )


def _verdict(check: Check, entry: Measurement, found: Measured, part: Samples) -> tuple[str, str]:
    value = found.value
    if check.expect is None:
        low, high = check.at_least, check.at_most
        if low is not None and not value >= low:
            return WRONG, f"At least {entry.text(low)} is needed."
        if high is not None and not value <= high:
            return WRONG, f"At most {entry.text(high)} is allowed."
        limits = {"at least": low, "at most": high}
        texts = [f"{name} {entry.text(limit)}" for name, limit in limits.items() if limit is not None]
        return CORRECT, f"This is correct: the value had to be {' and '.join(texts)}."
    wanted, source = _wanted(check, part)
    tolerance = (
        check.tolerance if check.tolerance is not None else 0.01 * (check.percent or 0.0) * abs(wanted)
    )
    goal = f"{entry.text(wanted)} was {source}"
    if abs(value - wanted) > tolerance:
        way = "too high" if value > wanted else "too low"
        return WRONG, f"This is {entry.text(abs(value - wanted))} {way}: {goal}."
    if found.half > max(tolerance, 1e-12):
        return WRONG, f"The value is too uncertain ({goal}). Move farther or for longer."
    return CORRECT, f"This is correct: {goal}."


def _wanted(check: Check, part: Samples) -> tuple[float, str]:
    if isinstance(check.expect, str):
        assert part.scene is not None  # _wrong_setting has checked the environment
        return part.scene[1][check.expect], "set"
    assert check.expect is not None
    return check.expect, "expected"


# --- choice of the interval


def _wrong_setting(check: Check, part: Samples) -> str:
    """Return the sentence on a wrong setting; "" if all settings suit the check."""
    scene, known = part.scene, {**environments.discover(), **part.known}
    if scene is None or scene[0].key != check.environment:
        shown = scene[0].title if scene else str(part.settings.get("environment") or "another scene")
        right = known[check.environment].title if check.environment in known else check.environment
        return f"The recording was made with {shown}. Choose {right}."
    environment, values = scene
    parameters = {p.key: p for p in environment.parameters}
    for key, wanted in check.where.items():
        parameter = parameters.get(key)
        if isinstance(parameter, Choice):
            if parameter.text(values[key]) != wanted:
                texts = [parameter.phrase(value) for value in (values[key], parameter.check(wanted))]
                return "{} is {}. Choose {}.".format(parameter.label, *texts)
            continue
        label, unit, now = _setting(part, key, values, parameter)
        if isinstance(wanted, str):
            if now != wanted:
                names = dict(zip(ESTIMATOR.options, ESTIMATOR.labels, strict=True))
                return f"{label} is {names.get(str(now), now)}. Choose {names.get(wanted, wanted)}."
        elif not (isinstance(now, float) and _within(now, *wanted)):
            is_now = on_screen(now, unit) if isinstance(now, float) else str(now)
            low, high = (on_screen(limit, unit) for limit in wanted)
            return f"{label} is {is_now}. Set a value between {low} and {high}."
    return ""


def _within(value: float, low: float, high: float) -> bool:
    """Return True if a value is in a range; the rounding error of a converted unit is permitted."""
    rounding = _ROUNDING * max(abs(low), abs(high))
    return low - rounding <= value <= high + rounding


def _setting(
    part: Samples, key: str, values: dict[str, float], parameter: AnyParameter | None
) -> tuple[str, str, float | str]:
    """Return a setting's label, unit and value."""
    if parameter is not None:
        return parameter.label, parameter.unit, float(values[key])
    if key == "rate":
        return RATE.label, RATE.unit, float(part.settings.get("rate_Hz") or math.nan)
    if key == "delay":
        return DELAY.label, DELAY.unit, part.delay
    spec = part.settings.get("estimator")
    return ESTIMATOR.label, "", str(spec[0] if isinstance(spec, list | tuple) and spec else spec)


def _intervals(check: Check, entry: Measurement, segment: Samples) -> Iterator[Samples]:
    """Yield the intervals of a segment that suit the check's measurement, the newest first."""
    kind = entry.intervals
    if kind == PASS:
        yield from _passes(check, segment)
    elif kind in (PRESS, TOUCH) and segment.depth is not None:
        yield from _contacts(segment, _MARGIN if kind == TOUCH else 0.0)
    else:
        yield from _windows(segment, _window_seconds(check, entry, segment))


def _window_seconds(check: Check, entry: Measurement, segment: Samples) -> float:
    """Return the length of a window, in which the required duration fits."""
    seconds = check.seconds or entry.seconds
    needed = check.needs.get("seconds", 0.0)
    return max(seconds, needed + 2.0 * segment.period) if len(segment) > 1 else seconds


def _contacts(segment: Samples, margin: float) -> Iterator[Samples]:
    assert segment.depth is not None
    found = runs(segment.depth > 0.0)
    merged: list[slice] = []
    least = round(_MERGED / segment.period) if len(segment) > 1 else 1
    for part in found:
        if merged and part.start - merged[-1].stop < least:
            merged[-1] = slice(merged[-1].start, part.stop)
        else:
            merged.append(part)
    around = round(margin / segment.period) if len(segment) > 1 else 0
    longest = round(_LONGEST / segment.period) if len(segment) > 1 else 1
    for part in reversed(merged):
        first = max(part.start - around, 0, part.stop - longest)
        yield segment.cut(slice(first, part.stop + around))


def _windows(segment: Samples, seconds: float) -> Iterator[Samples]:
    begin, end = float(segment.time[0]), float(segment.time[-1])
    if end - begin <= seconds:
        yield segment
        return
    for at in range(_MOST_TRIED * _STEPS):
        stop = end - at * seconds / _STEPS
        if stop - seconds < begin - 1e-9:
            return
        yield segment.between(stop - seconds, stop)


def _passes(check: Check, segment: Samples) -> Iterator[Samples]:
    """Yield each interval in which the handle crosses the check's region from one side to the other."""
    assert check.between is not None
    low, high = check.between
    place = segment.position
    inside = runs((place > low) & (place < high))
    for part in reversed(inside):
        if part.start == 0 or part.stop == len(place):
            continue
        came_left, left_right = place[part.start - 1] <= low, place[part.stop] >= high
        if came_left == left_right:
            yield segment.cut(slice(part.start - 1, part.stop + 1))


def _reached(check: Check, entry: Measurement, part: Samples) -> tuple[float, str]:
    """Return the smallest ratio of a movement to the required movement, and a sentence.

    The sentence is "" unless the ratio is below 1.
    """
    needs = dict(check.needs)
    if entry.intervals not in (PASS,) and not (entry.intervals in (PRESS, TOUCH) and part.depth is not None):
        needs.setdefault("seconds", _ENOUGH * (check.seconds or entry.seconds))
    worst, text = math.inf, ""
    for name, least in needs.items():
        value = NEEDS[name].compute(part) if len(part) > 1 else 0.0
        share = value / least if least > 0.0 else math.inf
        if share < min(worst, 1.0):
            worst, text = share, NEEDS[name].short(value, least)
    return worst, text


def _nothing(check: Check, entry: Measurement) -> str:
    """Return the advice for a recording that has no suitable interval."""
    if entry.intervals == PASS and check.between is not None:
        low, high = (on_screen(end, "m", 3) for end in check.between)
        return f"You did not cross the range from {low} to {high}. Cross this range once."
    if entry.intervals in (PRESS, TOUCH):
        deep = on_screen(check.needs.get("depth", 1e-3), "m", 3)
        return f"You did not touch the surface. Press at least {deep} deep."
    return "Nothing is recorded yet. Move the handle."
