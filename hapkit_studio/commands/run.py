"""The command that renders an environment: headless, or live on a device by computer or board."""

import argparse
import dataclasses
from pathlib import Path

import numpy as np

from hapkit_studio import api
from hapkit_studio import devices as device_list
from hapkit_studio.commands import base, live_run
from hapkit_studio.dynamics.hand import hand_named
from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import ParameterError
from hapkit_studio.formatting import compact
from hapkit_studio.haptics import rows
from hapkit_studio.haptics.engine import Engine
from hapkit_studio.interrupts import INTERRUPTED
from hapkit_studio.parameters import Parameter
from hapkit_studio.sessions.file import SUFFIX
from hapkit_studio.sessions.settings_events import of_scene
from hapkit_studio.workshop.own import switched_off

SECONDS = Parameter("seconds", "Seconds", "s", 2.0, 0.1, 3600.0)
FAULT = 2
"""Exit code of a run that ended with a fault."""
_COVERED = 0.9
"""A remark is printed if the samples cover less than this fraction of the time."""
_REMARK_SKIPPED = 0.01
"""A remark is printed if more than this fraction of the samples was skipped."""


def live(options: argparse.Namespace, chosen: Environment) -> tuple[api.Run, dict]:
    """Return the run and the measurements of each renderer; raise StudioError if the device cannot render."""
    device = device_list.named(options.device)
    hand = hand_named(options.hand) if options.hand else None
    if hand is not None and not device.simulated_hand:
        raise ParameterError(f"{options.device} has no simulated hand: omit --hand and move the handle.")
    seconds = SECONDS.check(options.seconds)
    engine = Engine(device, chosen)
    engine.set_environment(chosen, base.key_values(options.parameter))
    engine.set_loop(delay=options.delay, estimator=base.estimator_spec(options.estimator))
    if not device.own_clock:
        engine.set_loop(rate=options.rate)
    played = live_run.run(engine, options, hand, seconds, options.record)
    fault, took = played.fault, played.seconds
    if not len(played.table):
        raise ParameterError(f"No sample arrived in {compact(took, 3)} s.")
    run = _as_run(played.table, engine, options, played.found)
    got = float(run.time[-1])
    remarks = [*played.remarks, *switched_off(chosen)]
    if options.render != live_run.COMPUTER:
        remarks += map(str, chosen.force.remarks)
    skipped = played.found[live_run.COMPUTER]["missed"]
    if device.model is not None and skipped > _REMARK_SKIPPED * len(played.table):
        remarks.append(f"{skipped:,} samples were skipped, because the loop was late.")
    if got < _COVERED * took and not live_run.is_gone(fault):
        remarks.append(f"Only {got:.2f} s of samples came in {took:g} s.")
    found = {**played.found, "interrupted": took < seconds and fault is None}
    if found["interrupted"]:
        remarks.append(f"Ended after {took:.2f} s of {seconds:g} s by Ctrl+C.")
    faults = (live_run.fault_text(fault),) if fault else ()
    return dataclasses.replace(run, faults=faults, warnings=tuple(remarks)), found


def _as_run(table: np.ndarray, engine: Engine, options: argparse.Namespace, found: dict) -> api.Run:
    """Return the rows as a Run like that of ``simulate``, with the device's times."""
    settings = {
        **of_scene(engine.environment, engine.values),
        "hand": options.hand or "own",
        "device": options.device,
        "render": options.render,
        "rate_Hz": found[options.render]["rate_Hz"],
        "delay_s": engine.loop.delay,
        "estimator": engine.loop.estimator,
        "max_force_N": engine.max_force,
    }
    names = engine.environment.state_names
    return api.Run(
        time=table[:, rows.BOARD_TIME] - table[0, rows.BOARD_TIME],
        **api.columns_of(table),
        state=table[:, rows.STATE : rows.STATE + len(names)].copy(),
        state_names=names,
        faults=(),
        warnings=(),
        settings=settings,
    )


