"""How stiff an exported sketch may be: the exact limit on its kit, at its rate, by its velocity filter."""

import math
from collections.abc import Mapping

from hapkit_studio.analysis import plane
from hapkit_studio.analysis.margin import Margin, sentence
from hapkit_studio.analysis.setting import Setting
from hapkit_studio.dynamics.estimators import Spec
from hapkit_studio.environments.base import Environment
from hapkit_studio.protocol.messages import Board


def margin(
    environment: Environment, values: Mapping[str, float], board: Board, rate: float, spec: Spec
) -> Margin | None:
    """Return the margin of all values at a rate in Hz, the handle released; None where nothing is rendered.

    The force counts a whole period late. A sketch that keeps its rate is never later, so that it is on the
    safe side: a tick ends before the next one begins.
    """
    if environment.impedance is None:
        return None
    stiffness, damping = environment.impedance(values)
    if stiffness <= 0.0 and damping <= 0.0:
        return None
    setting = Setting(
        board.mass, board.viscous, quantum=board.quantum, rate=rate, delay=1.0 / rate, estimator=spec
    )
    return Margin(stiffness, damping, plane.limit(setting, damping))


def words(found: Margin | None, rate: float) -> str:
    """Return limit and margin in a line or two; nothing without a margin."""
    if found is None or not math.isfinite(found.limit):
        return ""
    most = f"Limit {max(found.limit, 0.0):,.0f} N/m at {rate:,} Hz, the force a whole period late"
    return f"{most}. {sentence(found)}"
