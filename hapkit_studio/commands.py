"""What each command of the command line does: it returns words for a person and an object for a program."""

import argparse
import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hapkit_studio import api, catalogue
from hapkit_studio import devices as device_list
from hapkit_studio import environments as library
from hapkit_studio.dynamics.estimators import Spec
from hapkit_studio.dynamics.hand import hand_named
from hapkit_studio.errors import ParameterError
from hapkit_studio.haptics import rows
from hapkit_studio.haptics.engine import Engine
from hapkit_studio.parameters import Parameter
from hapkit_studio.workshop import asking

FRAME_SECONDS = 1 / 60
TEST_SECONDS = Parameter("seconds", "Seconds", "s", 5.0, 0.1, 86_400.0)


@dataclass(frozen=True)
class Result:
    """A command's outcome: text for a person, one object for ``--json``."""

    text: str
    as_json: dict


def key_values(
    pairs: Sequence[str], what: str = "A parameter", like: str = "stiffness=400"
) -> dict[str, object]:
    """Return {key: number or word} of KEY=VALUE pairs; raise ParameterError that names what they are."""
    found: dict[str, object] = {}
    for pair in pairs:
        key, equals, value = pair.partition("=")
        if not equals or not key or not value:
            raise ParameterError(f"{what} is given as KEY=VALUE, e.g. {like}, not {pair!r}.")
        try:
            found[key] = float(value)
        except ValueError:
            found[key] = value
    return found


def estimator_spec(text: str) -> Spec:
    """Return an estimator of ``iir`` or ``iir:cutoff=20``; raise ParameterError."""
    name, colon, options = text.partition(":")
    if not colon:
        return name
    numbers = key_values(options.split(","), "An option", "cutoff=20")
    for key, value in numbers.items():
        if not isinstance(value, float):
            raise ParameterError(f"The estimator's {key} takes a number, not {value!r}.")
    return name, numbers  # type: ignore[return-value]


def run(options: argparse.Namespace) -> Result:
    """Render an environment, by its key or its Python file, headless; write CSV and picture where asked."""
    wanted = options.environment
    done = api.simulate(
        asking.environment(wanted, options.trust) if wanted.endswith(".py") else wanted,
        key_values(options.parameter),
        hand=options.hand,
        rate=options.rate,
        delay=options.delay,
        estimator=estimator_spec(options.estimator),
        seconds=options.seconds,
        seed=options.seed,
    )
    if options.csv:
        done.save(options.csv)
    if options.plot:
        done.plot(options.plot)
    return _of_run(done, [path for path in (options.csv, options.plot) if path])


def _of_run(done: api.Run, written: list[str]) -> Result:
    clamped = int(np.count_nonzero(done.flags & rows.CLAMPED))
    numbers = {
        **done.settings,
        "samples": len(done.time),
        "seconds": len(done.time) / done.settings["rate_Hz"],
        "position_min": float(done.position.min()),
        "position_max": float(done.position.max()),
        "final_position": float(done.position[-1]),
        "final_force": float(done.applied_force[-1]),
        "peak_force": float(np.abs(done.applied_force).max()),
        "energy_given": float(done.energy[-1]),
        "clamped_samples": clamped,
        "faults": list(done.faults),
        "warnings": list(done.warnings),
        "written": written,
    }
    lines = [
        f"{done.settings['environment']}: {len(done.time)} samples, {numbers['seconds']:g} s",
        f"position {1e3 * numbers['position_min']:.2f} to {1e3 * numbers['position_max']:.2f} mm, "
        f"at the end {1e3 * numbers['final_position']:.2f} mm",
        f"force up to {numbers['peak_force']:.2f} N, at the end {numbers['final_force']:.2f} N"
        + (f", clamped in {clamped} samples" if clamped else ""),
        f"energy given to the hand {1e3 * numbers['energy_given']:.3f} mJ",
    ]
    lines += [*done.faults, *done.warnings] + [f"wrote {path}" for path in written]
    return Result("\n".join(lines), numbers)


