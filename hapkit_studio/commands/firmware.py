"""The command that builds the firmware anew, with a person's own laws on the board, and may flash it."""

import argparse
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

from hapkit_studio.commands.base import Command, Result
from hapkit_studio.commands.flash import avrdude_option, flash_and_greet, port_to_flash
from hapkit_studio.devices import avrdude, flash, hex_image
from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import DeviceError, LawError, ParameterError
from hapkit_studio.laws import Law
from hapkit_studio.laws import firmware as headers
from hapkit_studio.workshop import asking
from hapkit_studio.workshop.firmware import default_folder
from hapkit_studio.workshop.own import built_in

_TOOLS = ("avr-g++", "make")
_CHOSEN = "#define LAWS_CHOSEN\n"
"""Tells the firmware to take these laws, whatever else it would have."""
_GET = "sudo apt install gcc-avr avr-libc arduino-core-avr make"


def options(command: argparse.ArgumentParser) -> None:
    """Declare what ``firmware`` takes."""
    command.add_argument(
        "--with",
        dest="own",
        nargs="+",
        default=[],
        metavar="FILE",
        help="Python files of your own environments",
    )
    command.add_argument(
        "--laws",
        nargs="+",
        metavar="KEY",
        help="which of the studio's own stay, to make room; all by default",
    )
    command.add_argument("--trust", action="store_true", help="execute files that you have read")
    command.add_argument("-o", "--output", metavar="PATH", default="hapkit.hex", help="where the image goes")
    command.add_argument("--flash", metavar="PORT", help="write it to the board on this port")
    avrdude_option(command)


def run(options: argparse.Namespace) -> Result:
    """Build, write the image, flash it if a port is given; raise DeviceError, LawError."""
    sources = _sources()
    if options.flash is not None:
        avrdude.find(options.avrdude)  # said before a minute of compiling, as is a missing port
        flash.try_port(port_to_flash(options.flash))
    kept = _kept(options.laws)
    own = [asking.environment(file, options.trust) for file in options.own]
    laws = {environment.key: environment.force for environment in [*kept, *own]}
    with tempfile.TemporaryDirectory(prefix="hapkit-firmware-") as folder:
        said = _build(sources, Path(folder), laws)
        output = Path(options.output)
        shutil.copyfile(Path(folder) / "build" / "hapkit.hex", output)
    lines = [f"wrote {output} with {', '.join(laws)}", *said]
    found = {"written": str(output), "laws": list(laws), "bytes": len(hex_image.read(output).data)}
    if options.flash is None:
        return Result("\n".join(lines), found)
    flashed = flash_and_greet(options.flash, str(output), options.avrdude)
    return Result("\n".join([*lines, flashed.text]), {**found, "flashed": flashed.as_json})


def _sources() -> Path:
    """Return the firmware's folder; raise DeviceError where it cannot be built."""
    folder = default_folder().parent
    if not (folder / "Makefile").is_file():
        raise DeviceError(
            "The firmware's sources are not here: they are in the studio's repository, not in its package. "
            "Or export the environment as a sketch."
        )
    missing = [tool for tool in _TOOLS if shutil.which(tool) is None]
    if missing:
        get = f"Run `{_GET}`, then try again" if sys.platform == "linux" else "Install avr-gcc and make"
        raise DeviceError(f"The firmware needs {' and '.join(missing)}. {get}. Or export a sketch.")
    return folder


def _kept(keys: Sequence[str] | None) -> list[Environment]:
    """Return the studio's own environments that stay on the board; raise ParameterError."""
    every = built_in()
    unknown = [key for key in keys or () if key not in every]
    if unknown:
        raise ParameterError(f"There is no law {', '.join(unknown)}; there are: {', '.join(every)}.")
    return [environment for key, environment in every.items() if keys is None or key in keys]


def _build(sources: Path, folder: Path, laws: Mapping[str, Law]) -> list[str]:
    """Compile a copy of the sources with the laws in it; return the sizes. Raise LawError, DeviceError."""
    shutil.copytree(sources, folder / "firmware", ignore=shutil.ignore_patterns("build"))
    files = headers.headers(laws)
    files["laws/table.h"] += _CHOSEN
    headers.write(files, folder / "firmware" / "hapkit")
    words = ["make", "-C", str(folder / "firmware"), f"BUILD={folder / 'build'}", "hex"]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    sizes = [line for line in done.stdout.split("\n") if " bytes (" in line]
    if done.returncode != 0:
        raise _refused(done.stderr, sizes)
    return sizes


def _refused(errors: str, sizes: list[str]) -> Exception:
    """Return why it was not built: no room, or what the compiler said first."""
    full = "will not fit" in errors or "overflowed" in errors or any(_over(line) for line in sizes)
    if full:
        room = "; ".join(sizes) or "the chip's memory is full"
        return LawError(f"These laws do not fit the board ({room}). Keep fewer (--laws), or export a sketch.")
    first = next((line for line in errors.split("\n") if "error" in line.lower()), "make failed")
    return DeviceError(f"The firmware does not compile: {first.strip()}")


def _over(line: str) -> bool:
    words = line.split()
    return words[0] in ("flash", "RAM") and int(words[1]) > int(words[3])


COMMAND = Command("firmware", "build the firmware anew, with your own laws", run, options, order=37)
