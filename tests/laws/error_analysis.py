"""Running error analysis of the board's code: double-precision values with bounds on single-precision errors.

Source: Higham, Accuracy and Stability of Numerical Algorithms, 3.3. Inputs are exact, constants have an error
of half a unit in the last place; every operation propagates its operands' errors and adds its own rounding.
"""

import math
import struct
from dataclasses import dataclass
from unittest import mock

from hapkit_studio.laws import board

HALF_UNIT = 2.0**-24  # unit roundoff of single precision
LEAST, MOST = 2.0**-126, (2.0 - 2.0**-23) * 2.0**127
LESS_OR_MORE = (1, 4)
LARGE = struct.unpack("<f", struct.pack("<f", 3e38))[0]
"""A constant whose square overflows."""
LONGEST = 2.0**24
"""Quotients of at least this size have a remainder of 0."""
# number of bits before the binary point in the logarithm from which a power is computed
POWER_OWN = 8
USUAL_OWN = (8, 0.0)
"""Own error of a function, as a number of half units and an absolute term."""
REDUCED = 2e-9
"""Relative error of an angle after reduction by whole turns."""
MOST_WAYS = 32
"""Limit of the number of paths followed in parallel; a row with more paths is unclear."""


class Unclear(Exception):
    """Raised if rounding alone could cause a fault, an overflow, or a different integer result."""


class Fault(Exception):
    """Raised if a division by zero, or an index out of range, ends the law."""


def compile_unrounded(law, values, period, room=0) -> board.Program:
    """Return a law for the board with its constants in double precision."""
    with mock.patch.object(board, "_single", float):
        return board.compile(law, values, period, room)


def single(value: float) -> float:
    """Return a number in the machine's single precision, with denormals as 0."""
    try:
        rounded = struct.unpack("<f", struct.pack("<f", value))[0]
    except OverflowError:
        return math.copysign(math.inf, value)
    return rounded if abs(rounded) >= LEAST else 0.0


@dataclass(frozen=True)
class Instruction:
    name: str
    operands: tuple[int, ...]
    mask: int
    next: int
    aim: int  # index of the jump's target


def decoded(code: bytes) -> tuple[list[Instruction], int]:
    """Return the instructions, with indices as jump targets, and the index of MAIN's first instruction."""
    rows = list(board.instructions(code))
    place = {at: i for i, (at, _, _) in enumerate(rows)} | {len(code): len(rows)}
    found = []
    for at, operation, mask in rows:
        end, here, operands = at + operation.size, at + 1, []
        for kind in operation.operands:
            size = 2 if kind == "w" else 1
            operands.append(int.from_bytes(code[here : here + size], "little"))
            here += size
        aim = -1
        if operation.name in ("JUMP", "FAR_JUMP", "TEST", "COMPARE"):
            aim = place[end + operands[-1]]
        elif operation.name == "NEXT":
            aim = place[end - operands[-1]]
        elif operation.name == "CALL":
            aim = place[operands[0]] + 1
        found.append(Instruction(operation.name, tuple(operands), mask, place[end], aim))
    main = next(i for i, one in enumerate(found) if one.name == "MAIN")
    return found, main + 1


