"""A person's own environments, for the gallery: nothing is executed that was not trusted and tried out."""

from dataclasses import dataclass
from pathlib import Path

from hapkit_studio.errors import LawError
from hapkit_studio.workshop import folder, reading, tried, trust, words
from hapkit_studio.workshop.own import OwnEnvironment
from hapkit_studio.workshop.verdict import Problem


@dataclass(frozen=True)
class Entry:
    """A file in the folder and what can be said of it.

    trusted: it may be executed, else a person sees its source first and is asked. tried: it passed its trial
    on this machine. Only where both hold was it executed; environment is what it declares, None where it was
    not executed or where a problem keeps it out.
    """

    file: Path
    trusted: bool = False
    tried: bool = False
    environment: OwnEnvironment | None = None
    problem: Problem | None = None

    @property
    def title(self) -> str:
        return self.environment.title if self.environment else self.file.stem.replace("_", " ").capitalize()


def own() -> list[Entry]:
    """Return every file in the folder; those that are ready in order of their titles, then the others."""
    keys: dict[str, Path] = {}
    entries = [_without_twin(entry_of(file), keys) for file in folder.own_files()]
    return sorted(entries, key=lambda e: (e.environment is None, e.title.casefold()))


def entry_of(file: Path) -> Entry:
    """Return what can be said of a file; it is executed only where it is trusted and was tried out."""
    trusted = passed = False
    try:
        text = reading.text_of(file)
        trusted, passed = trust.is_trusted(text), tried.has_passed(text, file)
        made = reading.load_text(text, file) if trusted and passed else None
        return Entry(file, trusted, passed, made)
    except LawError as error:
        return Entry(file, trusted, passed, None, Problem(error.line, words.plain(error)))


def _without_twin(entry: Entry, keys: dict[str, Path]) -> Entry:
    """Keep out a file whose environment has the key of one before."""
    if entry.environment is None:
        return entry
    first = keys.setdefault(entry.environment.key, entry.file)
    if first == entry.file:
        return entry
    words_ = f'the key "{entry.environment.key}" is also that of {first.name}: change one of them'
    return Entry(entry.file, entry.trusted, entry.tried, None, Problem(0, words_))
