"""Stiffness limits for a board: of an exported sketch, and of the link with its measured delay."""

import math
from collections.abc import Mapping

from hapkit_studio.analysis.stability import kb_plane
from hapkit_studio.analysis.stability.scene_verdict import Verdict
from hapkit_studio.analysis.stability.verdict import VerdictInput, verdict
from hapkit_studio.dynamics.estimators import Spec
from hapkit_studio.dynamics.loop_settings import COMPUTER, LoopSettings
from hapkit_studio.environments.base import Environment
from hapkit_studio.haptics import board_plan
from hapkit_studio.haptics.engine import Engine
from hapkit_studio.protocol.messages import Board


def sketch_verdict(
    environment: Environment, values: Mapping[str, float], board: Board, rate: float, spec: Spec
) -> Verdict:
    """Return the verdict for a kit with all values at a rate in Hz, held and released.

    The force is assumed to be a full period late. A sketch that keeps its rate is never later, because a tick
    ends before the next one begins, so the limit is conservative.
    """
    setting = LoopSettings(
        mass=board.mass, viscous=board.viscous, quantum=board.quantum, rate=rate,
        delay=1.0 / rate, estimator=spec, hand=HAND,
    )  # fmt: skip
    return verdict(VerdictInput(environment, values, setting))


def sketch_words(found: Verdict, rate: float) -> str:
    """Return verdict and limit in one or two lines."""
    said = " ".join(filter(None, (*found.lines, found.reason)))
    return f"At {rate:,} Hz, with one period of delay: {said}"


HAND = "medium"
"""The default grip."""
UNKNOWN = "The delay of the link cannot be measured, so the stiffness limit is unknown."


def rendering_rate(engine: Engine, where: str) -> float | None:
    """Return the rate in Hz of one way of rendering; None if the board cannot render."""
    if where == COMPUTER or not engine.device.has_board:
        return engine.loop.rate
    decision = engine.decision()
    plan = decision.in_force or decision.plan
    return None if plan is None else float(plan.rate)


def rendering_limit(engine: Engine, where: str) -> float | None:
    """Return the exact stiffness limit in N/m of a released handle; None if limit or delay are unknown."""
    delay, rate = engine.delay_of(where), rendering_rate(engine, where)
    impedance, device = engine.environment.impedance, engine.device
    if delay is None or rate is None or impedance is None:
        return None
    setting = LoopSettings(
        mass=device.mass, viscous=device.viscous, quantum=device.quantum, rate=rate, delay=delay.mean,
        estimator=_spec(engine, where),
    )  # fmt: skip
    if not setting.linear:
        return None
    limit = kb_plane.limit(setting, impedance(engine.values)[1])
    return None if math.isinf(limit) else float(limit)


def link_warning(engine: Engine) -> str:
    """Return one line if the rendered stiffness exceeds, or may exceed, the link's limit, else ""."""
    where, device = engine.where, engine.device
    if not device.measures_delay:
        return ""
    delay, rate = engine.delay_of(where), rendering_rate(engine, where)
    if delay is None or rate is None:
        return UNKNOWN
    setting = LoopSettings(
        mass=device.mass, viscous=device.viscous, quantum=device.quantum, rate=rate, delay=delay.mean,
        estimator=_spec(engine, where), hand=HAND,
    )  # fmt: skip
    found = verdict(VerdictInput(engine.environment, engine.values, setting, engine.max_force))
    if found.calm or found.not_judged:
        return found.not_judged
    remedy = "Lower the stiffness" + (", or let the board render." if where == COMPUTER else ".")
    return f"The measured delay is {1e3 * delay.mean:.1f} ms. {' '.join(found.lines)} {remedy}"


def _spec(engine: Engine, where: str) -> Spec:
    return engine.loop.estimator if where == COMPUTER else board_plan.spec_on_board(engine.loop.estimator)
