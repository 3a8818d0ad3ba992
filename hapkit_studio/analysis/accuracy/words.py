"""Numbers and answers of the charts as people read them."""

import math

from hapkit_studio.analysis.accuracy.plan import TIE, Point, Scene, Sheet
from hapkit_studio.formatting import power_of_ten, significant

# An error below this is rounding: its power of ten is worth reading, not its digits.
_SMALL, _LARGE = 1e-4, 1e3
_STILL = 1e-9
# How many methods that cost the same are named.
_NAMED = 3


def error_words(error: float, unit: str = "") -> str:
    """Write an error: a share in %, a speed in mm/s or µm/s, what is tiny as a power of ten."""
    if not math.isfinite(error):
        return "none"
    if error == 0.0:
        return "0"
    if unit == "m/s":
        if error < _STILL:
            return f"{power_of_ten(error)} m/s"
        small = error < 1e-4
        return f"{significant(1e6 * error)} µm/s" if small else f"{significant(1e3 * error)} mm/s"
    if error < _SMALL or error >= _LARGE:
        return power_of_ten(error)
    return f"{significant(100.0 * error)} %"


def cost_words(nanoseconds: float) -> str:
    """Write the computing time of a simulated second."""
    if nanoseconds >= 0.995e6:
        return f"{significant(1e-6 * nanoseconds)} ms"
    return f"{significant(1e-3 * nanoseconds)} µs"


def step_words(step_s: float) -> str:
    """Write a step in ms."""
    return f"{1e3 * step_s:.4g} ms"


def rate_words(step_s: float) -> str:
    """Write the rate that a step belongs to."""
    rate = 1.0 / step_s
    return f"{1e-3 * rate:.4g} kHz" if rate >= 999.5 else f"{rate:.4g} Hz"


def limit_words(scene: Scene) -> str:
    """Write what a scene's tolerance asks for."""
    if scene.goal:
        return scene.goal
    if scene.unit == "m/s" or scene.tolerance < _SMALL:
        return f"within {error_words(scene.tolerance, scene.unit)}".replace(".0 ", " ")
    return f"within {100.0 * scene.tolerance:g} %"


def name_words(scene: Scene, point: Point) -> str:
    """Write what a scene chooses between: methods, or rates."""
    if scene.step_s is not None:
        return point.label
    other = point.method != scene.default.method
    return rate_words(point.step_s) + (f", {point.label.lower()}" if other else "")


def sentence(sheet: Sheet) -> str:
    """Write the answer of a sheet in one sentence."""
    scene, answer = sheet.scene, sheet.answer
    where = limit_words(scene) + ("" if scene.step_s is None else f" at a {step_words(scene.step_s)} step")
    if answer.cheapest is None:
        return f"Nothing is {where}."
    name, cost = name_words(scene, answer.cheapest), cost_words(answer.cheapest.ns_per_simulated_s)
    return f"Cheapest {where}: {name}, {cost} per simulated second."


def verdict(sheet: Sheet) -> str:
    """Write whether the default is the answer, and if not, what is wrong with it."""
    scene, answer = sheet.scene, sheet.answer
    if answer.default is None:
        return "No default here."
    if answer.right:
        names, more = [name_words(scene, p) for p in answer.as_cheap], len(answer.as_cheap) - _NAMED
        others = ", ".join(names[:_NAMED]) + (f" and {more} more" if more > 0 else "")
        return "It is the default." + (f" As cheap, to {100 * (TIE - 1):.0f} %: {others}." if others else "")
    name = name_words(scene, answer.default)
    if answer.default.error > scene.tolerance or answer.cheapest is None:
        return f"The default, {name}, is off by {error_words(answer.default.error, scene.unit)}."
    ratio = answer.default.ns_per_simulated_s / answer.cheapest.ns_per_simulated_s
    return f"The default, {name}, costs {significant(ratio)} times as much."