class Analysis:
    """Executes a law's code as the machine does, and computes an error bound for every value."""

    def __init__(self, program: board.Program):
        """Store a program whose constants are not rounded."""
        self.code, self.main = decoded(program.code)
        self.states = program.states
        self.values = [0.0, 0.0, *program.given] + [0.0] * (program.slots - 2 - len(program.given))
        self.errors = [0.0 if single(v) == v else HALF_UNIT * abs(v) + LEAST for v in self.values]
        self.zero_sign = False
        """True if the last call used the sign of zero, which algebraic optimisation may change."""

    def set_state(self, values) -> None:
        """Set the state before the next call, rounded to single precision."""
        for i, value in enumerate(values):
            self.values[2 + i], self.errors[2 + i] = value, 0.0

    @property
    def state(self) -> list[tuple[float, float]]:
        return list(zip(self.values[2 : 2 + self.states], self.errors[2 : 2 + self.states], strict=True))

    def call(self, x: float, v: float) -> tuple[float, float]:
        """Return one call's force and its error bound.

        If a compared value differs from the threshold by less than its error, the board may take either path:
        all paths are followed, and the bounds cover them. The values are those of the path in double
        precision. Raise Unclear if rounding could cause a fault, and Fault if the law ends with a fault.
        """
        self.zero_sign = False
        before = list(self.values), list(self.errors)
        force, error, first = None, 0.0, ([], [])
        ways: list[tuple[bool, ...]] = [()]
        while ways:
            self.values, self.errors = list(before[0]), list(before[1])
            self._way, self._turns = ways.pop(), []
            try:
                a, e = self._run(x, v)
            except Fault:
                if force is None and not self._turns:
                    raise
                raise Unclear from None
            ways += [(*self._turns[:i], not self._turns[i]) for i in range(len(self._way), len(self._turns))]
            if len(ways) > MOST_WAYS:
                raise Unclear
            if force is None:
                force, error, first = a, e, (self.values, self.errors)
                continue
            error = apart(force, error, a, e)
            for i in range(2, 2 + self.states):
                first[1][i] = apart(first[0][i], first[1][i], self.values[i], self.errors[i])
        self.values, self.errors = first
        return force, error

    def _takes(self, found: int, possible: int, mask: int) -> bool:
        """Return True if the current path takes a jump.

        If rounding could change the decision, the path's prescribed decisions apply; after them, the decision
        in double precision applies.
        """
        if not possible & mask or not possible & ~mask:
            return bool(possible & mask)
        turn = len(self._turns)
        self._turns.append(self._way[turn] if turn < len(self._way) else bool(found & mask))
        return self._turns[-1]

    def _run(self, x: float, v: float) -> tuple[float, float]:
        values, errors, code = self.values, self.errors, self.code
        values[0], values[1] = x, v
        errors[0] = errors[1] = 0.0
        counters, back = {}, []
        a, e, at = x, 0.0, self.main
        while True:
            one = code[at]
            name, operands = one.name, one.operands
            at = one.next
            if name == "LOAD":
                a, e = values[operands[0]], errors[operands[0]]
            elif name == "STORE":
                values[operands[0]], errors[operands[0]] = a, e
            elif name == "COMPARE":
                if self._takes(*outcomes(a, e, values[operands[0]], errors[operands[0]]), one.mask):
                    at = one.aim
            elif name == "TEST":
                if self._takes(*outcomes(a, e, 0.0, 0.0), one.mask):
                    at = one.aim
            elif name == "COPYSIGN":
                sign, off = values[operands[0]], errors[operands[0]]
                # the sign of zero is unknown
                possible = 5 if abs(sign) <= off or sign == 0.0 else LESS_OR_MORE[sign > 0.0]
                self.zero_sign |= sign == 0.0
                negative = self._takes(LESS_OR_MORE[math.copysign(1.0, sign) > 0.0], possible, 1)
                a = -abs(a) if negative else abs(a)
            elif name in BINARY:
                a, e = BINARY[name](a, e, values[operands[0]], errors[operands[0]])
            elif name in UNARY:
                a, e = UNARY[name](a, e)
            elif name in ("JUMP", "FAR_JUMP"):
                at = one.aim
            elif name == "LOOP":
                counters[operands[0]] = operands[1]
            elif name == "NEXT":
                counters[operands[0]] -= 1
                if counters[operands[0]]:
                    at = one.aim
            elif name == "CALL":
                back.append(at)
                at = one.aim
            elif name == "RETURN":
                if not back:
                    return a, e
                at = back.pop()
            else:
                place = operands[1] + index(values[operands[0]], errors[operands[0]], operands[2])
                if name == "LOAD_AT":
                    a, e = values[place], errors[place]
                else:
                    values[place], errors[place] = a, e


def apart(value, error, other, off) -> float:
    """Return the error bound of a value that also covers a second value with its error."""
    if not finite(value, other):
        if value != other and not (math.isnan(value) and math.isnan(other)):
            raise Unclear
        return error
    return max(error, abs(other - value) + off)


def outcomes(a, e, s, se) -> tuple[int, int]:
    """Return two bit masks: the result of comparing A with a slot, and all results that rounding permits."""
    if math.isnan(a) or math.isnan(s):
        return 8, 8
    found = 1 if a < s else 2 if a == s else 4
    near = e + se > 0.0 and abs(a - s) <= e + se
    return found, 7 if near else found


