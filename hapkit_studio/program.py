"""Start the studio's own modules, from Python or from a bundle, and find the machine code of a bundle.

A bundle (``make bundle``) is a folder with Python, the packages and the studio. It contains machine code,
which is compiled when the bundle is built. The code requires only a baseline processor, because other
computers will run it.
"""

import functools
import os
import platform
import sys
from pathlib import Path

from hapkit_studio.resources import PACKAGE

BUNDLED = bool(getattr(sys, "frozen", False))
INSTALLED = (PACKAGE / "assets").is_dir()
"""True for a wheel or a bundle, whose machine code is in the user's cache; False for a checkout."""
SHIPPED = PACKAGE.parent / "machine-code"
"""Folder of a bundle's machine code; its subfolders are those of the sources."""
AVRDUDE = PACKAGE.parent / "avrdude" / "bin"
"""Folder of the avrdude in a bundle."""
STAMP = SHIPPED / "stamp"
"""File with a hash of the sources that were compiled."""
FILLING = BUNDLED and bool(os.environ.get("HAPKIT_STUDIO_FILL_BUNDLE"))
"""True while a bundle is built: machine code is then written into its folder, not into the user's cache."""
OWN_CACHE = "HAPKIT_STUDIO_CACHE_DIR"
"""Environment variable with a copy of NUMBA_CACHE_DIR if the studio itself has set the latter."""
_V3 = ("x86-64-v3", "avx avx2 bmi bmi2 cx16 f16c fma lzcnt movbe popcnt sahf sse4.2 ssse3 xsave")
_GENERIC = ("generic", "")
BASELINES = {"x86_64": _V3, "amd64": _V3}
"""LLVM's name of the baseline processor, and its features, by platform.machine() in lower case."""


def module_command(module: str, *args: str) -> list[str]:
    """Return the command line that runs a module of the studio in a new process."""
    # With -P, Python does not search the current folder, in which a file may have a standard module's name.
    return [sys.executable, "-P", "-m", module, *args]


@functools.cache
def baseline() -> str | None:
    """Return the baseline processor of a bundle; None if this computer lacks one of its features."""
    from llvmlite import binding

    name, required = BASELINES.get(platform.machine().lower(), _GENERIC)
    present = binding.get_host_cpu_features()
    return name if all(present.get(feature) for feature in required.split()) else None


def configured_cache() -> str:
    """Return the folder for machine code that the user has set in NUMBA_CACHE_DIR; "" if it is not set."""
    folder = os.environ.get("NUMBA_CACHE_DIR", "")
    return "" if folder == os.environ.get(OWN_CACHE) else folder


@functools.cache
def uses_shipped_code() -> bool:
    """Return True for a bundle whose machine code runs on this computer, unless a cache folder is set."""
    return BUNDLED and not configured_cache() and STAMP.is_file() and baseline() is not None


def machine_code_folder(source: str | Path) -> Path | None:
    """Return the folder of the machine code of a bundle's source file; None for any other file."""
    folder = Path(source).parent
    if folder.is_relative_to(SHIPPED):
        return folder
    return SHIPPED / folder.relative_to(PACKAGE.parent) if folder.is_relative_to(PACKAGE.parent) else None
