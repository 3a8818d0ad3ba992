"""Entry point of the bundle. It starts the studio. As in Python, ``-m`` or ``-P -m`` runs a module."""

import ctypes
import multiprocessing
import os
import runpy
import sys
from contextlib import suppress
from pathlib import Path


def load_missing_libraries() -> None:
    """Load this computer's desktop libraries, and the bundle's own copy of each library that it lacks."""
    for library in sorted(Path(__file__).with_name("desktop-libraries").glob("*")):
        try:
            ctypes.CDLL(library.name.partition("-")[2])
        except OSError:
            with suppress(OSError):
                ctypes.CDLL(str(library), ctypes.RTLD_GLOBAL)


def restore_environment() -> None:
    """Restore the environment variables that PyInstaller has changed, because other programs inherit them.

    PyInstaller's library path leads to the libraries of this bundle, which other programs must not use.
    PYINSTALLER_RESET_ENVIRONMENT makes any other bundle that this program starts set its own library path.
    PyInstaller's matplotlib folder is temporary and has no font cache.
    """
    for name in ("LD_LIBRARY_PATH", "DYLD_LIBRARY_PATH"):
        original = os.environ.pop(f"{name}_ORIG", None)
        if original is not None:
            os.environ[name] = original
        else:
            os.environ.pop(name, None)
    os.environ["PYINSTALLER_RESET_ENVIRONMENT"] = "1"
    os.environ.pop("MPLCONFIGDIR", None)


if __name__ == "__main__":
    load_missing_libraries()
    restore_environment()
    multiprocessing.freeze_support()
    safe, words = sys.argv[1:2] == ["-P"], sys.argv[1:]
    if words[safe : safe + 1] == ["-m"]:
        if not safe:
            sys.path.insert(0, os.getcwd())
        sys.argv = words[safe + 1 :]
        runpy.run_module(sys.argv[0], run_name="__main__", alter_sys=True)
    else:
        from hapkit_studio.cli import main

        sys.exit(main())