def index(i, e, size) -> int:
    if math.isnan(i) or i + e < 0.0 or i - e >= size:
        raise Fault
    if i - e < 0.0 or i + e >= size or math.floor(i - e) != math.floor(i + e):
        raise Unclear
    return int(i)


def rounded(value, error, own=(1, 0.0)) -> tuple[float, float]:
    """Return a result and its error bound: the operands' error, plus the operation's own rounding."""
    if not math.isfinite(value):
        if error:
            raise Unclear
        return value, 0.0
    if error == 0.0 and own == (1, 0.0) and single(value) == value:
        return value, 0.0
    error += own[0] * HALF_UNIT * (abs(value) + error) + own[1] + LEAST
    if abs(value) + error > MOST:
        raise Unclear
    return value, error


def finite(*values) -> bool:
    return all(map(math.isfinite, values))


def add(a, e, s, se):
    return rounded(a + s, e + se)


def subtract(a, e, s, se):
    return rounded(a - s, e + se)


def multiply(a, e, s, se):
    if abs(a) == LARGE == abs(s) or abs(a) == 3e38 == abs(s):
        return math.copysign(math.inf, a) * s, 0.0
    if not finite(a, s) and ((a == 0.0 and e) or (s == 0.0 and se)):
        raise Unclear
    return rounded(a * s, (abs(a) * se if se else 0.0) + (abs(s) * e if e else 0.0) + e * se)


def zero(s, se) -> None:
    """Raise Fault if a divisor is zero, Unclear if it may be zero."""
    if s == 0.0 and se == 0.0:
        raise Fault
    if abs(s) <= se:
        raise Unclear


def divide(a, e, s, se):
    zero(s, se)
    if not finite(a, s):
        return rounded(a / s, e)
    value = a / s
    return rounded(value, (e + abs(value) * se) / (abs(s) - se))


def whole_quotient(a, e, s, se, towards) -> int:
    """Return the rounded quotient; raise Unclear if it may round to another integer."""
    zero(s, se)
    found = {towards(top / bottom) for top in (a - e, a + e) for bottom in (s - se, s + se)}
    if len(found) > 1:
        raise Unclear
    return found.pop()


