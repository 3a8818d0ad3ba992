"""Compiled laws by address: they are loaded from the cache, and called without recompiling the caller."""

import ctypes
import hashlib
import importlib.util
import os
import pickle
import sys
import tempfile
import threading
import time
from pathlib import Path
from types import ModuleType

import numba
import platformdirs
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from hapkit_studio import program
from hapkit_studio.errors import LawError

_SPACE = 262_144  # bytes: free space that the folder needs for the machine code of a law
MAX_AGE_SECONDS = 60 * 86_400.0
# The words are: the fault code; the fault line, or without a fault the remaining fuel; the line of the first
# non-finite value; the fuel limit, 0 for the default.
FAULT_WORDS = 4
# fault codes
NOT_A_NUMBER, LAW_INDEX, LAW_FUEL, LAW_DIVISION = 1, 2, 3, 8
INTERPRETED = bool(numba.config.DISABLE_JIT)
_real, _array = ctypes.c_double, ctypes.c_void_p
# This type calls a law from Python; numba would need 0.1 s to compile a wrapper. Arrays are passed by
# address, which is ten times as fast as passing checked arrays.
Function = ctypes.CFUNCTYPE(_real, _array, _array, _real, _real, _real, _array)
_SHIPPED = program.SHIPPED / "laws"
_functions: dict[int, object] = {}
_loading = threading.Lock()


def load(source: str) -> tuple[int, object]:
    """Return (address, object that keeps the code in memory) of the source of a generated law.

    The file name is the hash of the source, so a modified law or helper never uses a stale cache. Raise
    LawError if the types do not fit.
    """
    with _loading:
        module = _module(source)
    if INTERPRETED:
        address = id(module.law)
        _functions[address] = module.law
        return address, module
    return module.law.address, module


def is_compiled(source: str) -> bool:
    """Return True if this Python's numba cache contains a law's machine code; this compiles nothing."""
    if INTERPRETED:
        return True
    folder = _configured_folder()
    abi = f"py{sys.version_info.major}{sys.version_info.minor}{getattr(sys, 'abiflags', '')}"
    name = f"{_name(source)}.law-*.{abi}.nbi"
    own_cache = bool(numba.config.CACHE_DIR)
    places = list(folder.parent.glob(f"{folder.name}_*")) if own_cache else [folder / "__pycache__"]
    if _shipped_file(_name(source)):
        places.append(_SHIPPED)
    return any(_loads(index) for place in places for index in place.glob(name))


def _loads(index: Path) -> bool:
    """Return True if this version of numba wrote the cache index and the index has a file of machine code."""
    with index.open("rb") as file:
        version = pickle.load(file)
    return version == numba.__version__ and any(index.parent.glob(f"{index.stem}.*.nbc"))


def _name(source: str) -> str:
    return "law_" + hashlib.sha256(source.encode()).hexdigest()[:20]


def _module(source: str) -> ModuleType:
    if INTERPRETED:
        source = source.replace("@cfunc(_SIGNATURE, ", "@njit(")
    name = _name(source)
    path = _shipped_file(name) or _written_file(name, source)
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # numba looks up the globals of a cached function by the name of the module
    try:
        spec.loader.exec_module(module)
    except numba.core.errors.NumbaError as error:
        reason = str(error).strip().splitlines()[-1]
        raise LawError(f"The law cannot be compiled: {reason}") from error
    return module


def _shipped_file(name: str) -> Path | None:
    """Return a law's file in a bundle; None if the file is missing or its machine code is not used."""
    path = _SHIPPED / f"{name}.py"
    return path if program.uses_shipped_code() and path.exists() else None


def _written_file(name: str, source: str) -> Path:
    path = _folder() / f"{name}.py"
    if path.exists():
        os.utime(path, (time.time(), path.stat().st_mtime))  # some versions of numba compare the access time
    else:
        _forget_unused(path.parent)
        part = path.with_suffix(f".{os.getpid()}.part")
        part.write_text(source, encoding="utf-8")
        part.replace(path)
    return path


def _forget_unused(folder: Path) -> None:
    """Remove generated files that have not been loaded for a long time, and their machine code."""
    now = time.time()
    for path in folder.glob("law_*.py"):
        if now - path.stat().st_atime > MAX_AGE_SECONDS:
            for old in folder.parent.rglob(f"{path.stem}.*"):
                old.unlink(missing_ok=True)


def _configured_folder() -> Path:
    if program.FILLING:
        return _SHIPPED
    base = numba.config.CACHE_DIR or platformdirs.user_cache_dir("hapkit-studio", appauthor=False)
    return Path(base) / "laws"


def _folder() -> Path:
    folder = _configured_folder()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder) as file:
            file.write(bytes(_SPACE))
            file.flush()
        return folder
    except OSError:
        return Path(tempfile.mkdtemp(prefix="hapkit-studio-laws-"))


@intrinsic
def _call(typingctx, address, p, s, x, v, dt, fault):
    real = types.float64

    def codegen(context, builder, signature, args):
        double = ir.DoubleType()
        word = ir.IntType(64)
        function = ir.FunctionType(
            double, [double.as_pointer(), double.as_pointer(), double, double, double, word.as_pointer()]
        )
        pointer = builder.inttoptr(args[0], function.as_pointer())
        data = [
            cgutils.create_struct_proxy(signature.args[i])(context, builder, args[i]).data for i in (1, 2, 6)
        ]
        return builder.call(pointer, [data[0], data[1], args[3], args[4], args[5], data[2]])

    return real(types.int64, p, s, real, real, real, fault), codegen


if INTERPRETED:

    def call(address, p, s, x, v, dt, fault):
        """Return the force in N of the law at an address, interpreted."""
        return _functions[address](p, s, x, v, dt, fault)  # type: ignore[operator]

else:

    @numba.njit(nogil=True, error_model="numpy", inline="always")
    def call(address, p, s, x, v, dt, fault):
        """Return the force in N of the law at an address; p, s, fault are C-contiguous arrays."""
        return _call(address, p, s, x, v, dt, fault)
