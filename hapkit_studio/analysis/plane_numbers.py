"""A plane as one object of plain numbers, for programs and files."""

import math
from typing import Any

import numpy as np

from hapkit_studio.analysis.margin import sentence
from hapkit_studio.analysis.plane import Cells, Plane, Points, passivity_line
from hapkit_studio.analysis.setting import Setting

CLASS_NAMES = ("decays", "buzzes", "grows")


def as_json(plane: Plane) -> dict[str, Any]:
    """Return the plane in SI units; what is not finite is None."""
    margin = plane.margin
    return {
        "setting": of_setting(plane.setting),
        "stiffness": margin.stiffness,
        "damping": margin.damping,
        "limit": plain(margin.limit),
        "ratio": plain(margin.ratio),
        "stable": margin.stable if math.isfinite(margin.limit) else None,
        "words": sentence(margin),
        "hands": {hand: plain(limit) for hand, limit in plane.hands.items()},
        "coulomb_line": plain(plane.coulomb),
        "columns": {
            "damping": column(plane.damping),
            "exact": column(plane.exact),
            "simple": column(plane.simple),
            "passive": column(passive(plane)),
        },
        "passivity_line": {"damping": column(plane.edge_damping), "stiffness": column(plane.edge)},
        "measured": _points(plane.points),
        "map": _cells(plane.cells),
    }


def of_setting(setting: Setting) -> dict[str, Any]:
    """Return a setting's fields, the estimator's name and options apart."""
    pair = (setting.estimator, {}) if isinstance(setting.estimator, str) else setting.estimator
    return {
        "mass": setting.mass,
        "viscous": setting.viscous,
        "coulomb": setting.coulomb,
        "quantum": setting.quantum,
        "rate": setting.rate,
        "delay": setting.delay,
        "estimator": pair[0],
        "estimator_options": dict(pair[1]),
        "hand": setting.hand,
        "controller": setting.controller,
    }


def passive(plane: Plane) -> np.ndarray:
    """Return the passivity line (n,) at the plane's own columns, in N/m; nan without a linear estimator."""
    if not plane.setting.linear:
        return np.full(len(plane.damping), math.nan)
    return passivity_line(plane.setting, plane.damping)


def plain(number: float) -> float | None:
    """Return a number that JSON knows."""
    return float(number) if math.isfinite(number) else None


def column(numbers: np.ndarray) -> list[float | None]:
    """Return an array (n,) as a list that JSON knows."""
    return [plain(number) for number in numbers.tolist()]


def _points(points: Points | None) -> dict[str, Any] | None:
    if points is None:
        return None
    return {
        "damping": column(points.damping),
        "stiffness": column(points.stiffness),
        "friction_and_sensor_steps": points.real,
        "controller": points.controller,
    }


def _cells(cells: Cells | None) -> dict[str, Any] | None:
    if cells is None:
        return None
    return {
        "damping": column(cells.damping),
        "stiffness": column(cells.stiffness),
        "classes": cells.classes.tolist(),
        "class_names": list(CLASS_NAMES),
        "friction_and_sensor_steps": cells.real,
        "controller": cells.controller,
    }
