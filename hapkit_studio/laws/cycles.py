"""What code for the board's machine takes: at most, and on average while a handle moves."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import lru_cache

from hapkit_studio.laws import machine
from hapkit_studio.laws.machine import EQUAL, FIRST, GREATER, LESS


def instructions(code: bytes) -> Iterator[tuple[int, machine.Operation, int]]:
    """Yield (place, operation, mask) of every instruction of some code."""
    by_code = {o.code: o for o in machine.OPERATIONS}
    at = 0
    while at < len(code):
        byte = code[at]
        operation = by_code[byte & 0xF0 if byte >= 0x40 else byte]
        yield at, operation, byte & 15
        at += operation.size


def longest_path(code: bytes) -> int:
    """Return the cycles of one call on the longest way through the code, as the board's verifier counts."""
    reached: dict[int, int] = {}
    subroutines: dict[int, int] = {}
    loops: list[tuple[int, int, dict[int, int]]] = []
    here = section = 0
    back = -1  # where a RETURN leads to
    for at, operation, _ in instructions(code):
        here = max(here, reached.get(at, 0))
        end = at + operation.size
        word = int.from_bytes(code[end - 2 : end], "little")
        cost = here + operation.most
        match operation.name:
            case "SUBROUTINE" | "MAIN":
                subroutines[section] = reached.get(back, 0)
                here, section, reached = 0, at, {}
                continue
            case "RETURN":
                reached[back] = max(reached.get(back, 0), cost)
                here = 0
                continue
            case "JUMP" | "FAR_JUMP":
                aim = end + (code[end - 1] if operation.name == "JUMP" else word)
                reached[aim] = max(reached.get(aim, 0), cost)
                here = 0
                continue
            case "TEST" | "COMPARE":
                aim = end + code[end - 1]
                reached[aim] = max(reached.get(aim, 0), cost)
            case "CALL":
                cost += subroutines[word]
            case "LOOP":
                loops.append((word, cost, reached))
                reached = {}
            case "NEXT":
                times, before, outside = loops.pop()
                # every other turn takes as long as this one at most, also where one leads out
                more = (times - 1) * (cost - before)
                cost += more
                for aim, c in reached.items():
                    outside[aim] = max(outside.get(aim, 0), c + more)
                reached = outside
        here = cost
    return reached.get(back, 0)


# --- trial
_MOTION = tuple(
    (
        0.03 * math.sin(0.02 * k) + 0.006 * math.sin(0.11 * k),
        0.6 * math.cos(0.02 * k) + 0.66 * math.cos(0.11 * k),
    )
    for k in range(640)
)
"""Position in m and velocity in m/s of a handle that goes to and fro, with the hand's small moves on top."""
_WINDOW = 40
"""Calls over which an average is taken: a handle may stay for long where a law works most."""
_FUNCTIONS: dict[str, Callable] = {
    "ADD": lambda a, b: a + b, "SUBTRACT": lambda a, b: a - b, "SUBTRACT_FROM": lambda a, b: b - a,
    "MULTIPLY": lambda a, b: a * b, "DIVIDE": lambda a, b: a / b, "DIVIDE_INTO": lambda a, b: b / a,
    "MINIMUM": lambda a, b: b if b < a else a, "MAXIMUM": lambda a, b: b if b > a else a,
    "FLOOR_DIVIDE": lambda a, b: a // b, "MODULO": lambda a, b: a % b, "REMAINDER": math.fmod,
    "POWER": math.pow, "NEGATE": lambda a: -a, "ABSOLUTE": abs, "TRUNCATE": math.trunc,
    **{n.upper(): getattr(math, n) for n in ("atan2", "hypot", "copysign", "sqrt", "floor", "ceil")},
    "SIN": math.sin, "COS": math.cos,
    **{n.upper(): getattr(math, n) for n in ("tan", "asin", "acos", "atan", "exp", "expm1", "log", "log1p")},
    **{n.upper(): getattr(math, n) for n in ("sinh", "cosh", "tanh")},
}  # fmt: skip


@lru_cache(maxsize=256)
def mean_cycles(code: bytes, slots: int, given: tuple[float, ...]) -> tuple[float, tuple[float, ...]]:
    """Return the mean cycles of a call where the motion makes it work most, and each instruction's runs.

    The numbers are double precision, and what has no value is 0: only the way through the code matters.
    """
    steps = list(instructions(code))
    numbers = {at: i for i, (at, _, _) in enumerate(steps)}
    counts = [0] * len(steps)
    values = [0.0, 0.0, *given] + [0.0] * (slots - FIRST - len(given))
    costs = []
    start = max(i for i, (_, o, _) in enumerate(steps) if o.name == "MAIN") + 1
    for x, v in _MOTION:
        values[:FIRST] = x, v
        costs.append(_call(code, steps, numbers, counts, values, start))
    sums = [sum(costs[k : k + _WINDOW]) / _WINDOW for k in range(0, len(costs), _WINDOW)]
    return max(sums), tuple(c / len(_MOTION) for c in counts)


def _call(
    code: bytes,
    steps: Sequence[tuple[int, machine.Operation, int]],
    numbers: Mapping[int, int],
    counts: list[int],
    values: list[float],
    i: int,
) -> int:
    """Run the law once over its values from instruction i on; return the cycles."""
    a, cost = 0.0, 0
    calls: list[int] = []
    left: dict[int, int] = {}
    while True:
        at, operation, mask = steps[i]
        counts[i] += 1
        cost += operation.usual
        i += 1
        end = at + operation.size
        operands = code[at + 1 : end]
        match operation.name:
            case "RETURN":
                if not calls:
                    return cost
                i = calls.pop()
            case "CALL":
                calls.append(i)
                i = numbers[int.from_bytes(operands, "little")] + 1
            case "JUMP" | "FAR_JUMP":
                i = numbers[end + int.from_bytes(operands, "little")]
            case "LOOP":
                left[operands[0]] = int.from_bytes(operands[1:], "little")
            case "NEXT":
                left[operands[0]] -= 1
                if left[operands[0]]:
                    i = numbers[end - int.from_bytes(operands[1:], "little")]
            case "COMPARE" | "TEST":
                other = values[operands[0]] if operation.name == "COMPARE" else 0.0
                if mask & (LESS if a < other else EQUAL if a == other else GREATER):
                    i = numbers[end + operands[-1]]
            case "LOAD":
                a = values[operands[0]]
            case "STORE":
                values[operands[0]] = a
            case "LOAD_AT" | "STORE_AT":
                place = operands[1] + int(min(max(values[operands[0]], 0.0), operands[2] - 1.0))
                if operation.name == "LOAD_AT":
                    a = values[place]
                else:
                    values[place] = a
            case name:
                try:
                    a = float(_FUNCTIONS[name](a, *(values[o] for o in operands)))
                except (ArithmeticError, ValueError):
                    a = 0.0
                if not -1e38 < a < 1e38:
                    a = 0.0
