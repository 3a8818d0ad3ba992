"""Stiffness limits for a board: of an exported sketch, and of the link with its measured delay."""

import math
from collections.abc import Mapping

from hapkit_studio.analysis.stability import kb_plane
from hapkit_studio.analysis.stability.scene_verdict import Verdict
from hapkit_studio.analysis.stability.verdict import VerdictInput, verdict
from hapkit_studio.dynamics.estimators import Spec
from hapkit_studio.dynamics.loop_settings import COMPUTER, LoopSettings
from hapkit_studio.environments.base import Environment
from hapkit_studio.haptics.engine import Engine
from hapkit_studio.protocol.messages import Board


def sketch_verdict(
    environment: Environment, values: Mapping[str, float], board: Board, rate: float, spec: Spec
) -> Verdict:
    """Return the verdict on a scene that a kit renders at a rate in Hz, for a held and a released handle.

    The force is assumed to be a full period late. In a sketch that keeps its rate the force is never later,
    because each tick ends before the next one begins. The limit is therefore conservative.
    """
    setting = LoopSettings(
        mass=board.mass, viscous=board.viscous, quantum=board.quantum, rate=rate,
        delay=1.0 / rate, estimator=spec, hand=HAND,
    )  # fmt: skip
    return verdict(VerdictInput(environment, values, setting))


def sketch_text(found: Verdict, rate: float) -> str:
    """Return verdict and limit in one or two lines."""
    text = " ".join(filter(None, (*found.lines, found.reason)))
    return f"At {rate:,} Hz, with one period of delay: {text}"


HAND = "medium"
"""The default grip."""
UNKNOWN = "The delay of the link cannot be measured, so the stiffness limit is unknown."


def rendering_limit(engine: Engine, where: str) -> float | None:
    """Return the exact stiffness limit in N/m of a released handle; None if limit or delay are unknown."""
    delay, impedance = engine.delay_of(where), engine.environment.impedance
    loop = None if delay is None else engine.loop_of(where, delay.mean)
    if loop is None or impedance is None or not loop.linear:
        return None
    limit = kb_plane.limit(loop, impedance(engine.values)[1])
    return None if math.isinf(limit) else float(limit)


def link_warning(engine: Engine) -> str:
    """Return a warning if the rendered stiffness exceeds, or may exceed, the link's limit, else ""."""
    where = engine.where
    if not engine.device.measures_delay:
        return ""
    delay = engine.delay_of(where)
    loop = None if delay is None else engine.loop_of(where, delay.mean, HAND)
    if delay is None or loop is None:
        return UNKNOWN
    found = verdict(VerdictInput(engine.environment, engine.values, loop, engine.max_force))
    if found.calm or found.not_judged:
        return found.not_judged
    remedy = "Lower the stiffness" + (", or let the board compute the force." if where == COMPUTER else ".")
    return f"The measured delay is {1e3 * delay.mean:.1f} ms. {' '.join(found.lines)} {remedy}"
