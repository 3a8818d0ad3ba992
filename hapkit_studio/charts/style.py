"""Colours of static pictures: the palette's, always of the light theme."""

from hapkit_studio.palette import table

LIGHT = table("light")
INK, INK2, QUIET = LIGHT["ink"], LIGHT["ink2"], LIGHT["ink3"]
LINE, EDGE, SURFACE, GRID = LIGHT["line"], LIGHT["edge"], LIGHT["surface"], LIGHT["grid"]
ACCENT, ACCENT_SOFT = LIGHT["accent"], LIGHT["accentsoft"]
DANGER, DANGER_SOFT = LIGHT["danger"], LIGHT["dangersoft"]
WARN, WARN_SOFT, OK, OK_SOFT = LIGHT["warn"], LIGHT["warnsoft"], LIGHT["ok"], LIGHT["oksoft"]
STABLE, PASSIVE, UNSTABLE = LIGHT["stable"], LIGHT["passive"], LIGHT["unstable"]
POSITION, VELOCITY, ASKED, APPLIED = (LIGHT[name] for name in ("position", "velocity", "asked", "applied"))
THEORY, ENERGY, HELD = LIGHT["theory"], LIGHT["energy"], LIGHT["hold"]
