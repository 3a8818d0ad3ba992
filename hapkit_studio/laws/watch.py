"""What a compiled law calls to note its faults: their codes, lines and fuel stand in the words it is given.

The first fault stays. These are compiled once, whatever laws a person writes.
"""

import math

from hapkit_studio.dynamics.jit import internal
from hapkit_studio.laws.native import LAW_DIVISION, LAW_FUEL, LAW_INDEX, NOT_A_NUMBER


@internal
def to_float(a):
    """Return a number, or a truth value, as a float."""
    return a * 1.0


@internal
def index(i, size, line, fault):
    """Return the place of a number from 0 to below a size; any other is a fault."""
    if 0 <= i < size:
        return int(i)
    if fault[0] == 0:
        fault[0] = LAW_INDEX
        fault[1] = line
    return 0


@internal
def spent(line, fault):
    """Take one unit of fuel; return whether the law has to end."""
    if fault[0] == 0:
        fault[1] -= 1
        if fault[1] < 0:
            fault[0] = LAW_FUEL
            fault[1] = line
    return fault[0] != 0


@internal
def divisor(a, line, fault):
    """Return a divisor as a float; zero is a fault."""
    if a == 0.0 and fault[0] == 0:
        fault[0] = LAW_DIVISION
        fault[1] = line
    return a * 1.0


@internal
def noted(a, line, fault):
    """Return a value as a float; the line of the first that is not finite is remembered."""
    if fault[2] == 0 and not math.isfinite(a):
        fault[2] = line
    return a * 1.0


@internal
def force(a, line, fault):
    """Return the force as a float; one that is not finite is a fault, of the line where that began."""
    if fault[0] == 0 and not math.isfinite(a):
        fault[0] = NOT_A_NUMBER
        fault[1] = fault[2] if fault[2] else line
    return a * 1.0
