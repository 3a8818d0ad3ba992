"""How stiff the contact with an object may be: the limit of handle, coupling and computed object together.

A limit for a spring to the ground takes the object for a wall. But it moves, by an integrator that has a
limit of its own, and it meets the handle one sample late. Exact while they touch, for small motions around a
press, and for a coupling whose damper acts both ways; the scenes' acts on the way in only: without one theirs
is exact.
"""

from collections.abc import Callable, Mapping

import numpy as np

from hapkit_studio import environments
from hapkit_studio.analysis.checks import bisected
from hapkit_studio.analysis.setting import Setting
from hapkit_studio.analysis.stability.limits import checked_loop
from hapkit_studio.dynamics.sample_matrix import COUPLED, coupled, radius, sample_matrix, used, without_law
from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import ParameterError

OBJECTS = "mass_spring_damper", "puck"
_SOFTEST, _STIFFEST, _SCAN, _HALVINGS = 1.0, 1e7, 141, 20
# An object that nothing holds may lie anywhere: that root is 1, and is no growth.
_STILL = 1.0 + 1e-9


def holds(environment: Environment) -> bool:
    """Return whether a scene is one of OBJECTS, not a person's own of that name."""
    return any(environments.named(key) is environment for key in OBJECTS)


def contact_limit(setting: Setting, key: str, values: Mapping[str, object]) -> float:
    """Return the contact stiffness in N/m up to which all are stable, 0 if the softest is not.

    values: all of a scene of OBJECTS, whose own contact stiffness does not count. Raise ParameterError.
    """
    if key not in OBJECTS:
        raise ParameterError(f"An object that the handle pushes is in {', '.join(OBJECTS)}, not in {key!r}.")
    if not setting.linear:
        raise ParameterError("The velocity filter is not linear: there is no exact limit.")
    others = {name: value for name, value in values.items() if name != "contact_stiffness"}
    numbers = environments.named(key).values(others)
    # a puck stays in touch with the handle that presses it against its wall, and nowhere else
    own = numbers.get("stiffness", numbers.get("wall_stiffness", 0.0)), numbers.get("damping", 0.0)
    loop = checked_loop(
        setting.mass, setting.viscous, 0.0, setting.rate, setting.delay, setting.estimator, setting.hand,
        setting.quantum,
    )  # fmt: skip
    free = without_law(loop, COUPLED, setting.period, setting.parted[1])

    def stable(contact: float) -> bool:
        law = coupled(numbers["integrator"], numbers["mass"], own, (contact, numbers["contact_damping"]))
        return radius(used(sample_matrix(free, law, COUPLED, setting.period)[np.newaxis])[0]) <= _STILL

    return first_limit(stable, np.geomspace(_SOFTEST, _STIFFEST, _SCAN))


def first_limit(stable: Callable[[float], bool], scan: np.ndarray, halvings: int = _HALVINGS) -> float:
    """Return the number up to which all is stable, as far as a scan (n,) tells; 0 if its first is not."""
    bad = next((k for k, value in enumerate(scan) if not stable(float(value))), None)
    if not bad:
        return np.inf if bad is None else 0.0
    return bisected(stable, float(scan[bad - 1]), float(scan[bad]), halvings)[0]
