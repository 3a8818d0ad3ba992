"""Live runs on a device for the command line: renderer, scripted hand, results."""

import argparse
import contextlib
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from hapkit_studio import interrupts
from hapkit_studio.analysis.stability import on_board
from hapkit_studio.analysis.stability.verdict import of_spring
from hapkit_studio.commands.base import option
from hapkit_studio.devices.port_errors import no_data
from hapkit_studio.dynamics.hand import Hand
from hapkit_studio.dynamics.loop_settings import BOARD, COMPUTER, RENDERERS, LoopSettings
from hapkit_studio.errors import DeviceError, ParameterError
from hapkit_studio.formatting import printable
from hapkit_studio.haptics import rows
from hapkit_studio.haptics.arrays import DEVICE_GONE, SLOW_LAW, SLOW_LINK
from hapkit_studio.haptics.engine import Engine
from hapkit_studio.haptics.health import SIMPLIFY, Fault, Health
from hapkit_studio.haptics.rows import RingReader
from hapkit_studio.sessions.file import SessionError
from hapkit_studio.sessions.recorder import Recorder

FRAME_SECONDS = 1 / 60
_PATIENCE = 10.0
_AGAIN = "Check the USB cable, then try again."
_REMARK_SECONDS = 0.005
"""s: a remark is printed after this time without force."""
_MEASURING = 0.6
"""s: duration of zero force after connecting, during which the computer's delay is measured."""
_FEWEST_DELAYS = 100
"""Smallest number of measured delays from which a mean is computed."""


OPTIONS = (
    option("--render", choices=RENDERERS, default=COMPUTER, help="renderer of the force"),
    option("--board-rate", type=float, metavar="Hz", help="of the board, by default the law's highest"),
)


@dataclass(frozen=True)
class Played:
    """The result of a live run: rows, duration in s, data of both renderers, remarks, fault and health."""

    table: np.ndarray
    seconds: float
    found: dict[str, Any]
    remarks: list[str]
    fault: Fault | None
    health: Health
    lost_rows: int


def run(
    engine: Engine, options: argparse.Namespace, hand: Hand | None, seconds: float, record: str | None = None
) -> Played:
    """Start an engine, render for some seconds with the chosen renderer, and close the engine.

    ``record`` is the path of a session to write. Raise StudioError if the device cannot render.
    """
    reader = engine.reader()
    if engine.device.measures_delay:
        of_spring(LoopSettings(), 300.0, 0.0)  # compile the check of the link before the hand starts to move
    with contextlib.closing(engine):
        engine.start()
        begin(engine, reader, options.render, options.board_rate)
        engine.health()  # reading the health resets its counters
        with _recorded(engine, record):
            table, took = play(engine, reader, hand, seconds, print_link_warning(engine))
        health, found = engine.health(), _figures(engine, table)
        remarks = _remarks(engine, found, options.board_rate)
        return Played(table, took, found, remarks, engine.fault, health, reader.lost)


@contextlib.contextmanager
def _recorded(engine: Engine, path: str | None) -> Iterator[None]:
    """Write a session during the run if a path is given; raise SessionError if it cannot be written."""
    if path is None:
        yield
        return
    with contextlib.closing(Recorder()) as recorder:
        recorder.follow(engine)
        recorder.record(path)
        yield
        recorder.stop()
        if recorder.progress is not None:
            raise SessionError(recorder.progress.error)


def begin(engine: Engine, reader: RingReader, where: str, rate: float | None) -> None:
    """Wait until the delays are measured and the chosen renderer is active; raise StudioError on failure."""
    if rate is not None and where == COMPUTER:
        raise ParameterError("--board-rate is for --render board.")
    _check_board(engine, where)
    _wait(engine, lambda: len(reader.read()) > 0, no_data(engine.device.port, _PATIENCE))
    if where == BOARD:
        time.sleep(_MEASURING)
        engine.set_where(where, rate)
        _check_board(engine, where)
    _wait(engine, lambda: engine.rendering == where or bool(where == BOARD and engine.decision().refusal))
    _check_board(engine, where)


def _check_board(engine: Engine, where: str) -> None:
    """Raise ParameterError if the board shall render but cannot."""
    refusal = engine.decision(wait=True).refusal if where == BOARD else ""
    if refusal:
        raise ParameterError(refusal)


def _wait(engine: Engine, so: Callable[[], bool], late: DeviceError | None = None) -> None:
    """Wait for a condition; raise DeviceError if the loop ends, or ``late`` after a time-out.

    A link that is too slow for the computer may be fast enough for the board, so a slow link does not end the
    wait.
    """
    limit = time.monotonic() + _PATIENCE
    while not so():
        health, fault = engine.health(), engine.fault
        if not health.running or (fault is not None and fault.code != SLOW_LINK):
            raise DeviceError(
                fault_text(fault) if fault else f"{engine.device.title} is disconnected. {_AGAIN}"
            )
        if time.monotonic() > limit:
            text = f"{engine.device.title} did not start to render within {_PATIENCE:g} s. {_AGAIN}"
            raise late or DeviceError(text)
        time.sleep(0.01)


def is_gone(fault: Fault | None) -> bool:
    """Return True if a fault means that the device was disconnected."""
    return fault is not None and fault.code == DEVICE_GONE


def _is_final(fault: Fault | None) -> bool:
    """Return True if the loop cannot recover from a fault."""
    return fault is not None and fault.code in (DEVICE_GONE, SLOW_LINK, SLOW_LAW)