def floor_divide(a, e, s, se):
    if not finite(a, s):
        zero(s, se)
        raise Unclear
    if e == se == 0.0:
        zero(s, se)
        return rounded(a // s, 0.0, (1, 0.0) if abs(a) < LONGEST * abs(s) else (4, 0.0))
    return rounded(float(whole_quotient(a, e, s, se, math.floor)), 0.0, (4, 0.0))


def modulo(a, e, s, se):
    return _rest(a, e, s, se, math.floor, lambda: a % s)


def remainder(a, e, s, se):
    return _rest(a, e, s, se, math.trunc, lambda: math.fmod(a, s))


def _rest(a, e, s, se, towards, exact):
    zero(s, se)
    if not finite(a, s) or abs(a) + e >= LONGEST * (abs(s) - se):
        raise Unclear
    if e == se == 0.0:
        return rounded(exact(), 0.0)
    times = whole_quotient(a, e, s, se, towards)
    return rounded(exact(), e + abs(times) * se)


def power(a, e, s, se):
    if e == se == 0.0:
        return _as_power(_power(a, s), 0.0)
    if not finite(a, s):
        raise Unclear
    if abs(a) <= e or (a < 0.0 and se):
        if se or s != int(s) or s < 0.0:
            raise Unclear
        return _as_power(a**s, (abs(a) + e) ** s - abs(a) ** s)
    value = _power(a, s)
    corners = [_power(a + da, s + ds) for da in (-e, e) for ds in (-se, se)]
    if not finite(value, *corners):
        if all(map(math.isnan, (value, *corners))):
            return math.nan, 0.0
        raise Unclear
    return _as_power(value, max(abs(c - value) for c in corners))


def _as_power(value, error):
    bits = abs(math.log2(abs(value))) if value and math.isfinite(value) else 0.0
    return rounded(value, error, (POWER_OWN + bits, 0.0))


def _power(a, s) -> float:
    try:
        return math.pow(a, s)
    except ValueError:
        return math.inf if a == 0.0 else math.nan
    except OverflowError:
        raise Unclear from None


def atan2(a, e, s, se):
    distance, off = math.hypot(a, s), math.hypot(e, se)
    # at the branch cut, the result would depend on the sign of zero
    if not finite(a, s) or off >= distance or (s < 0.0 and abs(a) <= e) or a == 0.0 == s:
        raise Unclear
    return rounded(math.atan2(a, s), 1.6 * off / (distance - off), USUAL_OWN)


def hypot(a, e, s, se):
    return rounded(math.hypot(a, s), e + se, USUAL_OWN)


def minimum(a, e, s, se):
    if math.isnan(a) or math.isnan(s):
        return a, e
    return min(a, s), max(e, se) if abs(a - s) <= e + se else e if a < s else se


def maximum(a, e, s, se):
    if math.isnan(a) or math.isnan(s):
        return a, e
    return max(a, s), max(e, se) if abs(a - s) <= e + se else e if a > s else se


BINARY = {
    "ADD": add, "SUBTRACT": subtract, "MULTIPLY": multiply, "DIVIDE": divide, "MINIMUM": minimum,
    "MAXIMUM": maximum, "FLOOR_DIVIDE": floor_divide, "MODULO": modulo, "REMAINDER": remainder,
    "POWER": power, "ATAN2": atan2, "HYPOT": hypot,
    "SUBTRACT_FROM": lambda a, e, s, se: subtract(s, se, a, e),
    "DIVIDE_INTO": lambda a, e, s, se: divide(s, se, a, e),
}  # fmt: skip


def _whole(towards):
    def function(a, e):
        if not math.isfinite(a):
            return a, 0.0
        found = towards(a)
        if towards(a - e) != found or towards(a + e) != found:
            raise Unclear
        return rounded(float(found), 0.0)

    return function


def _monotone(name, low=-math.inf, high=math.inf, at_low=None):
    """Return a function that gives value and error bound of a function of ``math``, monotonic in [low, high].

    Outside this interval, the value is NaN.
    """
    function = getattr(math, name)

    def bounded(a, e):
        if math.isnan(a) or a + e < low or a - e > high:
            return math.nan, 0.0
        if e and (a - e < low or a + e > high or (at_low is not None and a - e <= low)):
            raise Unclear
        if a == low and at_low is not None:
            return at_low, 0.0
        try:
            value = function(a)
            off = max(abs(function(a + e) - value), abs(function(a - e) - value)) if e else 0.0
        except OverflowError:
            raise Unclear from None
        return rounded(value, off, USUAL_OWN)

    return bounded


def sqrt(a, e):
    if math.isnan(a) or a + e < 0.0:
        return math.nan, 0.0
    if a - e < 0.0:
        raise Unclear
    value = math.sqrt(a)
    return rounded(value, value - math.sqrt(a - e) if e else 0.0)


def _wave(name):
    function = getattr(math, name)

    def bounded(a, e):
        if not math.isfinite(a):
            return math.nan, 0.0
        return rounded(function(a), min(e, 2.0), (8, 1e-7 + REDUCED * abs(a)))

    return bounded


def tan(a, e):
    if not math.isfinite(a):
        return math.nan, 0.0
    e += 1e-7 + REDUCED * abs(a)
    if 2.0 * e >= abs(math.cos(a)):
        raise Unclear
    value = math.tan(a)
    off = max(abs(math.tan(a + e) - value), abs(math.tan(a - e) - value))
    return rounded(value, off, USUAL_OWN)


def cosh(a, e):
    try:
        return rounded(math.cosh(a), math.cosh(abs(a) + e) - math.cosh(a) if e else 0.0, USUAL_OWN)
    except OverflowError:
        raise Unclear from None


UNARY = {
    "NEGATE": lambda a, e: (-a, e), "ABSOLUTE": lambda a, e: (abs(a), e), "SQRT": sqrt,
    "FLOOR": _whole(math.floor), "CEIL": _whole(math.ceil), "TRUNCATE": _whole(math.trunc),
    "SIN": _wave("sin"), "COS": _wave("cos"), "TAN": tan, "COSH": cosh,
    "ASIN": _monotone("asin", -1.0, 1.0), "ACOS": _monotone("acos", -1.0, 1.0),
    "LOG": _monotone("log", 0.0, at_low=-math.inf), "LOG1P": _monotone("log1p", -1.0, at_low=-math.inf),
    **{n.upper(): _monotone(n) for n in ("atan", "exp", "expm1", "sinh", "tanh")},
}  # fmt: skip
