"""What is wrong in a line that Python only calls invalid syntax: what beginners write most is recognised."""

import difflib
import keyword
import re

_BLOCKS = ("if", "elif", "else", "for", "while", "def")
_WORDS = (*_BLOCKS, "return", "from", "import", "break", "continue")
_ELSEWHERE = {"elseif": "elif", "elsif": "elif", "endif": "", "end": "", "function": "def", "func": "def"}
# (what other languages write, what Python does)
_OPERATORS = {
    "=>": "write `>=`",
    "=<": "write `<=`",
    "&&": "write `and`",
    "||": "write `or`",
    "++": "write `a = a + 1`",
    "--": "write `a = a - 1`",
    "!": "write `not`",
    "?": "write `a if x > 0.0 else b`",
}
_ALIKE = 0.7


def clue(line: str, column: int) -> str:
    """Return what a line's mistake seems to be, "" for no idea; column is where Python stopped, from 1."""
    code = _without_text(line)
    for look in (_assigned, _unknown_word, _operator, _then, _bracket, _colon, _no_if, _end, _beside):
        if words := look(code, max(column - 1, 0)):
            return words
    return ""


def _without_text(line: str) -> str:
    """Return a line with its strings blanked out, at the same length, and without its comment."""
    blank = re.sub(r"'[^']*'|\"[^\"]*\"", lambda found: '"' + "_" * (len(found[0]) - 2) + '"', line)
    return blank.partition("#")[0].rstrip()


def _first(code: str) -> str:
    found = re.match(r"\s*(\w+)", code)
    return found[1] if found else ""


def _assigned(code: str, place: int) -> str:
    word = _first(code)
    if keyword.iskeyword(word) and re.match(r"\s*\w+\s*=(?!=)", code):
        return f"`{word}` is a word of Python: choose another name"
    return ""


def _unknown_word(code: str, place: int) -> str:
    """Recognise a misspelt keyword by what follows it: a name, a number, or nothing but a colon."""
    word = _first(code)
    if keyword.iskeyword(word) or not re.match(r"\s*\w+(\s+[\w(\-+\"]|\s*:)", code):
        return ""
    meant = _ELSEWHERE.get(word.lower(), _alike(word.lower()))
    return f"'{word}' is no word of Python: perhaps `{meant}`" if meant else ""


def _alike(word: str) -> str:
    swapped = [known for known in _WORDS if sorted(known) == sorted(word)]
    return next(iter(swapped or difflib.get_close_matches(word, _WORDS, 1, _ALIKE)), "")


def _operator(code: str, place: int) -> str:
    near = code[max(place - 2, 0) : place + 2]
    for sign, instead in _OPERATORS.items():
        if sign in near and not (sign == "!" and "!=" in near):
            return f"`{sign}` is not Python: {instead}"
    return ""


def _then(code: str, place: int) -> str:
    return "`then` is not Python: the line ends with a colon" if re.search(r"\bthen\b", code) else ""


def _bracket(code: str, place: int) -> str:
    if _first(code) not in _BLOCKS:  # a call may go on in the next line
        return ""
    for opening, closing in ("()", "[]", "{}"):
        if code.count(opening) > code.count(closing):
            return f"'{opening}' is never closed"
    return ""


def _colon(code: str, place: int) -> str:
    word = _first(code)
    if word not in _BLOCKS or ":" in code:
        return ""
    where = f"after `{word}`" if word == "else" else "at the end of this line"
    other = re.search(r"\S\s+(return|break|continue|pass)\b", code)
    return f"a colon is missing {f'before `{other[1]}`' if other else where}"


def _no_if(code: str, place: int) -> str:
    word = _first(code)
    if word in ("else", "elif") and not code[:place].strip():
        return f"`{word}` stands below no `if` that begins as far to the right"
    return ""


def _end(code: str, place: int) -> str:
    return "something is missing at the end of this line" if code and place >= len(code) else ""


def _beside(code: str, place: int) -> str:
    """Name what stands where Python stopped, and before it where that is a value too."""
    here = re.match(r"\w+|\S", code[place:])
    if not here:
        return ""
    before = re.search(r"([\w.]+|[)\]\"])\s+$", code[:place])
    if keyword.iskeyword(here[0]):
        return (
            f"`{here[0]}` begins a line of its own" if here[0] == "return" else f"`{here[0]}` is out of place"
        )
    if before and here[0][0].isalnum() and not keyword.iskeyword(before[1]):
        return f"between `{before[1]}` and `{here[0]}` a sign is missing, like `*`"
    return f"Python cannot read this line from `{here[0]}` on"
