"""What the two ways of rendering come to: delay, rate, stiffness limit and skipped ticks of each."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from hapkit_studio.gui.loop_facts import steady_delay
from hapkit_studio.gui.theme import number

if TYPE_CHECKING:
    from hapkit_studio.analysis.setting import Setting
    from hapkit_studio.gui.studio import Studio
    from hapkit_studio.haptics.board_offer import Wish
    from hapkit_studio.haptics.delays import Measured
    from hapkit_studio.haptics.engine import Engine

WAYS = COMPUTER, BOARD = "computer", "board"
ROWS = "Delay, ms", "Rate, Hz", "Limit, N/m", "Missed", "Processor, %"
HINTS = (
    "From a sample to its force in the motor's register, as the board measured it: mean and standard "
    "deviation of the last seconds",
    "How often the force is computed anew",
    "Stiffness limit: the exact boundary for a released handle at this delay, rate and velocity estimator, "
    "with the scene's own damping",
    "Ticks missed. Computer: answers that came too late. Board: ticks it had no time for, by its own count",
    "Share of the board's processor that law, rest of the tick and telemetry take as a rule; up to 80",
)
UNKNOWN = "–"


@dataclass(frozen=True)
class Way:
    """One way of rendering: delay, rate in Hz and share of a processor where known, what its limit is for."""

    delay: "Measured | None"
    rate: float | None
    missed: int
    setting: "Setting | None"
    share: float | None = None


@dataclass(frozen=True)
class Limits:
    """A question: the settings of both ways, None where nothing is known, the scene's damping in N·s/m."""

    settings: tuple["Setting | None", "Setting | None"]
    damping: float


@dataclass(frozen=True)
class Found:
    """The answer: the exact stiffness limit in N/m of each way, None where there is none."""

    question: Limits
    limits: tuple[float | None, float | None]


def solve(question: Limits) -> Found:
    """Compute both limits."""
    from hapkit_studio.analysis.stability import kb_plane  # off the first picture's way

    limits = [None if s is None else kb_plane.limit(s, question.damping) for s in question.settings]
    return Found(question, (limits[0], limits[1]))


def ways(studio: "Studio") -> tuple[Way, Way]:
    """Return both ways of the device and loop in force."""
    from hapkit_studio.analysis.setting import Setting
    from hapkit_studio.haptics import board_offer

    engine = studio.engine
    assert engine is not None
    device = engine.device
    setting = Setting(device.mass, device.viscous, quantum=device.quantum)
    offered = engine.offered_way
    rates = engine.loop.rate, None if offered is None else float(offered.rate)
    shares = None, None if offered is None else offered.share
    specs = studio.loop.spec, board_offer.spec_on_board(studio.loop.spec)
    found = []
    for where, rate, spec, share in zip(WAYS, rates, specs, shares, strict=True):
        delay, own = _steady(engine, where), None
        if delay is not None and rate is not None:
            own = _own(setting, rate, delay.mean, spec)
        found.append(Way(delay, rate, engine.missed_of(where), own, share))
    return found[0], found[1]


def wish(studio: "Studio") -> "Wish":
    """Return what the board is asked for, in the words of its offer."""
    from hapkit_studio.haptics import board_offer

    engine = studio.engine
    assert engine is not None
    quantum, rate = engine.device.quantum, studio.loop.board_rate
    return board_offer.Wish(engine.environment, dict(engine.values), engine.loop.estimator, quantum, rate)


def _steady(engine: "Engine", where: str) -> "Measured | None":
    """Return the delay of one way as everything in the window shows it and takes it."""
    found, steady = engine.delay_of(where), steady_delay(engine, where)
    return None if found is None or steady is None else found._replace(mean=steady)


def _own(setting: "Setting", rate: float, delay: float, spec: Any) -> "Setting | None":
    """Return what the limit of one way depends on; None where there is no exact one."""
    own = replace(setting, rate=rate, delay=delay, estimator=spec, controller=False)
    return own if own.linear else None


def cells(way: Way, limit: float | None) -> tuple[str, ...]:
    """Return what stands in a way's column, in the order of ROWS."""
    delay = UNKNOWN
    if way.delay is not None:
        delay = f"{number(1e3 * way.delay.mean, 2)} ± {number(1e3 * way.delay.spread, 2)}"
    stiffness = UNKNOWN if limit is None or way.setting is None else number(limit, 0)
    rate = UNKNOWN if way.rate is None else f"{way.rate:,.0f}"
    share = UNKNOWN if way.share is None else number(100.0 * way.share, 0)
    return delay, rate, stiffness, f"{way.missed:,d}", share


def short(way: Way, limit: float | None) -> tuple[str, str]:
    """Return a way's delay and limit with their units, for where room is short."""
    if way.delay is None:
        return "", "not measured yet"
    stiffness = cells(way, limit)[2]
    delay = f"{number(1e3 * way.delay.mean, 2)} ms"
    return delay, stiffness if stiffness == UNKNOWN else f"limit {stiffness} N/m"
