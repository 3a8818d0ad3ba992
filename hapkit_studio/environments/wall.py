"""Virtual wall: free space, then a spring, and a damper that by default acts only on entry."""

from hapkit_studio.environments.base import Environment, ForceTerms, Values
from hapkit_studio.laws import law
from hapkit_studio.parameters import Choice, Parameter


@law
def force(p, s, x, v, dt):
    side = 1.0 if p.side == "right" else -1.0
    depth = side * (x - p.position)
    if depth <= 0.0:
        return 0.0
    rate = side * v
    if p.damping_mode == "none" or (p.damping_mode == "into" and rate < 0.0):
        rate = 0.0
    return -side * (p.stiffness * depth + p.damping * rate)


def impedance(p: Values) -> tuple[float, float]:
    """Return the (stiffness, damping) that act in contact."""
    return p["stiffness"], p["damping"] if p["damping_mode"] != 2 else 0.0


def terms(p: Values) -> ForceTerms:
    """Return the wall's spring and damper, and the direction in which the damper acts."""
    stiffness, damping = impedance(p)
    one_way = (1.0 if p["side"] == 0 else -1.0) if p["damping_mode"] == 0 and damping > 0.0 else 0.0
    return ForceTerms(
        stiffness, damping, None, p["position"], one_way, contact=True, terms=("stiffness", "damping")
    )


def unused(p: Values) -> dict[str, str]:
    """Return the damping parameter if damping is switched off."""
    return {"damping": "Not used, because damping never acts"} if p["damping_mode"] == 2 else {}


ENVIRONMENT = Environment(
    key="wall",
    title="Wall",
    summary="Pushes back if pressed",
    parameters=(
        Parameter(
            "stiffness",
            "Stiffness",
            "N/m",
            250.0,
            0.0,
            5000.0,
            "Force for each metre of depth in the wall",
            "k",
        ),
        Parameter(
            "damping", "Damping", "N·s/m", 0.0, 0.0, 50.0, "Force for each m/s of speed inside the wall", "b"
        ),
        Parameter(
            "position", "Position", "m", 0.005, -0.04, 0.04, "Position of the wall's surface", "x<sub>w</sub>"
        ),
        Choice("side", "Side", ("right", "left"), "right", "Side of the surface on which the wall stands"),
        Choice(
            "damping_mode",
            "Damping acts",
            ("into", "both", "none"),
            "into",
            "When damping acts: only on the way in, both ways (the wall may pull on the way out), or never.",
            labels=("On the way in", "Both ways", "Never"),
            phrases=("on the way in", "both ways", "never"),
        ),
    ),
    force=force,
    shortcut="2",
    formula="<i>F</i> = −<i>k d</i> − <i>b v</i> in the wall",
    symbols="<i>k</i> stiffness, <i>d</i> depth in the wall, <i>b</i> damping, <i>v</i> velocity",
    explanation="Inside the wall a spring pushes you out, and a damper acts on the way in. Outside there is "
    "no force. The loop measures the position only once per period T, so the handle at speed v "
    "enters by up to v·T before the wall reacts. It is then pushed out with more energy than it "
    "brought: that is why a stiff wall buzzes.",
    impedance=impedance,
    terms=terms,
    unused=unused,
    shades=True,
    hands=("released", "press", "tap"),
    needs=("mass", "viscous", "coulomb", "sampling", "delay", "saturation"),
    order=2,
)
