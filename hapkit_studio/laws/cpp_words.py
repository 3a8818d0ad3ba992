"""How names, numbers and long lines of a law are written in C++."""

import math

import numpy as np

# What C++ or an Arduino core has taken; its core defines some of them as macros, which know no scope.
_KEYWORDS = """
alignas alignof and and_eq asm auto bitand bitor bool break case catch char class compl const constexpr
continue decltype default delete do double dynamic_cast else enum explicit export extern false final float
for friend goto if inline int long mutable namespace new noexcept not not_eq nullptr operator or or_eq
override private protected public register reinterpret_cast return short signed sizeof static static_assert
static_cast struct switch template this thread_local throw true try typedef typeid typename union unsigned
using virtual void volatile wchar_t while xor xor_eq
abs bit bitClear bitRead bitSet bitWrite boolean byte cli constrain degrees highByte interrupts lowByte map
max min noInterrupts radians random round sei sq word main setup loop assert errno
j0 j1 jn y0 y1 yn sin cos tan exp log pow sqrt floor ceil fabs gamma index
p s laws fast numbers force start unwatched
"""
_TAKEN = frozenset(_KEYWORDS.split())
WIDTH = 100


def mangled(name: str) -> str:
    """Return a Python name as C++ can use it; different names stay different."""
    plain = "".join(c if c.isascii() else f"_u{ord(c):x}" for c in name)
    taken = plain in _TAKEN or plain.endswith("_") or plain.upper() == plain
    return plain + "_" if taken else plain


def constant_name(key: str) -> str:
    """Return the name of an index: ``kStickVelocity`` for stick_velocity."""
    return "k" + "".join(part[:1].upper() + part[1:] for part in mangled(key).split("_"))


def number(value: float) -> str:
    """Return a number as single precision has it: beyond its range INFINITY, below it 0."""
    with np.errstate(over="ignore", under="ignore"):
        single = np.float32(value)
    if math.isnan(single):
        return "NAN"
    if math.isinf(single):
        return "INFINITY" if single > 0 else "-INFINITY"
    if abs(single) < np.finfo(np.float32).tiny:
        return "0.0f"
    return f"{single!s}f"


def comment(text: str | None, indent: str = "") -> list[str]:
    """Return the first paragraph of a docstring as a C++ comment, in lines."""
    words = (text or "").split("\n\n")[0].split()
    lines: list[str] = []
    for word in words:
        if not lines or len(lines[-1]) + 1 + len(word) > WIDTH:
            lines.append(f"{indent}//")
        lines[-1] += f" {word.strip(chr(92))}"
    return lines


def wrapped(line: str) -> list[str]:
    """Return a line broken after commas, or before operators, where it is too long."""
    lines, indent = [], line[: len(line) - len(line.lstrip())] + "    "
    while len(line) > WIDTH:
        cut = max(line.rfind(", ", 0, WIDTH) + 1, *(line.rfind(mark, 0, WIDTH) for mark in _BREAKS))
        if cut <= len(indent):
            break
        lines.append(line[:cut])
        line = indent + line[cut + 1 :]
    return [*lines, line]


_BREAKS = (" + ", " - ", " * ", " ? ", " : ", " && ", " || ")
