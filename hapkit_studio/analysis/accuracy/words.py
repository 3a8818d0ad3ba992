"""Numbers and answers of the charts as people read them."""

import math

from hapkit_studio.analysis.accuracy.plan import Choice, Point, Scene, Sheet
from hapkit_studio.formatting import power_of_ten, significant

# What is smaller or larger is written as a power of ten; a tolerance below it is one of µm/s.
_TINY, _HUGE, _SLOW = 1e-2, 1e5, 1e-4
# How many methods that are as good are named.
_NAMED = 3


def unit(scene: Scene) -> tuple[float, str]:
    """Return the unit in which a scene's errors are written, and how many of it make 1 of the error's own."""
    if not scene.unit:
        return 100.0, "%"
    return (1e6, "µm/s") if scene.tolerance < _SLOW else (1e3, "mm/s")


def error_figures(error: float, scene: Scene) -> str:
    """Write an error in its unit, without it."""
    if not math.isfinite(error):
        return "none"
    value = error * unit(scene)[0]
    return significant(value) if value == 0.0 or _TINY <= value < _HUGE else power_of_ten(value)


def error_words(error: float, scene: Scene) -> str:
    """Write an error with its unit: a share in %, a speed in mm/s or µm/s."""
    figures = error_figures(error, scene)
    return f"{figures} {unit(scene)[1]}" if math.isfinite(error) else figures


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


def tolerance_words(scene: Scene) -> str:
    """Write a tolerance, which is a round number."""
    return error_words(scene.tolerance, scene).replace(".0 ", " ")


def limit_words(scene: Scene) -> str:
    """Write what a scene's tolerance asks for."""
    if scene.goal:
        return scene.goal
    return f"within {tolerance_words(scene)}"


def name_words(scene: Scene, point: Point) -> str:
    """Write what a scene chooses between: methods, or rates."""
    if scene.step_s is not None:
        return point.label
    other = point.method != scene.default.method
    return rate_words(point.step_s) + (f", {point.label.lower()}" if other else "")


def sentence(sheet: Sheet) -> str:
    """Write the answer of a sheet, of its scene alone, in one sentence."""
    scene, answer = sheet.scene, sheet.answer
    where = limit_words(scene) + ("" if scene.step_s is None else f" at a {step_words(scene.step_s)} step")
    kind, tied = "rate" if scene.step_s is None else "method", len(answer.as_cheap)
    if answer.cheapest is None:
        return f"In this scene no {kind} is {where}."
    kind += "s" if tied else ""
    those = f"{scene.goal} {kind}" if scene.goal else f"{kind} {where}"
    name = name_words(scene, answer.cheapest)
    cost = f"{cost_words(answer.cheapest.ns_per_simulated_s)} per simulated second"
    if tied:
        return f"In this scene {tied + 1} {those} cost the least, {cost}. Most accurate: {name}."
    return f"In this scene the cheapest {those} is {name}: {cost}."


def verdict(sheet: Sheet) -> str:
    """Write whether the default is the answer in this scene, and if not, what is wrong with it."""
    scene, answer = sheet.scene, sheet.answer
    if answer.default is None:
        return "No default here."
    if answer.right:
        others = f" Just as cheap: {_names(scene, answer.as_cheap)}." if answer.as_cheap else ""
        return f"It is the default.{others}"
    name, error = name_words(scene, answer.default), error_words(answer.default.error, scene)
    if not sheet.passes(answer.default) or answer.cheapest is None:
        return f"The default, {name}, is outside the tolerance here: its error is {error}."
    dearer = _dearer(answer.default, answer.cheapest, name_words(scene, answer.cheapest))
    return f"The default, {name}, {dearer}; its error here is {error}."


def reason(choice: Choice) -> str:
    """Write why a default is one, over all scenes it serves: where it is within the tolerance, and others."""
    answer, scene, count = choice.answer, choice.sheets[0].scene, len(choice.sheets)
    if count == 1:
        return verdict(choice.sheets[0])
    if answer.default is None or answer.cheapest is None:
        return "No method is within the tolerance." if answer.default else "No default here."
    passed, most = choice.passed(answer.default), choice.passed(answer.cheapest)
    name, best = name_words(scene, answer.default), name_words(scene, answer.cheapest)
    where = f"within the tolerance in {'all' if passed == count else passed} of them"
    said = f"One default serves {count} scenes: {name} is {where}"
    if most > passed:
        said += f", {best} in {most}"
    elif not answer.tied:
        said += f"; {best} is in as many, and the default {_dearer(answer.default, answer.cheapest, best)}"
    elif not answer.right:
        said += f"; {best} is in as many, costs the same and has a smaller largest error"
    else:
        said += "; none is in more, and none in as many costs less on average"
    lost = [_given_up(s, p) for s, p in choice.serving(answer.default) if not s.passes(p)]
    return f"{said}." + (f" Not in {'; '.join(lost)}." if lost else "")


def choice_row(choice: Choice) -> dict[str, object]:
    """Return what a default serves, and why it is one, as an object for programs."""
    return {
        "chart": choice.sheets[0].chart,
        "scenes": [sheet.scene.key for sheet in choice.sheets],
        "default_is_cheapest": choice.answer.right,
        "reason": reason(choice),
    }


def _given_up(sheet: Sheet, point: Point) -> str:
    """Write by how much a point is outside of the tolerance in its scene."""
    lag = dict(point.extra).get("lag_s")
    late = "" if lag is None else f", {significant(1e3 * lag)} ms late"
    return f"“{sheet.scene.title}”: its error is {error_words(point.error, sheet.scene)}{late}"


def _dearer(point: Point, other: Point, name: str) -> str:
    """Write what a point costs beside another, of this name."""
    if point.as_cheap(other):
        return f"costs the same as {name}"
    ratio = point.ns_per_simulated_s / other.ns_per_simulated_s
    if ratio < 1.5:
        return f"costs {100 * (ratio - 1):.0f} % more than {name}"
    return f"costs {significant(ratio)} times as much as {name}"


def _names(scene: Scene, points: tuple[Point, ...]) -> str:
    """Name the first few points."""
    names, more = [name_words(scene, p) for p in points[:_NAMED]], len(points) - _NAMED
    return ", ".join(names) + (f" and {more} more" if more > 0 else "")
