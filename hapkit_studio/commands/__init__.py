"""The command line's commands: one file each, found by the name ``COMMAND``."""

import importlib
import pkgutil

from hapkit_studio.commands.base import Command


def discover() -> dict[str, Command]:
    """Return every command by its name, in the order in which help lists them."""
    modules = [importlib.import_module(info.name) for info in pkgutil.iter_modules(__path__, __name__ + ".")]
    found = [module.COMMAND for module in modules if hasattr(module, "COMMAND")]
    return {command.name: command for command in sorted(found, key=lambda c: (c.order, c.name))}
