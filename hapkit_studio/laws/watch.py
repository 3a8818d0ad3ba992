"""Run-time checks of a compiled law: they store fault code, line and fuel in the law's fault words.

Only the first fault is stored. The checks are compiled once for all laws.
"""

import math

from hapkit_studio.dynamics.jit import internal
from hapkit_studio.laws.native import LAW_DIVISION, LAW_FUEL, LAW_INDEX, NOT_A_NUMBER


@internal
def to_float(a):
    """Return a number or a Boolean as a float."""
    return a * 1.0


@internal
def index(i, size, line, fault):
    """Return an index with 0 <= i < size; otherwise record a fault."""
    if 0 <= i < size:
        return int(i)
    if fault[0] == 0:
        fault[0] = LAW_INDEX
        fault[1] = line
    return 0


@internal
def spent(line, fault):
    """Use one unit of fuel; return True if the law must stop."""
    if fault[0] == 0:
        fault[1] -= 1
        if fault[1] < 0:
            fault[0] = LAW_FUEL
            fault[1] = line
    return fault[0] != 0


@internal
def divisor(a, line, fault):
    """Return a divisor as a float; record a fault if it is zero."""
    if a == 0.0 and fault[0] == 0:
        fault[0] = LAW_DIVISION
        fault[1] = line
    return a * 1.0


@internal
def noted(a, line, fault):
    """Return a value as a float; record the line of the first value that is not finite."""
    if fault[2] == 0 and not math.isfinite(a):
        fault[2] = line
    return a * 1.0


@internal
def force(a, line, fault):
    """Return the force as a float.

    If it is not finite, record a fault at the line of the first non-finite value.
    """
    if fault[0] == 0 and not math.isfinite(a):
        fault[0] = NOT_A_NUMBER
        fault[1] = fault[2] if fault[2] else line
    return a * 1.0
