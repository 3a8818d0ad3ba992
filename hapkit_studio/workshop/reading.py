"""Reads a person's environment file: executes its text afresh; what is wrong is said with its line."""

import ast
import io
import linecache
import sys
import warnings
from pathlib import Path
from types import ModuleType

from hapkit_studio.environments.base import Environment
from hapkit_studio.workshop import declared, words
from hapkit_studio.workshop.own import OwnEnvironment, owned
from hapkit_studio.workshop.source import Source, read


def load(path: str | Path) -> OwnEnvironment:
    """Execute a file and return its ENVIRONMENT; raise LawError with the line of what is wrong.

    Executes whatever stands in the file, here and now: ask first where it comes from someone else.
    """
    return load_source(read(Path(path).expanduser().absolute()))


def load_source(source: Source) -> OwnEnvironment:
    """Return the ENVIRONMENT of a file as it was read; raise LawError."""
    return owned(execute(source), source)


def execute(source: Source) -> Environment:
    """Execute a text as a module of its own and return its checked ENVIRONMENT; raise LawError."""
    name, file = str(source.path), f"own_environment_{source.digest[:20]}"
    lines = io.StringIO(source.text, newline="\n").readlines()
    # A law's source is read from here; without a time it is never compared with the file on the disk.
    linecache.cache[name] = (len(source.text), None, lines, name)
    module = ModuleType(file)
    module.__file__ = name
    sys.modules[file] = module
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            tree = ast.parse(source.text, name)
            exec(compile(tree, name, "exec", dont_inherit=True), module.__dict__)
        return declared.environment(module, tree, len(lines))
    except SyntaxError as error:
        if error.filename not in (name, None):
            raise words.of_exception(error, name) from None
        raise words.of_syntax(error, len(lines)) from None
    except (Exception, SystemExit) as error:
        raise words.of_exception(error, name) from None
    finally:
        sys.modules.pop(file, None)
