"""A moving mass and what pushes it: a spring, a damper, a handle that touches it, two walls.

m x'' = f - b x' - k x; while it touches the handle, also contact (touch - x), and while the two approach each
other pad (speed - x'); behind +-reach the spring `wall`. `touch` is where the object stands when they just
meet, side +1 says that the handle is on its left, -1 on its right, speed is the handle's. Every function
takes these eleven numbers, or some of them, in this order after its own. All SI; written in the law language.
"""

from hapkit_studio.dynamics.jit import compiled

# Where a handle or a wall stands that is not there.
FAR = 1e100
_FARTHEST, _FASTEST = 1.0, 1e4


@compiled
def place(x, v, touch, side, speed, reach):
    """Return (touching, closing, beyond): 1 or 0, 1 or 0, and +1 or -1 behind a wall, else 0."""
    touching = 1.0 if side * (touch - x) > 0.0 else 0.0
    closing = 1.0 if side * (speed - v) > 0.0 else 0.0
    if x > reach:
        return touching, closing, 1.0
    if x < -reach:
        return touching, closing, -1.0
    return touching, closing, 0.0


@compiled
def linear(touching, closing, beyond, b, k, f, touch, speed, contact, pad, reach, wall):
    """Return (damping, stiffness, force) of the linear piece that a place belongs to."""
    if touching > 0.0:
        k += contact
        f += contact * touch
        if closing > 0.0:
            b += pad
            f += pad * speed
    if beyond != 0.0:
        k += wall
        f += wall * beyond * reach
    return b, k, f


@compiled
def acceleration(x, v, m, b, k, f, touch, side, speed, contact, pad, reach, wall):
    """Return x'' in m/s^2 at (x, v)."""
    force = f - b * v - k * x + pushed(x, v, touch, side, speed, contact, pad)
    if x > reach:
        force -= wall * (x - reach)
    elif x < -reach:
        force -= wall * (x + reach)
    return force / m


@compiled
def pushed(x, v, touch, side, speed, contact, pad):
    """Return the force in N of the handle on an object at x that moves at v, positive to the right.

    The damper acts on the way in only.
    """
    depth = touch - x
    if side * depth <= 0.0:
        return 0.0
    force = contact * depth
    rate = speed - v
    if side * rate > 0.0:
        force += pad * rate
    return force


@compiled
def flown_apart(x, v):
    """Return 1 where an object is more than 1 m away, above 10 km/s or nowhere at all, else 0.

    A method that adds energy takes it there; a scene then begins anew, without a force in between.
    """
    return 0.0 if abs(x) <= _FARTHEST and abs(v) <= _FASTEST else 1.0
