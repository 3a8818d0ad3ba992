"""Entry point of the bundle: the studio, or a module as by Python's ``-m`` and ``-P -m``."""

import ctypes
import multiprocessing
import os
import runpy
import sys
from contextlib import suppress
from pathlib import Path


def load_missing_libraries() -> None:
    """Load the libraries that every desktop has, from the bundle if this computer does not have them."""
    for library in sorted(Path(__file__).with_name("desktop-libraries").glob("*")):
        try:
            ctypes.CDLL(library.name.partition("-")[2])
        except OSError:
            with suppress(OSError):
                ctypes.CDLL(str(library), ctypes.RTLD_GLOBAL)


def restore_environment() -> None:
    """Take back what PyInstaller sets for this program only, before other programs are started.

    The library path is meant for the bundle's own libraries; a bundle that starts itself sets it again, if it
    is told that it is a new one. matplotlib's folder is a temporary one, without the fonts found before.
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
