"""The folder of a user's environments, which are Python files, and templates for new files."""

import ast
import json
import os
import re
import unicodedata
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import platformdirs

from hapkit_studio import resources
from hapkit_studio.workshop.own import taken_keys
from hapkit_studio.workshop.reading import calls

VARIABLE = "HAPKIT_STUDIO_FOLDER"
# reserved device names on Windows, with any suffix
_DEVICES = re.compile(r"(con|prn|aux|nul|com\d|lpt\d)$")
_LONGEST = 40


def own_folder() -> Path:
    """Return the folder of the user's environments, which is created if missing.

    Raise OSError if it cannot be created.
    """
    folder = own_folder_path()
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def existing() -> Path:
    """Return the folder of the user's environments, or the nearest parent that exists."""
    place = own_folder_path()
    return next((f for f in (place, *place.parents) if os.path.isdir(f)), place)


def own_files() -> list[Path]:
    """Return the Python files in the folder, sorted by name; [] if the folder is missing."""
    try:
        return sorted(f for f in own_folder_path().glob("*.py") if f.is_file())
    except OSError:
        return []


def new_path(title: str) -> Path:
    """Return an unused path in the folder, derived from a title and different from any built-in key."""
    folder, stem = own_folder(), plain_name(title)
    taken = {f.stem.lower() for f in folder.glob("*")} | taken_keys()
    name, number = stem, 2
    while name in taken:
        name, number = f"{stem}_{number}", number + 1
    return folder / f"{name}.py"


def free_title(title: str, titles: Iterable[str] = ()) -> str:
    """Return a title; a number is appended if another environment or file already uses the title."""
    taken = {plain_name(t) for t in titles} | {f.stem.lower() for f in own_files()} | taken_keys()
    found, number = title, 2
    while plain_name(found) in taken:
        found, number = f"{title} {number}", number + 1
    return found


def save(path: Path, text: str) -> None:
    """Write a file atomically: if this fails, the old file is unchanged, and OSError is raised."""
    part = path.with_name(f"{path.name}.{os.getpid()}.part")
    try:
        with open(part, "w", encoding="utf-8", newline="\n") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)


def plain_name(title: str) -> str:
    """Return a title as a name of a-z, 0-9 and _, for files and keys; "Zwei Wände!" becomes "zwei_wande"."""
    letters = unicodedata.normalize("NFKD", title).encode("ascii", "ignore").decode().lower()
    name = re.sub(r"[^a-z0-9]+", "_", letters).strip("_")[:_LONGEST].rstrip("_")
    if not name or name[0].isdigit() or _DEVICES.match(name):
        name = f"my_{name}" if name else "environment"
    return name


def own_folder_path() -> Path:
    base = os.environ.get(VARIABLE)
    root = Path(base) if base else Path(platformdirs.user_documents_dir()) / "Hapkit Studio"
    return root / "environments"


@dataclass(frozen=True)
class Template:
    """A template for a new file: its key, title and text."""

    key: str
    title: str
    text: str


def templates() -> tuple[Template, ...]:
    """Return every template, the shortest first."""
    files = resources.path("templates").glob("*.py")
    found = [Template(f.stem, f.stem.replace("_", " "), f.read_text(encoding="utf-8")) for f in files]
    return tuple(sorted(found, key=lambda t: len(t.text)))


def fill_template(template: Template, title: str, key: str) -> str:
    """Return a template's text with a different title and key."""
    new = {"key": key, "title": title}
    # the text is encoded, because the syntax tree counts columns in bytes
    lines = template.text.encode().splitlines(keepends=True)
    own = [k for call in calls(ast.parse(template.text), "Environment") for k in call.keywords]
    for value, name in reversed([(k.value, k.arg) for k in own if k.arg in new]):
        line, start, end = value.lineno - 1, value.col_offset, value.end_col_offset
        encoded = json.dumps(new[name], ensure_ascii=False).encode()
        lines[line] = lines[line][:start] + encoded + lines[line][end:]
    return b"".join(lines).decode()
