"""What commands share that run the loop live on a device: who renders, the hand, what each way came to."""

import argparse
import contextlib
import math
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from hapkit_studio.analysis import plane
from hapkit_studio.analysis.setting import Setting
from hapkit_studio.devices.port_errors import no_data
from hapkit_studio.dynamics.hand import Hand
from hapkit_studio.errors import DeviceError, ParameterError
from hapkit_studio.haptics import board_offer
from hapkit_studio.haptics.engine import Engine
from hapkit_studio.haptics.faults import Fault
from hapkit_studio.haptics.rendering import BOARD, COMPUTER, WAYS
from hapkit_studio.haptics.rig import DEVICE_GONE
from hapkit_studio.haptics.ring import RingReader

FRAME_SECONDS = 1 / 60
_PATIENCE = 10.0
_WHOLE = 0.9
"""Share of the time that samples must cover; less is said."""
_AGAIN = "Check the USB cable, then try again."
_MEASURING = 0.6
"""s in which the connection holds the force at zero and the computer's delay is measured."""


def options(command: argparse.ArgumentParser) -> None:
    """Declare who renders."""
    command.add_argument("--render", choices=WAYS, default=COMPUTER, help="who computes the force")
    command.add_argument(
        "--board-rate", type=float, metavar="Hz", help="of the board, by default the law's fastest"
    )


def begin(engine: Engine, reader: RingReader, where: str, rate: float | None) -> None:
    """Wait until the one that is to render does, the delays before it measured; raise a StudioError."""
    if rate is not None and where == COMPUTER:
        raise ParameterError("--board-rate is for --render board.")
    refusal = engine.board_refusal() if where == BOARD else ""
    if refusal:
        raise ParameterError(refusal)
    _wait(engine, lambda: len(reader.read()) > 0, no_data(getattr(engine.device, "port", ""), _PATIENCE))
    if where == BOARD:
        _wait(engine, lambda: engine.delay_of(COMPUTER) is not None or engine.fault is not None)
        time.sleep(_MEASURING)
        engine.set_where(where, rate)
    _wait(engine, lambda: engine.rendering == where)


def _wait(engine: Engine, so: Callable[[], bool], late: DeviceError | None = None) -> None:
    """Return once it is so; raise DeviceError where the loop ends, or late, or it takes too long."""
    limit = time.monotonic() + _PATIENCE
    while not so():
        health, fault = engine.health(), engine.fault
        if fault is not None or not health.running:
            raise DeviceError(fault_words(fault) if fault else f"{engine.device.title} is gone. {_AGAIN}")
        if time.monotonic() > limit:
            words = f"{engine.device.title} did not begin to render within {_PATIENCE:g} s. {_AGAIN}"
            raise late or DeviceError(words)
        time.sleep(0.01)


def is_gone(fault: Fault | None) -> bool:
    """Tell whether a fault means that the device went away: nothing more will come."""
    return fault is not None and fault.code == DEVICE_GONE


def fault_words(fault: Fault) -> str:
    """Return what ended a run, and what to do before the next one: a command does not look again."""
    return f"{fault.text} Force is zero. {_AGAIN if is_gone(fault) else 'Hold the handle, then try again.'}"


def play(engine: Engine, reader: RingReader, hand: Hand | None, seconds: float) -> tuple[np.ndarray, float]:
    """Return the rows of so many s and how many s it were; the hand moves as its script says.

    They are fewer where the device goes away, or a person ends it with Ctrl-C: what came is kept.
    """
    begin, pieces = time.perf_counter(), []
    reader.read()
    with contextlib.suppress(KeyboardInterrupt):
        while (t := time.perf_counter() - begin) < seconds and not is_gone(engine.fault):
            if hand is not None:
                engine.move_hand(None if t >= hand.release else float(hand.target(t)))
            pieces.append(reader.read())
            time.sleep(FRAME_SECONDS)
    if hand is not None:
        engine.move_hand(None)
    pieces.append(reader.read())
    return np.concatenate(pieces), min(time.perf_counter() - begin, seconds)


def remarks(found: dict[str, Any], wish: float | None, seconds: float, got: float) -> tuple[str, ...]:
    """Return what came otherwise than it was wished: the board's rate in Hz, the s of samples."""
    said = []
    rate = found[BOARD]["rate_Hz"]
    if wish is not None and rate < wish:
        said.append(
            f"The board renders at {rate:,.0f} Hz, not at {wish:,.0f} Hz: this law has time for no more."
        )
    if got < _WHOLE * seconds:
        said.append(
            f"Only {got:.2f} s of samples came in {seconds:g} s; a computer that is busy, or a virtual board "
            "on it, falls behind."
        )
    return tuple(said)


def both(engine: Engine) -> dict[str, Any]:
    """Return what is known of each way, to be called while the device is open."""
    found: dict[str, Any] = {"render": engine.where, "board_overruns": engine.overruns}
    for where in WAYS:
        delay = engine.delay_of(where)
        found[where] = {
            "rate_Hz": _rate(engine, where),
            "delay_us": None if delay is None else 1e6 * delay.mean,
            "delay_spread_us": None if delay is None else 1e6 * delay.spread,
            "stiffness_limit": None if delay is None else _limit(engine, where, delay.mean),
            "missed": engine.missed_of(where),
        }
    return found


def _rate(engine: Engine, where: str) -> float:
    if where == COMPUTER or engine.device.simulated:
        return engine.loop.rate
    way = engine.board_way
    return float(way.rate if way else board_offer.board_rate(engine.environment, engine.values))


def _limit(engine: Engine, where: str, delay: float) -> float | None:
    """Return the exact stiffness limit in N/m of a released handle, None where there is none."""
    impedance, device = engine.environment.impedance, engine.device
    spec = engine.loop.estimator if where == COMPUTER else board_offer.spec_on_board(engine.loop.estimator)
    setting = replace(
        Setting(device.mass, device.viscous, quantum=device.quantum),
        rate=_rate(engine, where),
        delay=delay,
        estimator=spec,
    )
    if impedance is None or not setting.linear:
        return None
    limit = plane.limit(setting, impedance(engine.values)[1])
    return None if math.isinf(limit) else float(limit)


def words(found: dict[str, Any]) -> list[str]:
    """Return the ways that were measured, a line each."""
    lines = []
    for where in WAYS:
        way = found[where]
        if way["delay_us"] is None:
            continue
        limit = way["stiffness_limit"]
        delay = f"delay {way['delay_us']:.0f} ± {way['delay_spread_us']:.0f} µs"
        stiffness = "" if limit is None else f", stiffness limit {limit:,.0f} N/m released"
        lines.append(f"{where}: {way['rate_Hz']:,.0f} Hz, {delay}{stiffness}, {way['missed']} missed")
    return lines
