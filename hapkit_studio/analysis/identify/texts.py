"""Sentences on identified values, such as "You set 300 N/m, the device gave 299.8 ± 0.1 N/m."."""

import math

from hapkit_studio.analysis.identify.estimates import Estimate, Part
from hapkit_studio.analysis.identify.recording import Setup
from hapkit_studio.formatting import MINUS, compact, interval, number, on_screen
from hapkit_studio.parameters import Choice

# display units: the name, and how many of them make one SI unit
READ_UNITS = {"m": ("mm", 1e3), "kg": ("g", 1e3)}
# smallest half width shown, as a fraction of ``Term.fine``
_SMALLEST_HALF = 0.1
# smallest difference that is explained, as a fraction of ``Term.fine``
_WORTH_A_REASON = 0.1


def unit_of(estimate: Estimate) -> str:
    """Return the display unit of an estimate."""
    return _unit(estimate)[0]


def _unit(estimate: Estimate) -> tuple[str, float]:
    return READ_UNITS.get(estimate.term.unit, (estimate.term.unit, 1.0))


def _scale_and_decimals(estimate: Estimate) -> tuple[float, int]:
    """Return the number of display units per SI unit, and the number of significant decimals."""
    scale = _unit(estimate)[1]
    if not math.isfinite(estimate.half):
        return scale, 2
    half = scale * max(estimate.half, _SMALLEST_HALF * estimate.term.fine)
    digits = 1 - math.floor(math.log10(half))
    return scale, max(digits - 1 if half * 10.0 ** (digits - 1) >= 3.0 else digits, 0)


def _rounded(estimate: Estimate) -> tuple[float, float, int]:
    """Return the rounded value and half width in display units, and the number of decimals."""
    scale, decimals = _scale_and_decimals(estimate)
    half = max(scale * estimate.half, 10.0**-decimals)
    return round(scale * estimate.value, decimals), round(half, decimals), decimals


def measured(estimate: Estimate) -> str:
    """Format an estimate in display units: "299.8 ± 0.1"."""
    return interval(*_rounded(estimate))


def confirms(estimate: Estimate) -> bool:
    """Return True if the rounded interval contains the value set."""
    return estimate.determined and estimate.asked is not None and not deviation(estimate)


def deviation(estimate: Estimate) -> str:
    """Format the deviation from the value set, as in "0.6 N/m less"; "" if the interval contains it."""
    if not estimate.determined or estimate.asked is None:
        return ""
    value, half, decimals = _rounded(estimate)
    apart = value - _unit(estimate)[1] * estimate.asked
    if abs(apart) <= half + 1e-9:
        return ""
    return f"{number(abs(apart), decimals)} {unit_of(estimate)} {'more' if apart > 0.0 else 'less'}"


def alike(value: float, estimate: Estimate) -> str:
    """Format a value with the decimals and the unit of an estimate."""
    scale, decimals = _scale_and_decimals(estimate)
    return f"{number(scale * value, decimals)} {unit_of(estimate)}"


def plain(value: float | None, estimate: Estimate) -> str:
    """Format a value that was set or is expected, in display units; None becomes a dash."""
    if value is None:
        return "–"
    scale = _unit(estimate)[1]
    size = abs(scale * value)
    text = f"{size:,.0f}" if size >= 1e4 else compact(size, 4)
    return MINUS + text if value < 0.0 and size != 0.0 else text


def had(estimate: Estimate, setup: Setup | None) -> str:
    """Describe a simulated handle's true mass or friction, with the mass of a hand that holds the handle."""
    whole, unit = estimate.asked, unit_of(estimate)
    own = getattr(setup.handle, estimate.key, None) if setup and setup.handle else None
    if whole is None or own is None or estimate.key != "mass" or whole - own <= 1e-9:
        return f"the device has {plain(whole, estimate)} {unit}"
    hand = plain(whole - own, estimate)
    return f"{plain(own, estimate)} {unit} of the handle and {hand} {unit} of the hand"


def line(estimate: Estimate, part: str, setup: Setup | None = None) -> str:
    """Format one estimate as a sentence."""
    label, unit = estimate.term.label, unit_of(estimate)
    if not estimate.determined:
        return f"{label}: {estimate.advice}"
    if estimate.asked is None:
        return f"{label}: {measured(estimate)} {unit}."
    found = f"{measured(estimate)} {unit}"
    if apart := deviation(estimate):
        found += f", {apart}"
    if part == "rendered":
        return f"{label}: you set {plain(estimate.asked, estimate)} {unit}, the device gave {found}."
    return f"{label}: {had(estimate, setup)}, identified {found}."


def differs(estimate: Estimate) -> bool:
    """Return True if the rendered value differs noticeably from the value set."""
    asked, expected = estimate.asked, estimate.expected
    if not estimate.determined or asked is None or expected is None or estimate.key == "centre":
        return False
    return not estimate.holds(asked) and abs(estimate.value - asked) >= _WORTH_A_REASON * estimate.term.fine


def surprising(estimate: Estimate) -> bool:
    """Return True if the rendered value differs noticeably from both the set and the expected value."""
    if not differs(estimate) or estimate.expected is None:
        return False
    least = max(estimate.half, _WORTH_A_REASON * estimate.term.fine)
    return abs(estimate.value - estimate.expected) > least


