"""Format numbers and answers of the work-precision charts."""

import math

from hapkit_studio.analysis.accuracy.plan import Point, Scene, Sheet
from hapkit_studio.formatting import compact, power_of_ten, significant, with_unit

# values below the first or above the second one are formatted as powers of ten; speed tolerances below the
# third one are in µm/s
_TINY, _HUGE, _SLOW = 1e-2, 1e5, 1e-4
_NAMED = 3  # maximum number of listed methods with the same cost


def unit(scene: Scene) -> tuple[float, str]:
    """Return the factor from an error's own unit to the displayed unit, and the displayed unit."""
    if not scene.unit:
        return 100.0, "%"
    return (1e6, "µm/s") if scene.tolerance < _SLOW else (1e3, "mm/s")


def error_text(error: float, scene: Scene) -> str:
    """Format an error with its unit; a fraction is in %, a speed in mm/s or µm/s."""
    factor, name = unit(scene)
    value = error * factor
    if not math.isfinite(value):
        return "none"
    plain = value == 0.0 or _TINY <= value < _HUGE
    return f"{significant(value) if plain else power_of_ten(value)} {name}"


def tolerance_text(tolerance: float, scene: Scene) -> str:
    """Format a tolerance, which is a round number."""
    factor, name = unit(scene)
    return with_unit(tolerance * factor, name)


def cost_text(point: Point, board: bool = False) -> str:
    """Format the computing time of a simulated second, or the board's cycles per second."""
    if board:
        return (
            f"{significant(1e-6 * point.cycles, 3)} million processor cycles"
            if math.isfinite(point.cycles)
            else "–"
        )
    return (
        f"{significant(1e-6 * point.ns)} ms" if point.ns >= 0.995e6 else f"{significant(1e-3 * point.ns)} µs"
    )


def name_text(point: Point, sheet: Sheet) -> str:
    """Format a point's method, with the step in ms if the chart has several steps."""
    several = len({p.step_s for p in sheet.points}) > 1
    return f"{point.label}, {compact(1e3 * point.step_s, 4)} ms step" if several else point.label


def winner_text(sheet: Sheet, tolerance: float, board: bool = False) -> str:
    """Format the cheapest point within a tolerance, and the points with the same cost."""
    names = [name_text(p, sheet) for p in sheet.winners(tolerance, board)]
    return " or ".join(names[:_NAMED]) + " or others" * (len(names) > _NAMED) or "none"


def sentence(sheet: Sheet, board: bool = False) -> str:
    """Return a sentence on the cheapest point within a sheet's tolerance."""
    where = tolerance_text(sheet.scene.tolerance, sheet.scene)
    found = sheet.winners(sheet.scene.tolerance, board)
    if not found:
        return f"No method has an error within {where}."
    cost = f"{cost_text(found[0], board)} {'a second' if board else 'per simulated second'}"
    others = f" {len(found) - 1} more cost{'s' * (len(found) == 2)} the same." if found[1:] else ""
    best = name_text(found[0], sheet)
    return f"The cheapest method with an error within {where} is {best}: {cost}.{others}"
