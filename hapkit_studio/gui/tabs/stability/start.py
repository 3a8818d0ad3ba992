"""From how far the released handle grows, against dry friction and the force limit."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hapkit_studio.analysis.setting import Setting

# How far a trial goes in m: at least, at most, and where nothing says how far.
LEAST, MOST, USUAL = 0.001, 0.020, 0.005
# Beyond the smallest amplitude that grows by this factor and so many m more.
_TIMES, _MORE = 2.0, 0.0005
# Amplitudes that are tried, in m.
_FINEST, _COUNT = 2e-5, 2000


@dataclass(frozen=True)
class Held:
    """A rendered stiffness and the released handle's limit in N/m, in a loop whose force ends at force N."""

    setting: "Setting"
    stiffness: float
    limit: float
    force: float = math.inf


def share(ratio: float) -> float:
    """Return the share of its stiffness that a spring keeps at an amplitude of 1/ratio times its clamp.

    The describing function of saturation.
    """
    if ratio >= 1.0:
        return 1.0
    return 2.0 / math.pi * (math.asin(ratio) + ratio * math.sqrt(1.0 - ratio * ratio))


def grows_from(held: Held) -> float:
    """Return the smallest amplitude in m that grows; inf where friction or the clamp stop every one.

    Energy balance of one cycle: 4 f A = π ω A² (K - K_limit)(T/2 + d), where the exact limit stands for all
    that is linear. It is theory's A = 4 f / (π ω (K (T/2 + d) - b)) without virtual damping. 0 without
    friction.
    """
    if held.stiffness <= held.limit:
        return math.inf
    if held.setting.coulomb == 0.0:
        return 0.0
    ratio = (MOST / _FINEST) ** (1.0 / _COUNT)
    return next((a for i in range(_COUNT) if _gains(held, a := _FINEST * ratio**i)), math.inf)


def _gains(held: Held, amplitude: float) -> bool:
    kept = held.stiffness * share(held.force / (held.stiffness * amplitude))
    lag = 0.5 * held.setting.period + held.setting.delay
    gained = math.pi * math.sqrt(kept / held.setting.mass) * amplitude * (kept - held.limit) * lag
    return gained > 4.0 * held.setting.coulomb


def start(held: Held) -> float:
    """Return how far a trial takes the handle, in m: well beyond what friction holds, where that goes."""
    if not held.stiffness > held.limit:
        return USUAL
    return min(max(_TIMES * grows_from(held) + _MORE, LEAST), MOST)
