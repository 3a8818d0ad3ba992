"""``run --device``: an environment on a device, live, rendered by the computer or by its board."""

import argparse
import dataclasses

import numpy as np

from hapkit_studio import api
from hapkit_studio import devices as device_list
from hapkit_studio.commands import rendered
from hapkit_studio.commands.given import environment, estimator_spec, key_values
from hapkit_studio.dynamics.hand import hand_named
from hapkit_studio.errors import ParameterError
from hapkit_studio.haptics import rows
from hapkit_studio.haptics.engine import Engine
from hapkit_studio.parameters import Parameter
from hapkit_studio.workshop.own import switched_off

SECONDS = Parameter("seconds", "Seconds", "s", 2.0, 0.1, 3600.0)
FAULT = 2
"""Exit code of a run that a fault has ended."""


def live(options: argparse.Namespace) -> tuple[api.Run, dict]:
    """Return the run and what each way of rendering came to; raise a StudioError."""
    chosen = environment(options.environment, options.trust)
    device = device_list.named(options.device)
    hand = hand_named(options.hand) if options.hand else None
    if hand is not None and not (getattr(device, "hand", False) or getattr(device, "simulated", False)):
        raise ParameterError(
            f"{options.device} has no simulated hand: leave --hand away and move the handle."
        )
    seconds = SECONDS.check(options.seconds)
    engine = Engine(device, chosen)
    engine.set_environment(chosen, key_values(options.parameter))
    engine.set_loop(delay=options.delay, estimator=estimator_spec(options.estimator))
    if engine.device.simulated:
        engine.set_loop(rate=options.rate)
    reader = engine.reader()
    engine.start()
    try:
        rendered.begin(engine, reader, options.render, options.board_rate)
        table, played = rendered.play(engine, reader, hand, seconds, rendered.say_doubt(engine))
        found = rendered.both(engine, table)
        remarks = rendered.remarks(engine, found, options.board_rate)
        fault = engine.fault
    finally:
        engine.close()
    if not len(table):
        raise ParameterError(f"Not one sample came in {played:.3g} s.")
    run = _as_run(table, engine, options, found)
    got = float(run.time[-1])
    remarks += switched_off(chosen)
    remarks += [] if rendered.is_gone(fault) else rendered.too_few(engine, played, got)
    if played < seconds and fault is None:
        remarks.append(f"Ended after {played:.2f} s of {seconds:g} s by Ctrl-C.")
    faults = (rendered.fault_words(fault),) if fault else ()
    return dataclasses.replace(run, faults=faults, warnings=tuple(remarks)), found


def _as_run(table: np.ndarray, engine: Engine, options: argparse.Namespace, found: dict) -> api.Run:
    """Return the rows as ``simulate`` would; times are the device's own."""
    chosen, values = engine.environment, engine.values
    states = table[:, rows.STATE : rows.STATE + len(chosen.state_names)]
    settings = {
        "environment": chosen.key,
        "parameters": {
            p.key: p.text(values[p.key]) if p.discrete else values[p.key] for p in chosen.parameters
        },
        "hand": options.hand or "own",
        "device": options.device,
        "render": options.render,
        "rate_Hz": found[options.render]["rate_Hz"],
        "delay_s": engine.loop.delay,
        "estimator": engine.loop.estimator,
    }
    time = table[:, rows.BOARD_TIME] - table[0, rows.BOARD_TIME]
    return api.Run(
        time=time,
        position=table[:, rows.POSITION],
        velocity=table[:, rows.VELOCITY],
        true_position=table[:, rows.TRUE_POSITION],
        true_velocity=table[:, rows.TRUE_VELOCITY],
        force=table[:, rows.ASKED],
        applied_force=table[:, rows.APPLIED],
        hand_force=table[:, rows.HAND_FORCE],
        energy=table[:, rows.ENERGY],
        flags=table[:, rows.FLAGS].astype(int),
        state=states.copy(),
        state_names=chosen.state_names,
        faults=(),
        warnings=(),
        settings=settings,
    )
