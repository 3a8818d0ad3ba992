"""What went wrong in a file, each with its line: Python's own words, or those that a student needs."""

import re
from types import TracebackType

from hapkit_studio.errors import LawError

_MOST = 300
# (what Python says, what a student reads); the groups of the first fill the second
_OTHER = (
    (r"cannot import name ('\w+') from '([\w.]+)'.*", r"there is no \1 in \2"),
    (
        r"(?:\w+\.)?(\w+)\.__init__\(\) missing \d+ required positional arguments?: (.+)",
        r"\1 also needs \2",
    ),
    (
        r"(?:\w+\.)?(\w+)\.__init__\(\) got an unexpected keyword argument (.+)",
        r"\1 has nothing named \2",
    ),
    (
        r"(?:\w+\.)?(\w+)\.__init__\(\) takes .* but \d+ were given",
        r"\1 is given more values than it takes",
    ),
    (
        r"object of type '(?:Parameter|Choice)' has no len\(\)",
        "`parameters` is a list in brackets; a single one ends with a comma: (Parameter(…),)",
    ),
    (r"'(?:Parameter|Choice)' object is not iterable", "`parameters` is a list in brackets"),
)


def plain(error: LawError) -> str:
    """Return an error's words without its line."""
    return str(error).removeprefix(f"Line {error.line}: ")


def of_syntax(error: SyntaxError, lines: int) -> LawError:
    """Return what Python cannot read, with its line in a file of so many lines."""
    words = f"Python cannot read this line: {error.msg}"
    return LawError(_short(words), min(error.lineno or 1, max(lines, 1)))


def of_exception(error: BaseException, file: str, otherwise: int = 0) -> LawError:
    """Return what went wrong while a file was executed, with the last line of that file that took part.

    otherwise is the line where none of the file did.
    """
    line, inside = _line(error.__traceback__, file)
    line = line or otherwise
    if isinstance(error, LawError):
        return error if error.line else LawError(plain(error), line)
    return LawError(_short(_words(error, inside)), line)


def _words(error: BaseException, inside: bool) -> str:
    """Return words for an exception; inside says whether the person's own line raised it."""
    name = getattr(error, "name", None)
    if isinstance(error, NameError) and name:
        return f"'{name}' is not defined"
    if isinstance(error, AttributeError) and name == "state_names":
        return "the force is not a law: write `@law` above its `def`"
    if isinstance(error, AttributeError) and name == "key":
        return "`parameters` holds Parameter(…) and Choice(…) only"
    if isinstance(error, KeyError) and error.args:
        return f"there is no {error.args[0]!r}"
    if isinstance(error, ModuleNotFoundError):
        return f"there is no module '{name}'"
    if isinstance(error, RecursionError):
        return "a function calls itself without end" if inside else "a line of the law is nested too deep"
    if isinstance(error, MemoryError):
        return "this takes more memory than there is"
    if isinstance(error, SystemExit | EOFError | KeyboardInterrupt):
        return "a file may not end the program or ask for input"
    if isinstance(error, ZeroDivisionError):
        return "a division by zero"
    message = str(error).strip()
    for pattern, words in _OTHER:
        if found := re.fullmatch(pattern, message):
            return found.expand(words)
    return f"{message or 'an error'} ({type(error).__name__})"


def _line(traceback: TracebackType | None, file: str) -> tuple[int, bool]:
    """Return the last line of a file in a traceback, and whether nothing was called from there."""
    line, inside = 0, False
    while traceback is not None:
        inside = traceback.tb_frame.f_code.co_filename == file
        line = traceback.tb_lineno if inside else line
        traceback = traceback.tb_next
    return line, inside


def _short(words: str) -> str:
    line = " ".join(words.split())
    return line if len(line) <= _MOST else line[: _MOST - 1] + "…"
