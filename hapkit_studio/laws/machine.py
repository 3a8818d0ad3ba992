"""The board's virtual machine: operations, encoding and cycle counts.

A law on the board is a table of float32 slots and code that works on an accumulator A. At the start, A
contains the position. Slot 0 is the position and slot 1 the velocity. Then come the law's state, constants,
tables and temporaries. Each instruction is an opcode byte followed by its operands. Slots take one byte. Jump
distances take one or two bytes (little endian) and are counted from the end of the instruction. The code is a
sequence of sections. Each section begins with SUBROUTINE; the last one begins with MAIN. A section ends with
RETURN or with a jump, so that control never runs into the next section. It may call earlier sections.

Denormals (below 2^-126) count as 0 in the operands and results of arithmetic. On division, //, % or fmod by
0, and on an index outside its table, the law ends at once with NaN.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property, lru_cache
from pathlib import Path


@dataclass(frozen=True)
class Operation:
    """One operation: opcode, name, operands, effect, typical and worst-case cycles.

    In ``operands``, s is a slot, n a one-byte number, d a one-byte distance, and w a two-byte number or
    distance. Cycles are counted from the instruction's first byte to the first byte of the next instruction.
    """

    code: int
    name: str
    operands: str
    does: str
    usual: int
    most: int

    @cached_property
    def size(self) -> int:
        """Return the length of the instruction in bytes."""
        return 1 + sum(2 if o == "w" else 1 for o in self.operands)


LESS, EQUAL, GREATER, UNORDERED = 1, 2, 4, 8
"""Outcomes of a comparison of A with a slot or with 0; they are the low four bits of both jump opcodes."""

OPERATIONS = (
    Operation(0x00, "RETURN", "", "end the subroutine, or the law with force A", 13, 13),
    Operation(0x01, "SUBROUTINE", "", "beginning of a subroutine; it is never run", 0, 0),
    Operation(0x02, "MAIN", "", "beginning of the law itself; it is never run", 0, 0),
    Operation(0x03, "CALL", "w", "run the subroutine at offset w of the code", 27, 27),
    Operation(0x04, "JUMP", "d", "jump forward by d bytes", 13, 13),
    Operation(0x05, "FAR_JUMP", "w", "jump forward by w bytes", 17, 17),
    Operation(0x06, "LOOP", "nw", "counter n = w: run the code up to its NEXT w times", 24, 24),
    Operation(0x07, "NEXT", "nw", "decrement counter n; jump back by w bytes unless it is 0", 32, 32),
    Operation(0x08, "LOAD", "s", "A = s", 25, 25),
    Operation(0x09, "STORE", "s", "s = A", 25, 25),
    Operation(0x0A, "LOAD_AT", "ssn", "A = slot second + int(value of first), for 0 <= int < n", 86, 101),
    Operation(0x0B, "STORE_AT", "ssn", "slot second + int(value of first) = A, for 0 <= int < n", 87, 101),
    Operation(0x10, "ADD", "s", "A = A + s", 110, 190),
    Operation(0x11, "SUBTRACT", "s", "A = A - s", 111, 190),
    Operation(0x12, "SUBTRACT_FROM", "s", "A = s - A", 111, 190),
    Operation(0x13, "MULTIPLY", "s", "A = A * s", 124, 140),
    Operation(0x14, "DIVIDE", "s", "A = A / s", 415, 495),
    Operation(0x15, "DIVIDE_INTO", "s", "A = s / A", 414, 495),
    Operation(0x16, "MINIMUM", "s", "A = s if s < A else A", 61, 85),
    Operation(0x17, "MAXIMUM", "s", "A = s if s > A else A", 61, 85),
    Operation(0x18, "FLOOR_DIVIDE", "s", "A = A // s as in Python", 395, 875),
    Operation(0x19, "MODULO", "s", "A = A % s as in Python", 290, 895),
    Operation(0x1A, "REMAINDER", "s", "A = fmod(A, s)", 205, 720),
    Operation(0x1B, "POWER", "s", "A = A ** s", 2407, 2730),
    Operation(0x1C, "ATAN2", "s", "A = atan2(A, s)", 1469, 1740),
    Operation(0x1D, "HYPOT", "s", "A = hypot(A, s)", 898, 1865),
    Operation(0x1E, "COPYSIGN", "s", "A = |A| with the sign of s", 29, 29),
    Operation(0x20, "NEGATE", "", "A = -A", 10, 10),
    Operation(0x21, "ABSOLUTE", "", "A = |A|", 10, 10),
    Operation(0x22, "SQRT", "", "A = sqrt(A)", 502, 570),
    Operation(0x23, "FLOOR", "", "A = floor(A)", 96, 185),
    Operation(0x24, "CEIL", "", "A = ceil(A)", 106, 200),
    Operation(0x25, "TRUNCATE", "", "A = trunc(A)", 75, 160),
    Operation(0x26, "SIN", "", "A = sin(A)", 790, 825),
    Operation(0x27, "COS", "", "A = cos(A)", 687, 825),
    Operation(0x28, "TAN", "", "A = tan(A)", 1611, 1840),
    Operation(0x29, "ASIN", "", "A = asin(A)", 1182, 1880),
    Operation(0x2A, "ACOS", "", "A = acos(A)", 1216, 1845),
    Operation(0x2B, "ATAN", "", "A = atan(A)", 1407, 1650),
    Operation(0x2C, "EXP", "", "A = exp(A)", 690, 780),
    Operation(0x2D, "EXPM1", "", "A = exp(A) - 1, without losing digits near 0", 771, 920),
    Operation(0x2E, "LOG", "", "A = log(A)", 1257, 1430),
    Operation(0x2F, "LOG1P", "", "A = log(1 + A), without losing digits near 0", 1068, 1675),
    Operation(0x30, "SINH", "", "A = sinh(A)", 1411, 1640),
    Operation(0x31, "COSH", "", "A = cosh(A)", 1205, 1345),
    Operation(0x32, "TANH", "", "A = tanh(A)", 1369, 1595),
    Operation(
        0x40, "COMPARE", "sd", "jump if the comparison of A with s has an outcome in bits 0 to 3", 63, 86
    ),
    Operation(0x50, "TEST", "d", "jump if the comparison of A with 0 has an outcome in bits 0 to 3", 30, 36),
)
X, V, FIRST = 0, 1, 2  # slots of position and velocity; first slot of the state
MOST_SLOTS = 255
MOST_SUBROUTINES = 8
MOST_CALLS = 4  # largest call depth
MOST_COUNTERS = 4  # largest number of nested loops; the callees of a loop's body use only lower counters
MOST_JUMPS = 16  # largest number of forward-jump targets pending at a time in a section
MOST_CYCLES = 65534  # limit of the board's counter; the longest period has 32,000 cycles
ARENA = 768  # bytes for a law's slots, its code and the constants that are being ramped
RAMPS, RAMP = 8, 6
"""Number of constants that can ramp at the same time, and bytes for each: slot, time left, target."""
REST, REST_AT_MOST = 1400, 1700
"""Cycles of a tick without the law, with a nonzero force: typical, worst case."""
ESTIMATE = 200  # additional cycles of the velocity estimate, if the law reads the velocity
FRAME = 3000  # cycles of telemetry and messages, every millisecond


class Refusal(IntEnum):
    """The reason why a board rejects a law."""

    NONE = 0
    TOO_LARGE = 1  # slots and code do not fit in the arena
    OPERATION = 2  # an operation is unknown, truncated or misplaced
    SLOT = 3  # an operand is not a slot of this law, or a constant is written
    JUMP = 4  # a jump leaves its section, or enters a loop from outside
    LOOP = 5  # loops are not nested with falling counters, or a loop count is 0
    CALL = 6  # the callee is not an earlier subroutine, or the call depth is exceeded
    END = 7  # a section does not end with RETURN or a jump
    CONSTANT = 8  # a number in the table is not finite
    TOO_SLOW = 9  # the longest path exceeds the period
    RATE = 10  # the board does not support the rate, or the estimator with these coefficients


# --- cycles of code
def instructions(code: bytes) -> Iterator[tuple[int, Operation, int]]:
    """Yield (offset, operation, mask) of every instruction."""
    by_code = {o.code: o for o in OPERATIONS}
    at = 0
    while at < len(code):
        byte = code[at]
        operation = by_code[byte & 0xF0 if byte >= 0x40 else byte]
        yield at, operation, byte & 15
        at += operation.size


def longest_path(code: bytes) -> int:
    """Return the cycles of the longest path of a call, by the same rule as the board's verifier."""
    reached: dict[int, int] = {}
    subroutines: dict[int, int] = {}
    loops: list[tuple[int, int, dict[int, int]]] = []
    here = section = 0
    back = -1  # return address
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
                # every other iteration costs at most the same, even one that leaves the loop
                more = (times - 1) * (cost - before)
                cost += more
                for aim, c in reached.items():
                    outside[aim] = max(outside.get(aim, 0), c + more)
                reached = outside
        here = cost
    return reached.get(back, 0)


