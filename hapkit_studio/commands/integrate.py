"""The command that adds menu entry, icon and file type to the desktop, and prints the commands for root.

The formats are Desktop Entry, Icon Theme and Shared MIME-info (freedesktop.org), udev(7), limits.conf(5).
"""

import argparse
import getpass
import os
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from xml.sax.saxutils import escape

from hapkit_studio import resources
from hapkit_studio.commands.base import YES, Command, Result, option
from hapkit_studio.devices.port_errors import RULES
from hapkit_studio.devices.serial_ports import CHIPS, Role
from hapkit_studio.errors import ParameterError
from hapkit_studio.files import replacing
from hapkit_studio.haptics import priority
from hapkit_studio.program import BUNDLED
from hapkit_studio.sessions.file import MARK, SUFFIX

MIME = "application/x-hapkit-session"
UDEV = Path(RULES)
LIMITS = Path("/etc/security/limits.d/hapkit-studio.conf")
_OTHERS = {
    "win32": "On Windows, right-click a .hapkit file, choose Open with…, and select hapkit-studio.exe.",
    "darwin": "On macOS, Ctrl-click a .hapkit file, choose Open With, Other…, and select hapkit-studio.",
}


def files(program: Sequence[str]) -> dict[Path, str]:
    """Return the text of each file of the desktop integration by its path in the user's folders.

    ``program`` contains the words of the command that starts the studio.
    """
    data = Path(os.environ.get("XDG_DATA_HOME", ""))
    if not data.is_absolute():  # the specification says that a relative path is ignored
        data = Path(os.path.expanduser("~/.local/share"))
    return {
        data / "applications" / "hapkit-studio.desktop": desktop_entry(program),
        data / "mime" / "packages" / "hapkit-studio.xml": mime_type(),
        data / "icons/hicolor/scalable/apps/hapkit-studio.svg": resources.path("icon.svg").read_text("utf-8"),
    }


def installed() -> list[Path]:
    """Return the paths of those files that exist, including broken links."""
    return [path for path in files([]) if os.path.lexists(path)]


def desktop_entry(program: Sequence[str]) -> str:
    """Return the text of the menu entry, which also opens sessions that the user double-clicks."""
    return f"""\
[Desktop Entry]
Type=Application
Version=1.0
Name=Hapkit Studio
Comment=Feel, tune and measure virtual environments on a Hapkit
Exec={" ".join(map(_quoted, program))} %f
Icon=hapkit-studio
Terminal=false
Categories=Education;Science;
MimeType={MIME};
StartupWMClass=hapkit-studio
"""


def _quoted(word: str) -> str:
    """Return an argument for the key Exec of a desktop entry: quoted, then escaped like any string there."""
    for special in ("\\", '"', "`", "$"):
        word = word.replace(special, f"\\{special}")
    return '"' + word.replace("\\", "\\\\").replace("%", "%%") + '"'


def mime_type() -> str:
    """Return the declaration of the file type, which names the suffix and SQLite's application number."""
    return f"""\
<?xml version="1.0" encoding="UTF-8"?>
<mime-info xmlns="http://www.freedesktop.org/standards/shared-mime-info">
  <mime-type type="{MIME}">
    <comment>Hapkit session</comment>
    <icon name="hapkit-studio"/>
    <magic priority="80">
      <match type="string" value="SQLite format 3" offset="0">
        <match type="big32" value="0x{MARK:08x}" offset="68"/>
      </match>
    </magic>
    <glob pattern="*{escape(SUFFIX)}"/>
  </mime-type>
</mime-info>
"""


def udev_rule() -> str:
    """Return the rule that lets the person at the computer open the ports of the kits' vendors."""
    numbers = [pair for chip in CHIPS if chip.role is Role.KIT for pair in chip.numbers]
    vendors = "|".join(dict.fromkeys(f"{vendor:04x}" for vendor, _ in numbers))
    return f'SUBSYSTEM=="tty", ATTRS{{idVendor}}=="{vendors}", MODE="0660", TAG+="uaccess"\n'


