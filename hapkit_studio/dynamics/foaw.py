"""First-order adaptive windowing: the longest line that fits the newest samples gives the velocity.

Janabi-Sharifi, Hayward and Chen, IEEE Trans. Control Systems Technology 8(6), 2000, the best-fit variant: a
line of least squares, as long as no sample lies farther from it than the sensor's noise. Long and smooth when
slow, short and quick at an impact. Samples carry their age, so that a late one tilts no line.
"""

from hapkit_studio.dynamics.jit import internal

LONGEST = 16
# A sample of a quantised motion often lies just at the tolerance: it does not fit, whatever rounding says.
_TIE = 1.0 - 1e-9
_BEGUN, _SAMPLES, _AGES = 0, 1, 2 + LONGEST


@internal
def begun(memory):
    """Return whether the window holds samples."""
    return memory[_BEGUN] != 0.0


@internal
def begin(memory, position, velocity, period):
    """Fill the window with a steady motion that has just arrived at `position`."""
    memory[_BEGUN] = 1.0
    for i in range(LONGEST + 1):
        memory[_AGES + i] = i * period
        memory[_SAMPLES + i] = position - i * period * velocity


@internal
def push(memory, position, period):
    """Take a new sample, `period` s after the last; the oldest one drops out."""
    for i in range(LONGEST, 0, -1):
        memory[_AGES + i] = memory[_AGES + i - 1] + period
        memory[_SAMPLES + i] = memory[_SAMPLES + i - 1]
    memory[_AGES] = 0.0
    memory[_SAMPLES] = position


@internal
def _fits(memory, count, mean_age, mean, falling, tolerance):
    """Return whether `count` samples lie on a line to within the tolerance."""
    newest = memory[_SAMPLES]
    for i in range(count):
        line = mean + falling * (memory[_AGES + i] - mean_age)
        if abs(memory[_SAMPLES + i] - newest - line) > _TIE * tolerance:
            return False
    return True


@internal
def slope(memory, window, tolerance):
    """Return the velocity of the longest line, over up to `window` periods, that fits all its samples."""
    newest = memory[_SAMPLES]
    ages, moved, squares, products = 0.0, 0.0, 0.0, 0.0
    velocity = 0.0
    for n in range(1, window + 1):
        age, way = memory[_AGES + n], memory[_SAMPLES + n] - newest
        ages += age
        moved += way
        squares += age * age
        products += age * way
        count = n + 1
        falling = (count * products - ages * moved) / (count * squares - ages * ages)
        if n > 1 and not _fits(memory, count, ages / count, moved / count, falling, tolerance):
            break
        velocity = -falling
    return velocity
