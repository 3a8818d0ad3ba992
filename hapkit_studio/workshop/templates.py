"""Files to begin with: whole environments that a first-year student can read and change."""

import ast
import json
from dataclasses import dataclass
from pathlib import Path

from hapkit_studio import resources


@dataclass(frozen=True)
class Template:
    """A file to begin with: its key, its name for a person, its text."""

    key: str
    title: str
    text: str


def templates() -> tuple[Template, ...]:
    """Return every template, the shortest first."""
    files = resources.path("templates").glob("*.py")
    return tuple(sorted(map(_read, files), key=lambda t: len(t.text)))


def fill(template: Template, title: str, key: str) -> str:
    """Return a template's text with a title and a key of its own."""
    text = template.text
    for name, value in (("key", key), ("title", title)):
        old = _given(text, name)
        text = text.replace(f"{name}={old}", f"{name}={json.dumps(value, ensure_ascii=False)}", 1)
    return text


def _read(file: Path) -> Template:
    return Template(file.stem, file.stem.replace("_", " "), file.read_text(encoding="utf-8"))


def _given(text: str, name: str) -> str:
    """Return how a value stands in the text of Environment(…)."""
    made = [n for n in ast.walk(ast.parse(text)) if isinstance(n, ast.keyword) and n.arg == name]
    return ast.get_source_segment(text, made[0].value) or ""
