"""What the link to a board allows: the stiffness limit at its measured delay, and if that is too little."""

import math

from hapkit_studio.analysis import plane
from hapkit_studio.analysis.setting import Setting
from hapkit_studio.haptics import board_plan
from hapkit_studio.haptics.engine import COMPUTER, Engine

UNKNOWN = "The delay of the link cannot be measured: nobody knows how stiff a spring it allows."


def rate_of(engine: Engine, where: str) -> float | None:
    """Return the rate in Hz of one way of rendering, None where the board cannot."""
    if where == COMPUTER or engine.device.simulated:
        return engine.loop.rate
    way = engine.board_plan or engine.possible_plan
    return None if way is None else float(way.rate)


def limit_of(engine: Engine, where: str) -> float | None:
    """Return the exact stiffness limit in N/m of a released handle, None where there is none, or no delay."""
    delay, rate = engine.delay_of(where), rate_of(engine, where)
    impedance, device = engine.environment.impedance, engine.device
    if delay is None or rate is None or impedance is None:
        return None
    spec = engine.loop.estimator if where == COMPUTER else board_plan.spec_on_board(engine.loop.estimator)
    setting = Setting(
        device.mass, device.viscous, quantum=device.quantum, rate=rate, delay=delay.mean, estimator=spec
    )
    if not setting.linear:
        return None
    limit = plane.limit(setting, impedance(engine.values)[1])
    return None if math.isinf(limit) else float(limit)


def doubt(engine: Engine) -> str:
    """Return in one line why what is rendered is too much for the link, or may be; "" where it is not."""
    where, impedance = engine.where, engine.environment.impedance
    if engine.device.simulated:
        return ""
    delay = engine.delay_of(where)
    if delay is None:
        return UNKNOWN
    limit = limit_of(engine, where)
    stiffness = impedance(engine.values)[0] if impedance else 0.0
    if limit is None or stiffness <= limit:
        return ""
    way_out = "Lower the stiffness" + (", or let the board render." if where == COMPUTER else ".")
    milliseconds = 1e3 * delay.mean
    return (
        f"The measured delay of {milliseconds:.1f} ms allows {limit:,.0f} N/m at most for a released handle, "
        f"and {stiffness:,.0f} N/m are in force: it may swing. {way_out}"
    )
