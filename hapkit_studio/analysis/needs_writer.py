"""Writes a scene's computed needs into its file: one line of its call of Environment, nothing else."""

import ast
import sys
from collections.abc import Iterable
from pathlib import Path

from hapkit_studio import environments
from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import ParameterError
from hapkit_studio.workshop.own import OwnEnvironment

_NAME = "ENVIRONMENT"
_INDENT = " " * 4


def file_of(environment: Environment) -> Path:
    """Return the file that declares an environment; raise ParameterError where there is none."""
    if isinstance(environment, OwnEnvironment):
        return environment.source.path
    inside = [name for name in sys.modules if name.startswith(environments.__name__ + ".")]
    for name in (*inside, environment.force.function.__module__):
        module = sys.modules.get(name)
        declared = getattr(module, _NAME, None)
        if getattr(declared, "force", None) is environment.force and getattr(module, "__file__", None):
            return Path(str(module.__file__))  # type: ignore[union-attr]
    raise ParameterError(f"{environment.title} has no file of its own to write into.")


def edited(source: str, needs: Iterable[str]) -> str:
    """Return a file's text with its ``needs=(…)``, replaced or new; raise ParameterError."""
    call, text = _call(source), f"needs={_tuple(needs)}"
    lines = source.split("\n")
    for keyword in call.keywords:
        if keyword.arg == "needs":
            first, last = keyword.lineno - 1, (keyword.end_lineno or 0) - 1
            before, after = (
                _head(lines[first], keyword.col_offset),
                _tail(lines[last], keyword.end_col_offset),
            )
            return "\n".join([*lines[:first], before + text + after, *lines[last + 1 :]])
    place = next((k.lineno for k in call.keywords if k.arg == "order"), call.end_lineno or 0) - 1
    if place == call.lineno - 1:
        end = (call.end_col_offset or 0) - 1
        lines[place] = f"{_head(lines[place], end).rstrip(', ')}, {text}{_tail(lines[place], end)}"
        return "\n".join(lines)
    ending = "\r" if lines[place].endswith("\r") else ""
    return "\n".join([*lines[:place], f"{_INDENT}{text},{ending}", *lines[place:]])


def write(environment: Environment, needs: Iterable[str]) -> bool:
    """Write needs into an environment's file; return whether it changed. Raise ParameterError, OSError."""
    path = file_of(environment)
    before = path.read_bytes()
    after = edited(before.decode(), needs).encode()
    if after != before:
        path.write_bytes(after)
    return after != before


def _head(line: str, end: int) -> str:
    """Return a line up to a column, which Python's parser counts in bytes."""
    return line.encode()[:end].decode()


def _tail(line: str, start: int | None) -> str:
    return line.encode()[start:].decode()


def _call(source: str) -> ast.Call:
    for node in ast.parse(source).body:
        if (
            isinstance(node, ast.Assign)
            and isinstance(node.value, ast.Call)
            and any(isinstance(t, ast.Name) and t.id == _NAME for t in node.targets)
        ):
            return node.value
    raise ParameterError(f"The file does not say {_NAME} = Environment(…).")


def _tuple(needs: Iterable[str]) -> str:
    words = [f'"{key}"' for key in needs]
    return f"({words[0]},)" if len(words) == 1 else f"({', '.join(words)})"
