"""The line to run where a person may not open a port, made for this port and this person's groups."""

import getpass
import os
import stat
import sys
from pathlib import Path

from hapkit_studio.devices.discovery import Port

RULES = "/etc/udev/rules.d/60-hapkit.rules"


def remedy(path: str, port: Port | None) -> tuple[str, str]:
    """Return what to do in words, and the line to run, which may be none."""
    if sys.platform != "linux":
        return "Ask for the right to use it.", ""
    group = _group(path)
    if not group:
        return "Then plug the board in again.", _rule(port)
    if _joined(group):
        return f"You are in the group {group} since you logged in: log out and in again.", ""
    return "Then log out and in again.", f"sudo usermod -a -G {group} $USER"


def _rule(port: Port | None) -> str:
    """Return the line that lets whoever sits at the computer open this kind of port."""
    vendor = port.identity.vendor if port else None
    which = f', ATTRS{{idVendor}}=="{vendor:04x}"' if vendor else ', KERNEL=="ttyUSB*|ttyACM*"'
    rule = f'SUBSYSTEM=="tty"{which}, MODE="0660", TAG+="uaccess"'
    return f"echo '{rule}' | sudo tee {RULES} && sudo udevadm control --reload && sudo udevadm trigger"


def _group(path: str) -> str:
    """Return the group whose members may use a port; nothing where no group but root's may."""
    try:
        mode, group = Path(path).stat().st_mode, Path(path).group()
    except (KeyError, OSError, NotImplementedError):
        return ""
    shared = mode & stat.S_IRGRP and mode & stat.S_IWGRP
    return group if shared and group not in ("root", "tty") else ""


def _joined(group: str) -> bool:
    """Tell whether the system lists this person in a group that this login does not have yet."""
    if sys.platform == "win32":
        return False
    import grp

    try:
        entry = grp.getgrnam(group)
        return getpass.getuser() in entry.gr_mem and entry.gr_gid not in os.getgroups()
    except (KeyError, OSError):
        return False