def limits(user: str) -> str:
    """Return the limits that allow a user's loop real-time priority and locked memory."""
    return f"{user} - rtprio 80\n{user} - memlock unlimited\n"


def root_commands() -> list[str]:
    """Return the commands that need root, one per line; commands that are not needed are left out."""
    found = []
    if not UDEV.exists():
        found += [
            _writing(udev_rule(), UDEV),
            "sudo udevadm control --reload",
            "sudo udevadm trigger -s tty",
        ]
    if priority.probe().how and not LIMITS.exists():
        found.append(_writing(limits(getpass.getuser()), LIMITS))
    return found


def _writing(text: str, path: Path) -> str:
    body = text.replace("\n", "\\n").replace("'", "'\\''")
    return f"printf '{body}' | sudo tee {path}"


def run(options: argparse.Namespace) -> Result:
    """Install or remove the files after asking the user; print the commands for root."""
    if sys.platform in _OTHERS:
        raise ParameterError(_OTHERS[sys.platform])
    wanted = files(_program())
    return _remove(options, list(wanted)) if options.remove else _install(options, wanted)


def _install(options: argparse.Namespace, wanted: dict[Path, str]) -> Result:
    _confirm("Write these files", list(wanted), options.yes)
    for path, text in wanted.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        with replacing(path) as part:
            part.write_text(text, encoding="utf-8")
    _update(list(wanted))
    commands = root_commands()
    lines = [f"wrote {path}" for path in wanted]
    if commands:
        lines += [
            "",
            "Needs an administrator (ports without group dialout; real-time priority at next login):",
        ]
        lines += [f"    {command}" for command in commands]
    return Result("\n".join(lines), {"written": [str(path) for path in wanted], "root_commands": commands})


def _remove(options: argparse.Namespace, wanted: list[Path]) -> Result:
    present = [path for path in wanted if os.path.lexists(path)]
    if present:
        _confirm("Remove these files", present, options.yes)
    for path in present:
        path.unlink()
    _update(present)
    commands = [f"sudo rm {path}" for path in (UDEV, LIMITS) if path.exists()]
    lines = [f"removed {path}" for path in present] or ["Nothing of this user to remove."]
    lines += ["", "Needs an administrator:", *(f"    {command}" for command in commands)] if commands else []
    return Result("\n".join(lines), {"removed": [str(path) for path in present], "root_commands": commands})


def _confirm(question: str, paths: Sequence[Path], agreed: bool) -> None:
    """Raise ParameterError unless the user agrees."""
    if agreed:
        return
    print(f"{question}?", *(f"  {path}" for path in paths), sep="\n", file=sys.stderr)
    if not (sys.stdin and sys.stdin.isatty()):
        raise ParameterError("Nothing was changed, because there is no terminal to confirm it: pass --yes.")
    print("[y/N] ", end="", file=sys.stderr, flush=True)
    if sys.stdin.readline().strip().lower() not in YES:
        raise ParameterError("Nothing was changed.")


def _update(paths: Sequence[Path]) -> None:
    """Let the desktop read its files again; without the desktop's programs this happens at the next login."""
    folders = {path.parents[1] if path.suffix == ".xml" else path.parent: path.suffix for path in paths}
    programs = {".xml": "update-mime-database", ".desktop": "update-desktop-database"}
    for folder, suffix in folders.items():
        found = shutil.which(programs.get(suffix, ""))
        if found:
            subprocess.run([found, str(folder)], capture_output=True, check=False, timeout=60)


def _program() -> list[str]:
    """Return the words of the command that starts the studio."""
    if BUNDLED:
        return [sys.executable]
    beside = Path(sys.executable).with_name("hapkit-studio")
    return [str(beside)] if beside.exists() else [sys.executable, "-m", "hapkit_studio"]


COMMAND = Command(
    "integrate",
    "add the studio to the desktop: menu, icon, .hapkit files (Linux)",
    run,
    (
        option("--remove", action="store_true", help="undo it"),
        option("--yes", action="store_true", help="do not ask"),
    ),
    96,
)
