"""What the gallery says of a person's file before anything in it was executed."""

import ast
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

_WORDS = ("title", "summary", "scene")
_LONGEST = 60


@dataclass(frozen=True)
class OwnFile:
    """One file of the folder; state is ready, checking, broken, or foreign: nobody agreed to it yet."""

    path: Path
    title: str
    summary: str = ""
    scene: str = ""
    state: str = "ready"


def described(path: Path, text: str, state: str) -> OwnFile:
    """Return a file by the words it declares; by its name if it declares none that can be read."""
    words = declared_words(text)
    title = words.get("title") or path.stem.replace("_", " ").capitalize()
    return OwnFile(path, title[:_LONGEST], words.get("summary", "")[:_LONGEST], words.get("scene", ""), state)


@lru_cache(maxsize=64)
def declared_words(text: str) -> Mapping[str, str]:
    """Return title, summary and scene as they stand in ``Environment(…)``, read but not executed."""
    try:
        tree = ast.parse(text)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return {}
    found: dict[str, str] = {}
    for call in ast.walk(tree):
        if isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and call.func.id == "Environment":
            for given in call.keywords:
                value = given.value
                if given.arg in _WORDS and isinstance(value, ast.Constant) and isinstance(value.value, str):
                    found[given.arg] = " ".join(value.value.split())
    return found
