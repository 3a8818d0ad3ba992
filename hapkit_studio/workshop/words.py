"""Python's own errors in a student's words, each with its line in the file."""

import re
from types import TracebackType

from hapkit_studio.errors import LawError
from hapkit_studio.workshop import syntax

_MOST = 300
# (what Python says, what a student reads); the groups of the first fill the second
_SYNTAX = (
    (r"expected ':'", "a colon is missing at the end of this line"),
    (r"expected '\('", "an opening bracket is missing after the name"),
    (r"('[(\[{]') was never closed", r"\1 is never closed"),
    (r"unmatched ('[)\]}]')", r"\1 closes nothing"),
    (r"closing parenthesis (.+) does not match opening parenthesis (.+)", r"\1 does not close \2"),
    (r"invalid syntax\. Perhaps you forgot a comma\?", "perhaps a comma is missing"),
    (r"invalid syntax\. Maybe you meant '==' .*", "to compare two values, write =="),
    (
        r"cannot assign to .* here\. Maybe you meant '==' .*",
        "only a name can be assigned; to compare, write ==",
    ),
    (r"cannot assign to (.+)", r"only a name can be assigned, not \1"),
    (r"unexpected indent", "this line begins too far to the right"),
    (r"unindent does not match any outer indentation level", "this line begins at no line's beginning above"),
    (r"expected an indented block after .* on line (\d+)", r"what belongs to line \1 begins farther right"),
    (r"inconsistent use of tabs and spaces in indentation", "tabs and spaces are mixed: use spaces only"),
    (r"unterminated (?:f-|triple-quoted )?string literal.*", "a quotation mark is missing"),
    (r"unterminated triple-quoted string literal.*", "the closing quotation marks are missing"),
    (r"invalid character '(.+)' \(U\+.*\)", r"'\1' is no character that Python knows here"),
    (r"invalid non-printable character (U\+\w+)", r"an invisible character (\1) stands here: delete it"),
    (r"invalid decimal literal", "a number runs into a name: write 2 * x"),
    (r"leading zeros in decimal integer literals.*", "a number does not begin with 0"),
    (r"expression cannot contain assignment.*", "what stands before = is one name"),
    (r"unexpected character after line continuation character", r"`\\` only stands at a line's end"),
    (r"expected 'else' after 'if' expression", "an `else` is missing"),
    (r"positional argument follows keyword argument", "a value without a name follows one with a name"),
    (r"'return' outside function", "`return` stands outside of a function"),
    (r".*null bytes.*", "the file is not text"),
    (r"too many nested parentheses|.*too complex.*", "the line is nested too deep"),
    (r"Missing parentheses in call to 'print'.*", "nothing can be printed here"),
    (r"invalid syntax", "Python cannot read this line"),
)
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
    message = (error.msg or "").strip()
    seen = syntax.clue(error.text, error.offset or 0) if message == "invalid syntax" and error.text else ""
    words = seen or _first(_SYNTAX, message) or f"Python cannot read this line: {message}"
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
    return _first(_OTHER, message) or f"{message or 'an error'} ({type(error).__name__})"


def _line(traceback: TracebackType | None, file: str) -> tuple[int, bool]:
    """Return the last line of a file in a traceback, and whether nothing was called from there."""
    line, inside = 0, False
    while traceback is not None:
        inside = traceback.tb_frame.f_code.co_filename == file
        line = traceback.tb_lineno if inside else line
        traceback = traceback.tb_next
    return line, inside


def _first(table: tuple[tuple[str, str], ...], message: str) -> str:
    for pattern, words in table:
        found = re.fullmatch(pattern, message)
        if found:
            return found.expand(words)
    return ""


def _short(words: str) -> str:
    line = " ".join(words.split())
    return line if len(line) <= _MOST else line[: _MOST - 1] + "…"
