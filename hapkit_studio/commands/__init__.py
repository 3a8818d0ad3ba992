"""The commands of the command line: each module with a ``COMMAND`` defines one."""

from hapkit_studio.commands.base import Command
from hapkit_studio.discovery import declared


def discover() -> dict[str, Command]:
    """Return every command by its name, in the order of the help."""
    found = declared(__name__, "COMMAND", Command)
    return {command.name: command for command in sorted(found, key=lambda c: (c.order, c.name))}
