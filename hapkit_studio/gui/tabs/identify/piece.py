"""The newest piece of what the loop wrote: as much as was asked for, all with the settings in force."""

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from hapkit_studio.dynamics.hand import GRIPS
from hapkit_studio.errors import StudioError
from hapkit_studio.haptics import rows

if TYPE_CHECKING:
    from hapkit_studio.analysis.identify import Recording, Setup
    from hapkit_studio.gui.live.live import Live
    from hapkit_studio.gui.studio import Studio
    from hapkit_studio.haptics.engine import Engine

# Numbers ramp and forces fade for 30 ms after a change.
_SETTLED = 0.05
_LEAST = 0.2
_ALL = 1 << 30


def newest(studio: "Studio", live: "Live", seconds: float) -> "Callable[[], Recording]":
    """Take the newest so many seconds, inf: all that is kept; return what makes a recording of them.

    That is to be called in a thread. The rows are taken before anything else, which may take its time: what
    comes meanwhile is no part of the piece. Raise StudioError while there is no device, or too little.
    """
    engine = studio.engine
    if engine is None:
        raise StudioError("There is no device yet to take a piece from.")
    table = _table(engine, seconds, live.changed_at + _SETTLED)
    setup = _setup(studio, engine)

    def take() -> "Recording":
        from hapkit_studio.analysis.identify import of_rows

        return of_rows(table, setup)

    return take


def _setup(studio: "Studio", engine: "Engine") -> "Setup":
    from hapkit_studio.analysis.identify import Handle, Setup

    device = engine.modelled
    handle = Handle(device.mass, device.viscous, device.coulomb_force) if device else None
    quantum = float((device or engine.device).quantum)
    grip = GRIPS[studio.grip] if device else None
    environment, values = studio.environment, dict(studio.values)
    return Setup(environment, values, engine.loop.rate, engine.health().delay, quantum, handle, grip)


def _table(engine: "Engine", seconds: float, since: float) -> np.ndarray:
    """Return the newest rows (n, ROW_WIDTH) since a time; raise StudioError where there are too few."""
    reader = engine.reader()
    reader.rewind(_ALL if math.isinf(seconds) else math.ceil(1.1 * seconds * engine.loop.rate) + 1)
    table = reader.read()
    times = table[:, rows.HOST_TIME]
    first = max(since, times[-1] - seconds) if len(table) else since
    table = table[times >= first]
    kept = float(table[-1, rows.HOST_TIME] - table[0, rows.HOST_TIME]) if len(table) else 0.0
    if kept < _LEAST:
        raise StudioError(f"Only {kept:.1f} s since the settings changed. Move the handle, then identify.")
    return table
