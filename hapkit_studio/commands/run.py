"""The command that renders an environment: headless, or live on a device."""

import argparse

import numpy as np

from hapkit_studio import api
from hapkit_studio.commands import rendered, run_on
from hapkit_studio.commands.base import Command, Result
from hapkit_studio.commands.given import ESTIMATOR_HELP, environment, estimator_spec, key_values
from hapkit_studio.errors import ParameterError
from hapkit_studio.haptics import rows


def options(command: argparse.ArgumentParser) -> None:
    """Declare what ``run`` takes."""
    command.add_argument("environment", help="an environment's key, or a Python file: my_env.py")
    command.add_argument("--trust", action="store_true", help="execute a file that you have read")
    command.add_argument("-p", "--parameter", action="append", default=[], metavar="KEY=VALUE")
    command.add_argument(
        "--hand", metavar="SCRIPT", help="press, tap, stroke, …; without it the handle is free"
    )
    command.add_argument("--seconds", type=float, default=2.0, metavar="s")
    command.add_argument("--rate", type=float, default=1000.0, metavar="Hz")
    command.add_argument("--delay", type=float, default=0.0, metavar="s")
    command.add_argument("--estimator", default="difference", metavar="NAME", help=ESTIMATOR_HELP)
    command.add_argument("--seed", type=int, default=0)
    command.add_argument("--device", metavar="KEY", help="render live on a device, by its key or its port")
    rendered.options(command)
    command.add_argument("--csv", metavar="PATH", help="write every sample")
    command.add_argument("--plot", metavar="PATH", help="write a picture")


def run(options: argparse.Namespace) -> Result:
    """Render an environment, by its key or its Python file; write CSV and picture where asked."""
    done, found = run_on.live(options) if options.device is not None else (_headless(options), {})
    if options.csv:
        done.save(options.csv)
    if options.plot:
        done.plot(options.plot)
    return _of_run(done, [path for path in (options.csv, options.plot) if path], found)


def _headless(options: argparse.Namespace) -> api.Run:
    if options.render != rendered.COMPUTER or options.board_rate is not None:
        raise ParameterError("--render board needs --device with a board: --device virtual-board, or a port.")
    return api.simulate(
        environment(options.environment, options.trust),
        key_values(options.parameter),
        hand=options.hand,
        rate=options.rate,
        delay=options.delay,
        estimator=estimator_spec(options.estimator),
        seconds=options.seconds,
        seed=options.seed,
    )


def _of_run(done: api.Run, written: list[str], found: dict) -> Result:
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
        "written": written,
        **found,
    }
    lines = [
        f"{done.settings['environment']}: {len(done.time)} samples, {numbers['seconds']:g} s",
        f"position {1e3 * numbers['position_min']:.2f} to {1e3 * numbers['position_max']:.2f} mm, "
        f"at the end {1e3 * numbers['final_position']:.2f} mm",
        f"force up to {numbers['peak_force']:.2f} N, at the end {numbers['final_force']:.2f} N"
        + (f", clamped in {clamped} samples" if clamped else ""),
        f"energy given to the hand {1e3 * numbers['energy_given']:.3f} mJ",
    ]
    lines += rendered.words(found) if found else []
    lines += [*done.faults, *done.warnings] + [f"wrote {path}" for path in written]
    return Result("\n".join(lines), numbers, run_on.FAULT if found and done.faults else 0)


def demo(path: str) -> Result:
    """Render a hand pressing into the wall and write its picture."""
    done = api.simulate("wall", {"stiffness": 400.0, "damping": 2.0}, hand="press", seconds=3.0)
    done.plot(path)
    return _of_run(done, [path], {})


COMMAND = Command("run", "render an environment, headless or on a device", run, options, order=10)
