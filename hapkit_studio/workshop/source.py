"""The content of a user's file, identified by the hash of its bytes; the list of trusted files."""

import hashlib
from dataclasses import dataclass
from pathlib import Path

import platformdirs

from hapkit_studio import files
from hapkit_studio.errors import FileError, LawError

MOST_BYTES = 1_000_000


@dataclass(frozen=True)
class Source:
    """A file's path, its text with normalised newlines, and the hash of its bytes."""

    path: Path
    text: str
    digest: str


def read(path: Path) -> Source:
    """Read a file; raise LawError with the line of a byte that is not UTF-8."""
    try:
        data = files.read_bytes(path, MOST_BYTES)
    except FileError as error:
        raise LawError(str(error)) from None
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise LawError("this line is not text in UTF-8: save the file as UTF-8", line) from None
    if "\0" in text:  # raised here, because the message differs between Python versions
        raise LawError("the file is not text", 1)
    return Source(path, text.replace("\r\n", "\n").replace("\r", "\n"), hashlib.sha256(data).hexdigest())


def typed(path: Path, text: str) -> Source:
    """Return the Source that ``read`` would return if a text were saved."""
    return Source(path, text, hashlib.sha256(text.encode()).hexdigest())


def is_trusted(source: Source) -> bool:
    """Return True if the user trusts exactly this content."""
    try:
        return source.digest in files.read_text(_trusted_list(), MOST_BYTES).split()
    except FileError:
        return False


def trust_source(source: Source) -> None:
    """Add this content to the trusted list; raise OSError if the list cannot be written."""
    if is_trusted(source):
        return
    file = _trusted_list()
    file.parent.mkdir(parents=True, exist_ok=True)
    with open(file, "a", encoding="ascii") as known:
        known.write(source.digest + "\n")


def _trusted_list() -> Path:
    return Path(platformdirs.user_data_dir("hapkit-studio", appauthor=False)) / "trusted"
