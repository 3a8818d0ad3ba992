"""The command that runs the real-time loop and measures it."""

import argparse

import numpy as np

from hapkit_studio import devices as device_list
from hapkit_studio.commands import live_run
from hapkit_studio.commands.base import Command, Result, option
from hapkit_studio.dynamics.hand import hand_named
from hapkit_studio.haptics import rows
from hapkit_studio.haptics.engine import Engine
from hapkit_studio.parameters import Parameter

TEST_SECONDS = Parameter("seconds", "Seconds", "s", 5.0, 0.1, 86_400.0)


OPTIONS = (
    option("device", nargs="?", default="simulated", help="a device's key or a port"),
    option("--rate", type=float, default=1000.0, metavar="Hz"),
    option("--seconds", type=float, default=5.0, metavar="s"),
    option("--environment", default="wall", metavar="KEY", help="what is rendered"),
    *live_run.OPTIONS,
)


def loop_test(options: argparse.Namespace) -> Result:
    """Run the loop on a device while a hand presses into the wall; measure lateness and period."""
    seconds = TEST_SECONDS.check(options.seconds)
    engine = Engine(device_list.named(options.device), options.environment)
    engine.set_loop(rate=options.rate)
    played = live_run.run(engine, options, hand_named("press"), seconds)
    table, health = played.table, played.health
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
        "lost_frames": health.link.lost_frames,
        "lost_rows": played.lost_rows,
        "delay_us": None if health.delay is None else 1e6 * health.delay,
        "priority": health.priority.text,
        "fault": played.fault.text if played.fault else "",
        "warnings": played.remarks,
        **played.found,
    }
    late, period = health.lateness_us, numbers["period_us"]
    delay = "delay not measured" if health.delay is None else f"delay {1e6 * health.delay:,.0f} µs"
    text = (
        f"{numbers['samples']:,} samples, period {period['mean']:,.1f} µs "
        f"({period['min']:,.0f} to {period['max']:,.0f})\n"
        f"late: median {late['p50']:,.0f} µs, p99 {late['p99']:,.0f}, p99.9 {late['p99.9']:,.0f}, "
        f"worst {late['max']:,.0f}\n"
        f"missed {health.missed}, lost frames {health.link.lost_frames}, "
        f"{delay}\n"
        + "".join(f"{line}\n" for line in (*live_run.summary_lines(played.found), *played.remarks))
        + f"{health.priority.text}. {health.priority.how}".rstrip()
    )
    return Result(text, numbers)


COMMAND = Command("loop-test", "run the real-time loop and measure it", loop_test, OPTIONS, 90)