def fault_text(fault: Fault) -> str:
    """Return why a run ended, and what to do before the next run."""
    if fault.code == SLOW_LINK:
        return f"{fault.text} Force is zero. Let the board render (--render board), or use a faster port."
    if fault.code == SLOW_LAW:
        return f"{fault.text} Force is zero. {SIMPLIFY}"
    return f"{fault.text} Force is zero. {_AGAIN if is_gone(fault) else 'Hold the handle, then try again.'}"


def print_link_warning(engine: Engine) -> Callable[[float], None]:
    """Return a callback that receives a run's time in s, and prints the link's warning once on stderr."""
    done = False

    def watch(now: float) -> None:
        nonlocal done
        delay = engine.delay_of(engine.where)
        if done or (now < _MEASURING and (delay is None or delay.total < _FEWEST_DELAYS)):
            return
        done = True
        text = "" if _is_final(engine.fault) else on_board.link_warning(engine)
        if text:
            print(printable(text), file=sys.stderr, flush=True)

    return watch


def play(
    engine: Engine,
    reader: RingReader,
    hand: Hand | None,
    seconds: float,
    watch: Callable[[float], None] = lambda now: None,
) -> tuple[np.ndarray, float]:
    """Run with the scripted hand; return the rows and the duration of the run in s.

    The run ends early if the device disappears, if its link is too slow, or if the user presses Ctrl+C. The
    rows received until then are returned. ``watch`` is called regularly with the time in s since the start.
    """
    begin, pieces = time.perf_counter(), []
    reader.read()
    with contextlib.suppress(KeyboardInterrupt):
        while (t := time.perf_counter() - begin) < seconds and not _is_final(engine.fault):
            if hand is not None:
                engine.move_hand(None if t >= hand.release else float(hand.target(t)))
            pieces.append(reader.read())
            watch(t)
            time.sleep(FRAME_SECONDS)
    interrupts.listen()  # accept Ctrl+C again: an earlier Ctrl+C may have ended the run
    if hand is not None:
        engine.move_hand(None)
    pieces.append(reader.read())
    return np.concatenate(pieces), min(time.perf_counter() - begin, seconds)


def _remarks(engine: Engine, found: dict[str, Any], wish: float | None) -> list[str]:
    """Return remarks if the board's rate is too low, the motor is off, or a spring is too stiff."""
    remarks = []
    rate = found[BOARD]["rate_Hz"]
    if wish is not None and rate is not None and rate < wish:
        remarks.append(
            f"The board renders at {rate:,.0f} Hz, not at {wish:,.0f} Hz: this law takes too long for more."
        )
    doubt = "" if _is_final(engine.fault) else on_board.link_warning(engine)
    remarks += [doubt] if doubt else []
    without = found["link"]["without_force_s"]
    counted = engine.health().link
    if counted.clock_jumps:
        remarks.append(
            f"The board's clock went back or jumped {counted.clock_jumps} times: time was corrected."
        )
    if without >= _REMARK_SECONDS:
        causes = {
            "No sample arrived over USB for 20 ms": counted.no_sample,
            "This computer was busy with other programs for 20 ms": counted.away,
            "The law blocked the loop for 20 ms": counted.law_blocked,
            "The board switched its motor off, because forces came too late or not at all": counted.cut,
        }
        why = [f"{cause}: {n} times." if n > 1 else f"{cause}." for cause, n in causes.items() if n]
        remarks.append(" ".join([f"No force for {without:.2f} s.", *why]))
    return remarks


def _figures(engine: Engine, table: np.ndarray) -> dict[str, Any]:
    """Return the measured data of computer, board and link of a device; ``table`` has the run's rows."""
    found: dict[str, Any] = {"render": engine.where, "board_overruns": engine.missed_of("board")}
    for where in RENDERERS:
        delay, loop = engine.delay_of(where), engine.loop_of(where, 0.0)
        found[where] = {
            "rate_Hz": None if loop is None else loop.rate,
            "delay_us": None if delay is None else 1e6 * delay.mean,
            "delay_spread_us": None if delay is None else 1e6 * delay.spread,
            "stiffness_limit": on_board.rendering_limit(engine, where),
            "missed": engine.missed_of(where),
        }
    counted = engine.health().link
    off = (table[:, rows.FLAGS].astype(int) & (rows.STALE | rows.FAULT)) != 0
    found["link"] = {
        "lost_frames": counted.lost_frames,
        "crc_errors": counted.crc_errors,
        "board_crc_errors": counted.board_errors,
        "stale_forces": counted.stale_forces,
        "clock_jumps": counted.clock_jumps,
        "without_force_s": float(table[off, rows.PERIOD].sum()),
        "motor_off": {
            "no_sample": counted.no_sample,
            "computer_busy": counted.away,
            "law_too_long": counted.law_blocked,
            "board_watchdog": counted.cut,
        },
    }
    return found


def summary_lines(found: dict[str, Any]) -> list[str]:
    """Return a line for each renderer that was measured, and a line for the link."""
    lines = []
    for where in RENDERERS:
        way = found[where]
        if way["delay_us"] is None:
            continue
        limit = way["stiffness_limit"]
        delay = f"delay {way['delay_us']:,.0f} ± {way['delay_spread_us']:,.0f} µs"
        stiffness = "" if limit is None else f", stiffness limit {limit:,.0f} N/m released"
        lines.append(f"{where}: {way['rate_Hz']:,.0f} Hz, {delay}{stiffness}, {way['missed']} missed")
    if lines:
        counted = found["link"]
        lines.append(
            f"link: {counted['lost_frames']} frames lost, {counted['crc_errors']} CRC errors here and "
            f"{counted['board_crc_errors']} on the board, {counted['stale_forces']} stale forces refused, "
            f"{counted['without_force_s']:.2f} s without force"
        )
    return lines
