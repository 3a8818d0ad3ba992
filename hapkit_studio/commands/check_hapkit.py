"""The command that tests a connected Hapkit; it changes nothing on the board."""

import argparse
import contextlib
import sys
from typing import Any

from hapkit_studio import devices as device_list
from hapkit_studio.commands.base import Command, Result, option
from hapkit_studio.devices.board_runner import BoardRunner
from hapkit_studio.errors import ParameterError

_SIGNS = {"pass": "pass", "warn": "WARN", "fail": "FAIL", "skip": "left out"}
DANGER = 1
"""Exit code after a failed check that makes rendering unsafe."""


OPTIONS = (option("device", help="a device's key or a port; hands off, handle in the middle"),)


def board_named(key: str) -> Any:
    """Return the board with a device key or on a port; raise ParameterError for a device without a board."""
    device = device_list.named(key)
    if not device.calibration:
        raise ParameterError(f"{key!r} has no board. Choose a port; `hapkit-studio devices` lists them.")
    return device


def run(options: argparse.Namespace) -> Result:
    """Run every check on the board; after a dangerous fault the exit code is DANGER."""
    from hapkit_studio.analysis.calibrate.checks import CHECKS, Check, run_all
    from hapkit_studio.analysis.calibrate.result import CheckResult

    def show_progress(check: Check, result: CheckResult | None) -> None:
        if result is None and sys.stderr.isatty():
            print(f"{check.title} …", file=sys.stderr)

    with contextlib.closing(BoardRunner(board_named(options.device))) as runner:
        runner.open()
        report = run_all(runner, show_progress)
    titles = {check.key: check.title for check in CHECKS}
    lines = []
    for key, result in report.results.items():
        lines.append(f"{titles[key]:<18} {_SIGNS[result.level]:<9} {result.text}")
        if result.remedy:
            lines.append(f"{'':<28} {result.remedy}")
    found = {"device": options.device, **report.as_json()}
    return Result("\n".join([*lines, report.text]), found, DANGER if report.dangerous else 0)


COMMAND = Command("check", "test a connected Hapkit in half a minute without changing it", run, OPTIONS, 95)