def why(estimate: Estimate) -> str:
    """Explain a deviation from the value set in one line; "" without a deviation or a known cause."""
    if not differs(estimate) or estimate.expected is None:
        return ""
    must = alike(estimate.expected, estimate)
    if surprising(estimate):
        return (
            f"The force is late. This alone would give {must}. The measured value is different, so there is "
            "also another cause."
        )
    return f"The force is late. This alone gives {must}."


def lateness(part: Part, setup: Setup) -> str:
    """State the force's mean delay, and the damping that this delay removes; "" without a spring."""
    spring = next((e for e in part.estimates if e.key == "stiffness" and e.asked), None)
    if spring is None or spring.asked is None:
        return ""
    late = 0.5 / setup.rate + setup.delay  # half a period and the delay
    ms, took = f"{compact(1e3 * late, 3)} ms", f"{compact(spring.asked * late, 2)} N·s/m"
    text = f"this removes a damping of {plain(spring.asked, spring)} N/m × {ms} = {took}."
    return f"The force is constant for one period, so it is {ms} late on average: {text}"


def noisy(noise: float, setup: Setup) -> str:
    """State that position noise in m has widened the intervals."""
    size = f"{compact(noise / setup.quantum, 2)} counts ({compact(1e6 * noise, 2)} µm)"
    return (
        f"The positions have noise of {size} in addition to the sensor steps, so the intervals (±) are wider."
    )


def force_known(setup: Setup) -> str:
    """State that the force is the command, not a measurement, and how to measure it."""
    if setup.foreign:
        return (
            "± is the uncertainty of the fit. The force is taken from the file: if it is wrong there, all "
            "numbers are wrong."
        )
    if setup.handle is not None:
        return "The force is not measured, but the simulated motor gives exactly the force that was set."
    return (
        "The force is not measured, but computed from the command and the motor constant; ± is only the "
        "uncertainty of the fit. If the real motor constant is only 90 % of this one, the real values are "
        "90 % of these. Measure the constant with known weights, springs or a kitchen scale: Set up my "
        "Hapkit, step Strength."
    )


def conditions(setup: Setup, released: bool) -> list[tuple[str, str]]:
    """Return the settings of a recording as pairs of name and value.

    ``released`` is True if the handle was identified without a hand.
    """
    known = setup.environment
    scene = [("Environment", known.title)] if known else []
    values = []
    for p in known.parameters if known else ():
        value = setup.values[p.key]
        values.append((p.label, p.phrase(value) if isinstance(p, Choice) else on_screen(value, p.unit)))
    grip = setup.grip
    hand = "none" if released or (setup.handle and setup.hold_known) else "not known"
    if grip:
        let_go = ", and let go" if released else ""
        hand = f"{1e3 * grip.mass:g} g, {grip.damping:g} N·s/m, {grip.stiffness:,g} N/m{let_go}"
    return [
        *scene,
        *values,
        ("Rate", f"{compact(setup.rate, 4)} Hz"),
        ("Delay", f"{1e3 * setup.delay:.2f} ms"),
        ("Sensor step", f"{compact(1e6 * setup.quantum, 3)} µm"),
        ("Hand", hand),
    ]


def remarks(part: Part, setup: Setup, total: int) -> list[str]:
    """Return remarks on the whole part, one per line."""
    rendered = part.key == "rendered"
    reasons = rendered and any(differs(estimate) for estimate in part.estimates)
    lines = [lateness(part, setup) if reasons else ""]
    if part.damped and total:
        lines.append(
            f"The passivity controller added damping in {compact(100.0 * part.damped / total, 2)} % of the "
            "samples."
        )
    if part.estimates and part.explained < 0.9:
        share = f"{100.0 * max(part.explained, 0.0):.0f} %"
        lines.append(f"These terms explain only {share} of the force, so the law has other terms, too.")
    if part.left_out and total:
        shares = (f"{compact(100.0 * n / total, 3)} % {reason}" for reason, n in part.left_out.items())
        lines.append(f"Samples left out: {', '.join(shares)}.")
    return [line for line in lines if line]


def notes(part: Part, setup: Setup, total: int) -> list[str]:
    """Return the notes below a table: undetermined estimates, reasons for deviations, remarks."""
    found = []
    for estimate in part.estimates:
        reason = why(estimate) if part.key == "rendered" else ""
        if not estimate.determined:
            found.append(line(estimate, part.key))
        elif reason:
            found.append(f"{estimate.term.label}: {reason[0].lower()}{reason[1:]}")
    return found + remarks(part, setup, total)


def sentences(part: Part, setup: Setup, total: int) -> list[str]:
    """Return a part's sentences: estimates, reasons for deviations, goodness of fit, excluded samples."""
    found: list[str] = [] if part.estimates else [part.advice]
    for estimate in part.estimates:
        found.append(line(estimate, part.key, setup))
        reason = why(estimate) if part.key == "rendered" else ""
        found += ["  " + reason] if reason else []
    return found + remarks(part, setup, total)
