"""A law that times a vibration by counting its calls; its counter starts just below an hour at 4 kHz."""

TEXT = '''"""A vibration of 100 ms after a touch, by a clock that counts calls."""

import math

from hapkit_studio.environments.base import Environment
from hapkit_studio.laws import law
from hapkit_studio.parameters import Parameter


@law(state={"calls": 14_390_000, "touched": 0, "inside": False})
def force(p, s, x, v, dt):
    s.calls += 1
    contact = x >= 0.005
    if contact and not s.inside:
        s.touched = s.calls
    s.inside = contact
    since = (s.calls - s.touched) * dt
    if contact and since < 0.1:
        return p.kick * math.sin(2 * math.pi * 40 * since)
    return 0.0


ENVIRONMENT = Environment(
    key="late_clock", title="Late clock", summary="Times a touch", force=force,
    parameters=(Parameter("kick", "Kick", "N", 0.5, 0.0, 2.0),),
)
'''