OPTIONS = (
    base.ENVIRONMENT,
    base.TRUST,
    base.PARAMETER,
    base.option("--hand", metavar="SCRIPT", help="press, tap, stroke, …; by default the handle is free"),
    base.option("--seconds", type=float, default=2.0, metavar="s"),
    base.option("--rate", type=float, default=1000.0, metavar="Hz"),
    base.option("--delay", type=float, default=0.0, metavar="s"),
    base.option("--estimator", default="difference", metavar="NAME", help=base.ESTIMATOR_HELP),
    base.option("--seed", type=int, default=0),
    base.option("--device", metavar="KEY", help="render on a device, given by its key or port"),
    *live_run.OPTIONS,
    base.option("--csv", metavar="PATH", help="write every sample"),
    base.option("--record", metavar="PATH", help=f"write a session: NAME{SUFFIX}"),
    base.PLOT,
)


def run(options: argparse.Namespace) -> base.Result:
    """Render an environment given by key or Python file; write CSV, figure and session if requested."""
    if options.record and Path(options.record).suffix != SUFFIX:
        raise ParameterError(f"A session's name ends in {SUFFIX}, not {options.record}.")
    chosen = base.environment_named(options.environment, options.trust)
    done, found = live(options, chosen) if options.device is not None else (headless(options, chosen), {})
    if options.csv:
        done.save(options.csv)
    if options.plot:
        done.plot(options.plot, chosen)
    if options.record and options.device is None:
        done.save(options.record)
    return _of_run(done, [path for path in (options.csv, options.plot, options.record) if path], found)


def headless(options: argparse.Namespace, chosen: Environment) -> api.Run:
    """Return the simulated run; raise ParameterError for an invalid option."""
    if options.render != live_run.COMPUTER or options.board_rate is not None:
        raise ParameterError("--render board needs --device with a board: --device virtual-board, or a port.")
    return api.simulate(
        chosen,
        base.key_values(options.parameter),
        hand=options.hand,
        rate=options.rate,
        delay=options.delay,
        estimator=base.estimator_spec(options.estimator),
        seconds=options.seconds,
        seed=options.seed,
    )


def _of_run(done: api.Run, written: list[str], found: dict) -> base.Result:
    clamped = int(np.count_nonzero(done.flags & rows.CLAMPED))
    numbers = {
        **done.settings,
        "samples": len(done.time),
        "seconds": float(done.time[-1]) if found else len(done.time) / done.settings["rate_Hz"],
        "position_min": float(done.position.min()),
        "position_max": float(done.position.max()),
        "final_position": float(done.position[-1]),
        "final_force": float(done.applied_force[-1]),
        "peak_force": float(np.abs(done.applied_force).max()),
        "energy_given": float(done.energy[-1]),
        "clamped_samples": clamped,
        "faults": list(done.faults),
        "warnings": list(done.warnings),
        **found,
    }
    lines = [
        f"{done.settings['environment']}: {len(done.time):,} samples, {numbers['seconds']:g} s",
        f"position {1e3 * numbers['position_min']:.2f} to {1e3 * numbers['position_max']:.2f} mm, "
        f"at the end {1e3 * numbers['final_position']:.2f} mm",
        f"force up to {numbers['peak_force']:.2f} N, at the end {numbers['final_force']:.2f} N"
        + (f", clamped in {clamped:,} samples" if clamped else ""),
        f"energy given to the hand {1e3 * numbers['energy_given']:.3f} mJ",
    ]
    lines += live_run.summary_lines(found) if found else []
    lines += [*done.faults, *done.warnings]
    code = FAULT if found and done.faults else INTERRUPTED if found.get("interrupted") else 0
    return base.with_files("\n".join(lines), numbers, written, code)


def demo(path: str) -> base.Result:
    """Render a hand that presses into the wall, and write the figure."""
    done = api.simulate("wall", {"stiffness": 400.0, "damping": 2.0}, hand="press", seconds=3.0)
    done.plot(path)
    return _of_run(done, [path], {})


COMMAND = base.Command("run", "render an environment, headless or on a device", run, OPTIONS, 10)
