"""Rendering by the computer or the board: delay, stiffest stable spring, and bytes per second."""

from collections.abc import Callable

from hapkit_studio.haptics.board_rendering import ALIVE_APART
from hapkit_studio.protocol.framing import encode
from hapkit_studio.protocol.messages import BAUD, Alive, Force, Message, Sample, Telemetry
from tests.bench import board_limit
from tests.bench.board_limit import Swing
from tests.bench.frame import Row, without_board

NAME, ORDER = "board_limit", 41
SECONDS = 4.0
INSIDE, OUTSIDE, TOLERANCE = 0.97, 1.03, 0.03


def run() -> list[Row]:
    """Return delays, measured and theoretical limits, and bytes per second; no rows without the board."""
    if without_board():
        return []
    rows = _streams()
    for spec, damping in (("difference", 0.0), ("kalman", 1.0)):
        given = (damping, spec, SECONDS)
        rows += _way("computer", 1000, *given[:2], lambda k, g=given: board_limit.on_computer(k, *g))
        rows += _way("board", 1000, *given[:2], lambda k, g=given: board_limit.on_board(k, *g, 1000))
        rows += _way("board", 4000, *given[:2], lambda k, g=given: board_limit.on_board(k, *g, 4000))
    return rows


def measured(limit: float, swing: Callable[[float], Swing]) -> float:
    """Return the stiffness in N/m at which an oscillation does not grow, near a limit in N/m."""
    inside, outside = (swing(share * limit).rate for share in (INSIDE, OUTSIDE))
    return limit * (INSIDE - (OUTSIDE - INSIDE) * inside / (outside - inside))


def _way(name: str, rate: int, damping: float, spec: str, swing: Callable[[float], Swing]) -> list[Row]:
    first = swing(300.0)
    limit = board_limit.theory(damping, spec, rate, first.delay)
    found = measured(limit, swing)
    scene = f"{name} {rate:,} Hz, {spec}, B = {damping:g}"
    apart = found / limit - 1.0
    skipped = f" ({first.skipped} ticks skipped)" if first.skipped else ""
    return [
        Row(f"{scene}: delay{skipped}", 1e6 * first.delay, "µs"),
        Row(
            f"{scene}: stiffness held", found, "N/m", "theory", limit, found / limit,
            f"within {100 * TOLERANCE:.0f} %", abs(apart) < TOLERANCE,
        ),
    ]  # fmt: skip


def _streams() -> list[Row]:
    """Return the numbers of bytes per second on the line, where a byte takes ten bits."""
    streams = {
        "computer renders: up": _bytes(Sample) * 1000,
        "computer renders: down": _bytes(Force) * 1000,
        "board renders: up": _bytes(Telemetry) * 1000,
        "board renders: down": round(_bytes(Alive) / ALIVE_APART),
    }
    line = BAUD / 10
    return [Row(what, n / 1000, "kB/s", "line", line / 1000, n / line) for what, n in streams.items()]


def _bytes(kind: type[Message]) -> int:
    """Return the number of bytes in a message's frame."""
    values = {
        wire.name: "" if wire.code.endswith("s") else 1.1 if wire.code == "f" else 1 for wire in kind.layout()
    }
    return len(encode(kind(**values)))
