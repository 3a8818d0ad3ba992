"""How stiff a spring a board may render: an exported sketch on its kit, and the link's measured delay."""

import math
from collections.abc import Mapping

from hapkit_studio.analysis.setting import Setting
from hapkit_studio.analysis.stability import kb_plane
from hapkit_studio.analysis.stability.margin import Margin, sentence
from hapkit_studio.dynamics.estimators import Spec
from hapkit_studio.environments.base import Environment
from hapkit_studio.haptics import board_plan
from hapkit_studio.haptics.engine import COMPUTER, Engine
from hapkit_studio.protocol.messages import Board


def sketch_margin(
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
    return kb_plane.margin_of(setting, stiffness, damping)


def sketch_words(found: Margin | None, rate: float) -> str:
    """Return limit and margin in a line or two; nothing without a margin."""
    if found is None or not math.isfinite(found.limit):
        return ""
    most = f"Limit {max(found.limit, 0.0):,.0f} N/m at {rate:,} Hz, the force a whole period late"
    return f"{most}. {sentence(found)}"


UNKNOWN = "The delay of the link cannot be measured: nobody knows how stiff a spring it allows."


def rendering_rate(engine: Engine, where: str) -> float | None:
    """Return the rate in Hz of one way of rendering, None where the board cannot."""
    if where == COMPUTER or engine.device.simulated:
        return engine.loop.rate
    way = engine.board_plan or engine.possible_plan
    return None if way is None else float(way.rate)


def rendering_limit(engine: Engine, where: str) -> float | None:
    """Return the exact stiffness limit in N/m of a released handle, None where there is none, or no delay."""
    delay, rate = engine.delay_of(where), rendering_rate(engine, where)
    impedance, device = engine.environment.impedance, engine.device
    if delay is None or rate is None or impedance is None:
        return None
    spec = engine.loop.estimator if where == COMPUTER else board_plan.spec_on_board(engine.loop.estimator)
    setting = Setting(
        device.mass, device.viscous, quantum=device.quantum, rate=rate, delay=delay.mean, estimator=spec
    )
    if not setting.linear:
        return None
    limit = kb_plane.limit(setting, impedance(engine.values)[1])
    return None if math.isinf(limit) else float(limit)


def link_warning(engine: Engine) -> str:
    """Return in one line why what is rendered is too much for the link, or may be; "" where it is not."""
    where, impedance = engine.where, engine.environment.impedance
    if engine.device.simulated:
        return ""
    delay = engine.delay_of(where)
    if delay is None:
        return UNKNOWN
    limit = rendering_limit(engine, where)
    stiffness = impedance(engine.values)[0] if impedance else 0.0
    if limit is None or stiffness <= limit:
        return ""
    remedy = "Lower the stiffness" + (", or let the board render." if where == COMPUTER else ".")
    milliseconds = 1e3 * delay.mean
    return (
        f"The measured delay of {milliseconds:.1f} ms allows {limit:,.0f} N/m at most for a released handle, "
        f"and {stiffness:,.0f} N/m are in force: it may swing. {remedy}"
    )
