"""What had been set, and what the loop must make of it on this very motion.

A command is held for a period T and comes td late, so the force at the handle lags the position by
T / 2 + td: of -K x it makes -K x + K (T / 2 + td) v, a damping of B - K (T / 2 + td). The velocity estimate
comes later still: of -B v it makes some stiffness as well, B w^2 times its lag.
"""

import numpy as np

from hapkit_studio.analysis.identify.grid import Grid
from hapkit_studio.analysis.identify.recording import Setup
from hapkit_studio.environments.base import ForceTerms


def asked(setup: Setup) -> ForceTerms:
    """Return what was set; without a known environment nothing."""
    return setup.environment.force_terms(setup.values) if setup.environment else ForceTerms(simple=False)


def commands(grid: Grid, what: ForceTerms) -> np.ndarray | None:
    """Return the commands (n,) in N of what was set, for the motion the law saw; None if not simple."""
    if not what.simple:
        return None
    depth, rate = grid.seen - (what.centre or 0.0), grid.speed
    if what.one_way:
        rate = np.where(rate * what.one_way > 0.0, rate, 0.0)
    force = -(what.stiffness or 0.0) * depth - (what.damping or 0.0) * rate
    return force - (what.friction or 0.0) * np.sign(grid.speed)


def lag(setup: Setup) -> float:
    """Return by how much the force lags the position on average, in s: half a period and the delay."""
    return 0.5 / setup.rate + setup.delay
