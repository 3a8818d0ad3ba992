"""Numbers and answers of the work-precision charts as people read them."""

import math

from hapkit_studio.analysis.accuracy.plan import Point, Scene, Sheet
from hapkit_studio.formatting import compact, power_of_ten, significant, with_unit

# What is smaller or larger is written as a power of ten; a tolerance below it is one of µm/s.
_TINY, _HUGE, _SLOW = 1e-2, 1e5, 1e-4
_NAMED = 3  # methods of the same cost that are named


def unit(scene: Scene) -> tuple[float, str]:
    """Return the unit in which a scene's errors are written, and how many of it make 1 of the error's own."""
    if not scene.unit:
        return 100.0, "%"
    return (1e6, "µm/s") if scene.tolerance < _SLOW else (1e3, "mm/s")


def error_words(error: float, scene: Scene) -> str:
    """Write an error with its unit: a share in %, a speed in mm/s or µm/s."""
    factor, name = unit(scene)
    value = error * factor
    if not math.isfinite(value):
        return "none"
    plain = value == 0.0 or _TINY <= value < _HUGE
    return f"{significant(value) if plain else power_of_ten(value)} {name}"


def tolerance_words(tolerance: float, scene: Scene) -> str:
    """Write a tolerance, which is a round number."""
    factor, name = unit(scene)
    return with_unit(tolerance * factor, name)


def cost_words(point: Point, board: bool = False) -> str:
    """Write the computing time of a simulated second, or the board's cycles in a second."""
    if board:
        return f"{significant(1e-6 * point.cycles, 3)} million cycles" if math.isfinite(point.cycles) else "–"
    return (
        f"{significant(1e-6 * point.ns)} ms" if point.ns >= 0.995e6 else f"{significant(1e-3 * point.ns)} µs"
    )


def name_words(point: Point, sheet: Sheet, unit: str = "ms step") -> str:
    """Name a point by its method, and by its step in ms where there are several."""
    several = len({p.step_s for p in sheet.points}) > 1
    return f"{point.label}, {compact(1e3 * point.step_s, 4)} {unit}" if several else point.label


def winner_words(sheet: Sheet, tolerance: float, board: bool = False, unit: str = "ms step") -> str:
    """Write the cheapest point within a tolerance, and those that cost the same."""
    names = [name_words(p, sheet, unit) for p in sheet.winners(tolerance, board)]
    return " or ".join(names[:_NAMED]) + " or others" * (len(names) > _NAMED) or "none"


def sentence(sheet: Sheet, board: bool = False) -> str:
    """Write the answer of a sheet: the cheapest point within its tolerance."""
    where = tolerance_words(sheet.scene.tolerance, sheet.scene)
    found = sheet.winners(sheet.scene.tolerance, board)
    if not found:
        return f"No method has an error within {where}."
    cost = f"{cost_words(found[0], board)} {'a second' if board else 'per simulated second'}"
    others = f" {len(found) - 1} more cost{'s' * (len(found) == 2)} the same." if found[1:] else ""
    return f"Cheapest with error within {where}: {name_words(found[0], sheet)}, {cost}.{others}"
