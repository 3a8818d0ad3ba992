"""The command that lists the devices."""

import argparse

from hapkit_studio import devices as device_list
from hapkit_studio.commands.base import Command, Result


def devices(options: argparse.Namespace) -> Result:
    """List the devices that can be chosen now."""
    entries = device_list.available()
    text = "\n".join(f"{e.key:<16} {e.title}" for e in entries)
    return Result(text, {"devices": [{"key": e.key, "title": e.title} for e in entries]})


COMMAND = Command("devices", "list the devices that can be chosen now", devices, order=30)