def demo(path: str) -> Result:
    """Render a hand pressing into the wall and write its picture."""
    done = api.simulate("wall", {"stiffness": 400.0, "damping": 2.0}, hand="press", seconds=3.0)
    done.plot(path)
    return _of_run(done, [path])


def environments(options: argparse.Namespace) -> Result:
    """List the environments with their parameters, units and limits, or print the page about them."""
    listed, lines = [], []
    for e in library.discover().values():
        lines.append(f"{e.key:<19} {e.summary}")
        described = []
        for p in e.parameters:
            word = p.options if p.discrete else [p.low, p.high]  # type: ignore[union-attr]
            default = p.text(p.default) if p.discrete else p.default
            described.append(
                {"key": p.key, "label": p.label, "unit": p.unit, "default": default, "range": word}
            )
            limits = " | ".join(p.options) if p.discrete else f"{p.low:g} to {p.high:g} {p.unit}"  # type: ignore[union-attr]
            lines.append(f"    {p.key:<19} {p.text(p.default):<12} [{limits}]")
        listed.append({"key": e.key, "title": e.title, "summary": e.summary, "parameters": described})
    text = catalogue.markdown().rstrip() if options.markdown else "\n".join(lines)
    return Result(text, {"environments": listed})


def devices(options: argparse.Namespace) -> Result:
    """List the devices that can be chosen now."""
    entries = device_list.available()
    text = "\n".join(f"{e.key:<16} {e.title}" for e in entries)
    return Result(text, {"devices": [{"key": e.key, "title": e.title} for e in entries]})


def loop_test(options: argparse.Namespace) -> Result:
    """Run the loop on a device with a hand pressing into the wall; measure lateness and period."""
    seconds = TEST_SECONDS.check(options.seconds)
    engine = Engine(device_list.named(options.device), "wall")
    reader = engine.reader()
    engine.set_loop(rate=options.rate)
    engine.start()
    try:
        pieces = _press(engine, reader, seconds)
        health = engine.health()
        fault = engine.fault
    finally:
        engine.close()
    table = np.concatenate(pieces)
    periods = 1e6 * np.diff(table[:, rows.HOST_TIME]) if len(table) > 1 else np.zeros(1)
    numbers = {
        "device": options.device,
        "rate_Hz": engine.loop.rate,
        "samples": len(table),
        "lateness_us": health.lateness_us,
        "period_us": {
            "mean": float(periods.mean()),
            "min": float(periods.min()),
            "max": float(periods.max()),
        },
        "compute_us": {"p50": 1e6 * float(np.median(table[:, rows.COMPUTE])) if len(table) else 0.0},
        "missed": health.missed,
        "lost_frames": health.lost_frames,
        "lost_rows": reader.lost,
        "delay_us": 1e6 * health.delay,
        "priority": health.priority.text,
        "fault": fault.text if fault else "",
    }
    late, period = health.lateness_us, numbers["period_us"]
    text = (
        f"{numbers['samples']} samples, period {period['mean']:.1f} µs "
        f"({period['min']:.0f} to {period['max']:.0f})\n"
        f"late: median {late['p50']:.0f} µs, p99 {late['p99']:.0f}, p99.9 {late['p99.9']:.0f}, "
        f"worst {late['max']:.0f}\n"
        f"missed {health.missed}, lost frames {health.lost_frames}, delay {numbers['delay_us']:.0f} µs\n"
        f"{health.priority.text}. {health.priority.how}".rstrip()
    )
    return Result(text, numbers)


def _press(engine: Engine, reader, seconds: float) -> list[np.ndarray]:
    hand = hand_named("press")
    begin = time.perf_counter()
    pieces = []
    engine.health()
    while (t := time.perf_counter() - begin) < seconds:
        engine.move_hand(hand.target(t))
        pieces.append(reader.read())
        time.sleep(FRAME_SECONDS)
    engine.move_hand(None)
    pieces.append(reader.read())
    return pieces
