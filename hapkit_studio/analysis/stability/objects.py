"""The limit of the contact stiffness with a simulated object: handle, coupling and object as one system.

The limit for a spring to the ground assumes a fixed wall. An object moves, is integrated with a method that
has its own limit, and responds one sample late. The limit is exact during contact, for small motions, and for
a coupling whose damper acts both ways. The dampers of the scenes act on approach only, so for these scenes
the limit is exact only without damping.
"""

from collections.abc import Callable, Mapping

import numpy as np

from hapkit_studio import environments
from hapkit_studio.analysis.checks import bisected
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.dynamics.sample_matrix import COUPLED, coupled, radius, sample_matrix, used, without_law
from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import ParameterError

OBJECTS = "mass_spring_damper", "puck"
_SOFTEST, _STIFFEST, _SCAN, _HALVINGS = 1.0, 1e7, 141, 20
# The motion grows if a root is above this value. An object without a spring has a root at exactly 1, which is
# not growth.
_STILL = 1.0 + 1e-9


def has_object(environment: Environment) -> bool:
    """Return True if a scene is one of OBJECTS, and not a user's own scene of the same name."""
    return any(environments.named(key) is environment for key in OBJECTS)


def contact_limit(setting: LoopSettings, key: str, values: Mapping[str, object]) -> float:
    """Return the largest stable contact stiffness in N/m; 0 if even the softest one is unstable.

    ``values`` are all values of a scene of OBJECTS; the contact stiffness among them is ignored. Raise
    ParameterError for another scene, and for a nonlinear estimator.
    """
    if key not in OBJECTS:
        raise ParameterError(
            f"Choose a scene with an object that the handle pushes: {' or '.join(OBJECTS)}, not {key!r}."
        )
    if not setting.linear:
        raise ParameterError("The velocity filter is not linear, so there is no exact limit.")
    others = {name: value for name, value in values.items() if name != "contact_stiffness"}
    numbers = environments.named(key).values(others)
    # a puck stays in contact only while the handle presses it against the wall
    own = numbers.get("stiffness", numbers.get("wall_stiffness", 0.0)), numbers.get("damping", 0.0)
    free = without_law(setting, COUPLED, setting.period, setting.parted[1])

    def stable(contact: float) -> bool:
        law = coupled(numbers["integrator"], numbers["mass"], own, (contact, numbers["contact_damping"]))
        return radius(used(sample_matrix(free, law, COUPLED, setting.period)[np.newaxis])[0]) <= _STILL

    return first_limit(stable, np.geomspace(_SOFTEST, _STIFFEST, _SCAN))


def first_limit(stable: Callable[[float], bool], scan: np.ndarray, halvings: int = _HALVINGS) -> float:
    """Return the end of the first stable range, by a scan (n,) and bisection; 0 if nothing is stable."""
    bad = next((k for k, value in enumerate(scan) if not stable(float(value))), None)
    if not bad:
        return np.inf if bad is None else 0.0
    return bisected(stable, float(scan[bad - 1]), float(scan[bad]), halvings)[0]
