"""The command that lists the devices and probes them."""

import argparse

from hapkit_studio import devices as device_list
from hapkit_studio import lab
from hapkit_studio.commands.base import Command, Result, option, progress_line

OPTIONS = (
    option(
        "--probe",
        action="store_true",
        help="open each device, which restarts a board, and show which one answers",
    ),
)


def devices(options: argparse.Namespace) -> Result:
    """List the available devices; with --probe, identify each of them."""
    lab.check()
    entries = device_list.available()
    found: list[dict] = [{"key": e.key, "title": e.title} for e in entries]
    report = progress_line("Devices")
    for done, entry in enumerate(entries if options.probe else ()):
        report(done, len(entries))
        found[done] |= entry.make().probe()
    report(len(entries), len(entries))
    lines = []
    for line in found:
        lines.append(f"{line['key']:<16} {line['title']}")
        lines += [f"{'':<16} {line['text']}"] if options.probe else []
    return Result("\n".join(lines), {"devices": found})


COMMAND = Command("devices", "list the available devices", devices, OPTIONS, 30)
