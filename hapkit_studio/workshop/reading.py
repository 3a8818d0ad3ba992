"""Reads a person's environment file: executes its text afresh; what is wrong is said with its line."""

import hashlib
import io
import linecache
import sys
import warnings
from pathlib import Path
from types import ModuleType

from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import LawError
from hapkit_studio.workshop import declared, words
from hapkit_studio.workshop.harmless import is_harmless
from hapkit_studio.workshop.own import OwnEnvironment, owned

__all__ = ["execute", "is_harmless", "load", "load_text", "text_of"]

MOST_BYTES = 1_000_000


def load(path: str | Path) -> OwnEnvironment:
    """Execute a file and return its ENVIRONMENT; raise LawError with the line of what is wrong.

    Executes whatever stands in the file, here and now: ask first where it comes from someone else.
    """
    path = Path(path).expanduser().absolute()
    return load_text(text_of(path), path)


def load_text(text: str, path: Path) -> OwnEnvironment:
    """Return the ENVIRONMENT of a text, as if it stood in the file now; raise LawError."""
    return owned(execute(text, path), path, text)


def text_of(path: Path) -> str:
    """Return a file's text, its lines ending in newlines; raise LawError."""
    try:
        with open(path, "rb") as file:
            data = file.read(MOST_BYTES + 1)
    except FileNotFoundError:
        raise LawError(f"there is no file {path.name}") from None
    except OSError as error:
        raise LawError(f"{path.name} cannot be read: {error.strerror}") from None
    if len(data) > MOST_BYTES:
        raise LawError("the file is larger than 1 MB")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise LawError("this line is not text in UTF-8: save the file as UTF-8", line) from None
    if "\0" in text:  # Pythons differ in what they call it
        raise LawError("the file is not text", 1)
    return text.replace("\r\n", "\n").replace("\r", "\n")


def execute(text: str, path: Path) -> Environment:
    """Execute a text as a module of its own and return its checked ENVIRONMENT; raise LawError."""
    name, file = str(path), _module_name(text)
    lines = io.StringIO(text, newline="\n").readlines()
    # A law's source is read from here; without a time it is never compared with the file on the disk.
    linecache.cache[name] = (len(text), None, lines, name)
    module = ModuleType(file)
    module.__file__ = name
    sys.modules[file] = module
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            exec(compile(text, name, "exec", dont_inherit=True), module.__dict__)
        return declared.environment(module, text)
    except SyntaxError as error:
        if error.filename not in (name, None):
            raise words.of_exception(error, name) from None
        raise words.of_syntax(error, len(lines)) from None
    except ValueError as error:
        # what holds a null byte
        raise words.of_exception(error, name) from None
    except (Exception, SystemExit) as error:
        raise words.of_exception(error, name) from None
    finally:
        sys.modules.pop(file, None)


def _module_name(text: str) -> str:
    return "own_environment_" + hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()[:20]
