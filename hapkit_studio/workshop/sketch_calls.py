"""Calls of the board's fast functions, rewritten as everybody writes them in C."""

import re
from collections.abc import Callable

_OPERATOR = re.compile(r" (?:[-+*/<>]|[<>=!]=|&&|\|\||\?) |^-")
_CALL = re.compile(r"(!?)\b(?:fast|laws)::(\w+)(?:<(-?\d+)>)?\(")

_WHOLE = re.compile(r"(.*(?: = |return ))\(")

_COMPARED = {
    "is_zero": ("==", "!="),
    "below_zero": ("<", ">="),
    "above_zero": (">", "<="),
    "to_zero": ("<=", ">"),
    "from_zero": (">=", "<"),
}
_SUMS = {
    "plus_product": "{0} + {1} * {2}",
    "less_product": "{0} - {1} * {2}",
    "product_less": "{1} * {2} - {0}",
}
_FUNCTIONS = {
    "magnitude": "fabsf",
    "least": "fminf",
    "most": "fmaxf",
    "signed_as": "copysignf",
    "remainder": "fmodf",
    "power_of": "powf",
}
_SAME = "floor ceil trunc sqrt hypot exp expm1 log log1p sin cos tan asin acos atan atan2 sinh cosh tanh"
_FUNCTIONS |= {name: f"{name}f" for name in _SAME.split(" ")}


def plain(text: str) -> str:
    """Return a law's C++ with such calls as plain C; what has no plain form keeps its name."""
    while (found := _first(text)) is not None:
        start, end, words = found
        text = text[:start] + words + text[end:]
    return "\n".join(map(_bare, _single(text).split("\n")))


def _single(text: str) -> str:
    """Return a text without second brackets round the same."""
    at = 0
    while (at := text.find("((", at)) >= 0:
        end = _closing(text, at + 2)
        if text[end : end + 2] == "))" and len(_arguments(text[at + 2 : end])) == 1:
            text = text[:at] + text[at + 1 : end] + text[end + 1 :]
        else:
            at += 1
    return text


def _bare(line: str) -> str:
    """Return a line without brackets round all that it sets or returns."""
    found = _WHOLE.match(line)
    if found is None or _closing(line, found.end()) != len(line) - 2 or not line.endswith(");"):
        return line
    if len(_arguments(line[found.end() : -2])) > 1:  # several things done in a row
        return line
    return f"{found[1]}{line[found.end() : -2]};"


def _first(text: str) -> tuple[int, int, str] | None:
    """Return where the first call that has a plain form stands, and that form."""
    for match in _CALL.finditer(text):
        end = _closing(text, match.end())
        words = _rewritten(match[1], match[2], match[3], _arguments(text[match.end() : end]))
        if words is not None:
            return match.start(), end + 1, words
    return None


def _rewritten(negated: str, name: str, number: str | None, given: list[str]) -> str | None:
    if name in _COMPARED:
        return f"{_operand(given[0])} {_COMPARED[name][bool(negated)]} 0.0f"
    if name == "is":
        return f"{_operand(given[0])} {'!=' if negated else '=='} {given[1]}"
    if name == "larger":
        return f"fabsf({given[0]}) {'<=' if negated else '>'} {given[1]}"
    if name in _FUNCTIONS:
        return f"{negated}{_FUNCTIONS[name]}({', '.join(given)})"
    if name == "scaled" and number is not None:
        return f"({2.0 ** int(number):g}f * {_operand(given[0])})".replace("(2f", "(2.0f").replace(
            "(4f", "(4.0f"
        )
    if name == "flipped_by":
        return f"({_operand(given[1])} * {_operand(given[0])})"
    if name in _SUMS:
        return f"({_SUMS[name].format(*map(_operand, given))})"
    return None


def _operand(words: str) -> str:
    """Return an argument so that it may stand beside an operator."""
    return f"({words})" if _OPERATOR.search(_outside(words)) else words


def _outside(words: str) -> str:
    """Return words with everything in brackets left out."""
    depth, kept = 0, []
    for character in words:
        depth -= character in ")]}"
        if depth == 0:
            kept.append(character)
        depth += character in "([{"
    return "".join(kept)


def _walk(text: str, start: int, ends: Callable[[str, int], bool]) -> int:
    depth = 0
    for at in range(start, len(text)):
        if ends(text[at], depth):
            return at
        depth += (text[at] in "([{") - (text[at] in ")]}")
    return len(text)


def _closing(text: str, start: int) -> int:
    """Return where the bracket that was opened before start is closed."""
    return _walk(text, start, lambda character, depth: character == ")" and depth == 0)


def _arguments(text: str) -> list[str]:
    found, start = [], 0
    while start <= len(text):
        end = _walk(text, start, lambda character, depth: character == "," and depth == 0)
        found.append(" ".join(text[start:end].split()))
        start = end + 1
    return found