# --- simulation
_MOTION = tuple(
    (
        0.03 * math.sin(0.02 * k) + 0.006 * math.sin(0.11 * k),
        0.6 * math.cos(0.02 * k) + 0.66 * math.cos(0.11 * k),
    )
    for k in range(640)
)
"""Position in m and velocity in m/s of a handle moved to and fro, with tremor."""
_WINDOW = 40
"""Number of calls that are averaged, because a handle may stay long in the law's most expensive region."""
_FUNCTIONS: dict[str, Callable] = {
    "ADD": lambda a, b: a + b, "SUBTRACT": lambda a, b: a - b, "SUBTRACT_FROM": lambda a, b: b - a,
    "MULTIPLY": lambda a, b: a * b, "DIVIDE": lambda a, b: a / b, "DIVIDE_INTO": lambda a, b: b / a,
    "MINIMUM": lambda a, b: b if b < a else a, "MAXIMUM": lambda a, b: b if b > a else a,
    "FLOOR_DIVIDE": lambda a, b: a // b, "MODULO": lambda a, b: a % b, "REMAINDER": math.fmod,
    "POWER": math.pow, "NEGATE": lambda a: -a, "ABSOLUTE": abs, "TRUNCATE": math.trunc,
}  # fmt: skip
"""Python implementations of operations; the others are functions of ``math``."""


