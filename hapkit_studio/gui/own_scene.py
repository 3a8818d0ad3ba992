"""Whether a scene of the library can show a person's own environment as it is."""

from dataclasses import replace

from hapkit_studio.workshop.own import OwnEnvironment, built_in

BARE = "bare handle"


def fitting(environment: OwnEnvironment) -> OwnEnvironment:
    """Return it with the scene it names, or with the bare handle where that was drawn for something else.

    A scene reads the parameters and the state of its own environment: of another one they must have the
    same names, and stay within the limits the drawing was made for.
    """
    theirs = built_in().get(environment.scene)
    if theirs is None:
        return environment
    mine = {p.key: p for p in environment.parameters}
    inside = all(
        type(mine[p.key]) is type(p) and p.low <= mine[p.key].low and mine[p.key].high <= p.high
        for p in theirs.parameters
        if p.key in mine
    )
    if inside and environment.state_names == theirs.state_names:
        return environment
    return replace(environment, scene=BARE)