@lru_cache(maxsize=256)
def mean_cycles(code: bytes, slots: int, given: tuple[float, ...]) -> tuple[float, tuple[float, ...]]:
    """Return the mean cycles per call, and how often each instruction is executed per call.

    The cycles are those of the test motion with the highest mean; the execution counts are means over all
    test motions.

    The arithmetic is double precision, and undefined values count as 0, because only the path matters.
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
    steps: Sequence[tuple[int, Operation, int]],
    numbers: Mapping[int, int],
    counts: list[int],
    values: list[float],
    i: int,
) -> int:
    """Run the law once on ``values``, starting at instruction i; return the cycles."""
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
                    function = _FUNCTIONS.get(name) or getattr(math, name.lower())
                    a = float(function(a, *(values[o] for o in operands)))
                except (ArithmeticError, ValueError):
                    a = 0.0
                if not -1e38 < a < 1e38:
                    a = 0.0


# --- header
_HEAD = """\
// Generated by `python -m hapkit_studio.laws.machine`; do not edit.
// The machine's operations, and the reasons for refusing a law.
#pragma once

"""
_MASKED, _MASKS = 0x40, 16
_SHAPES = {
    "": "None", "s": "Slot", "ssn": "Indexed", "d": "Near", "sd": "SlotNear", "w": "Far", "nw": "Counter",
}  # fmt: skip
_LIMITS = {
    "MostCalls": MOST_CALLS, "MostCounters": MOST_COUNTERS, "MostJumps": MOST_JUMPS,
    "MostSubroutines": MOST_SUBROUTINES, "MostCycles": MOST_CYCLES, "UsualArena": ARENA, "Ramps": RAMPS,
    "Ramp": RAMP, "RestAtMost": REST_AT_MOST, "Frame": FRAME,
}  # fmt: skip


def _camel(name: str) -> str:
    return "k" + "".join(word.title() for word in name.split("_"))


def text() -> str:
    """Return the whole header: constants for the assembler, and the rest for C++."""
    known = {o.code: o for o in OPERATIONS}
    single = 1 + max(code for code in known if code < _MASKED)
    rows = [known.get(code) for code in [*range(single), *(code for code in known if code >= _MASKED)]]
    sizes = {o.operands: o.size for o in OPERATIONS}
    lines = [
        "#ifdef __ASSEMBLER__",
        *(f".equ OP_{o.name}, 0x{o.code:02x}" for o in OPERATIONS),
        "#else",
        "",
        '#include "flash.h"',
        "",
        "namespace machine {",
        "",
        *(f"constexpr uint16_t k{name} = {value};" for name, value in _LIMITS.items()),
        "",
        "enum class Refusal : uint8_t {",
        *(f"  {_camel(one.name)} = {one.value}," for one in Refusal),
        "};",
        "",
        "enum Opcode : uint8_t {",
        *(f"  {_camel(o.name)} = 0x{o.code:02x},  // {o.does}" for o in OPERATIONS),
        "};",
        "",
        "// Operands of an operation: slots, numbers and near distances take one byte, far distances two.",
        "// The lower bits are the length of the instruction in bytes.",
        "enum Operands : uint8_t {",
        "  kUnknown = 0,",
        *(f"  k{name} = 0x{16 * n + sizes[kind]:02x}," for n, (kind, name) in enumerate(_SHAPES.items())),
        "};",
        "constexpr uint8_t kSizeOf = 0x0f;",
        "",
        "struct Operation {",
        "  Operands operands;",
        "  uint16_t most;  // worst-case cycles",
        "};",
        "",
        f"constexpr uint8_t kSingle = 0x{single:02x};",
        f"constexpr uint8_t kMasked = 0x{_MASKED:02x};",
        f"constexpr uint8_t kMasks = {_MASKS};",
        f"// Operations with one opcode, below kSingle; then those with {_MASKS} opcodes, from kMasked on.",
        f"static const Operation kTable[{len(rows)}] PROGMEM = {{",
        *(f"  {{k{_SHAPES[o.operands]}, {o.most}}},  // {o.name}" if o else "  {kUnknown, 0}," for o in rows),
        "};",
        "",
        "}  // namespace machine",
        "",
        "#endif",
    ]
    return _HEAD + "\n".join(lines) + "\n"


HEADER = Path(__file__).resolve().parents[2] / "firmware" / "hapkit" / "opcodes.h"

if __name__ == "__main__":
    HEADER.write_text(text())
