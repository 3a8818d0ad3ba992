"""The layout of a session's file: the signals in its chunks, their storage formats, and the resulting tables.

Every file contains its own layout in the table "signal", so it stays readable if the studio's signals change.
Files of version 1 do not have this table; their layout is FIRST.
"""

import re
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from hapkit_studio.haptics.signals import NEVER, ON_REQUEST, SIGNALS
from hapkit_studio.sessions.columns import DamagedError

STATE = "state"
"""Name of the column with the law's state variables."""
MOST_SIGNALS = 64
_NAME = re.compile(r"[a-z][a-z0-9_]{0,39}")
_LONGEST_UNIT = 20
_HEAD = {"count": "INTEGER", "start": "REAL", "stop": "REAL", "states": "INTEGER", "extremes": "BLOB"}
HEAD = tuple(_HEAD)
"""The first columns of the table "chunk"; the columns of signals and state follow."""
_RESERVED = {*HEAD, "id", "crc", STATE}
_FIRST_COLUMNS = {"force": "asked", "applied_force": "applied"}  # current name: name in files of version 1


class StoredSignal(NamedTuple):
    """A row of the table "signal": the signal's name, unit and storage format.

    ``delta_to`` is the signal that is subtracted from the samples. ``extremes`` is 1 if chunks contain the
    extremes of every block. ``optional`` is 1 if a chunk may lack the signal.
    """

    name: str
    unit: str
    delta_to: str = ""
    extremes: int = 0
    optional: int = 0


@dataclass(frozen=True)
class Layout:
    """The signals of a file's chunks, in column order."""

    signals: tuple[StoredSignal, ...]

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Return the names of all signals, and STATE."""
        return (*(signal.name for signal in self.signals), STATE)

    @cached_property
    def with_extremes(self) -> tuple[str, ...]:
        """Return the signals whose extremes are stored, in the order of the extremes."""
        return tuple(signal.name for signal in self.signals if signal.extremes)

    @cached_property
    def optional(self) -> frozenset[str]:
        """Return the signals that a chunk may lack."""
        return frozenset(signal.name for signal in self.signals if signal.optional)

    def delta_to(self, name: str) -> str:
        """Return the signal that is subtracted from a signal's samples; "" if nothing is subtracted."""
        return next(signal.delta_to for signal in self.signals if signal.name == name)


LAYOUT = Layout(
    tuple(
        StoredSignal(s.name, s.unit, s.delta_to, int(s.extremes), int(s.recorded == ON_REQUEST))
        for s in SIGNALS
        if s.recorded != NEVER
    )
)
"""The layout of files that this version of the studio writes."""
FIRST = Layout(
    (
        StoredSignal("tick", ""),
        StoredSignal("time", "s"),
        StoredSignal("board_time", "s"),
        StoredSignal("position", "m", extremes=1),
        StoredSignal("velocity", "m/s", extremes=1),
        StoredSignal("force", "N", extremes=1),
        StoredSignal("applied_force", "N", "force", extremes=1),
        StoredSignal("energy", "J", extremes=1),
        StoredSignal("lateness", "s"),
        StoredSignal("compute", "s"),
        StoredSignal("flags", ""),
        StoredSignal("true_position", "m", optional=1),
        StoredSignal("true_velocity", "m/s", optional=1),
        StoredSignal("hand_force", "N", optional=1),
        StoredSignal("hand_target", "m", optional=1),
    )
)
"""The layout of the files of version 1."""
EVENT = {"time": "REAL", "kind": "TEXT", "what": "TEXT"}
SIGNAL = {"name": "TEXT", "unit": "TEXT", "delta_to": "TEXT", "extremes": "INTEGER", "optional": "INTEGER"}


def tables(layout: Layout, version: int) -> dict[str, dict[str, str]]:
    """Return each table's columns with their types; each row also has an id and a crc."""
    old = _FIRST_COLUMNS if version <= 1 else {}
    chunk = _HEAD | dict.fromkeys((old.get(name, name) for name in layout.names), "BLOB")
    return {"event": EVENT, "chunk": chunk} | ({} if version <= 1 else {"signal": SIGNAL})


def checked_layout(rows: list[tuple]) -> Layout:
    """Return the layout that the rows of the table "signal" define.

    Raise DamagedError if the rows are invalid.
    """
    if len(rows) > MOST_SIGNALS:
        raise DamagedError(f"the list of its signals has more than {MOST_SIGNALS} signals")
    found: dict[str, StoredSignal] = {}
    for row in rows:
        signal = StoredSignal(*row)
        texts = signal.name, signal.unit, signal.delta_to
        if not all(isinstance(text, str) for text in texts) or not _NAME.fullmatch(signal.name):
            raise DamagedError("the list of its signals has a signal without a name")
        known = signal.name not in _RESERVED and signal.name not in found
        if (
            not known
            or len(signal.unit) > _LONGEST_UNIT
            or (signal.delta_to and signal.delta_to not in found)
        ):
            raise DamagedError(f"the list of its signals has no valid signal {signal.name}")
        if not {signal.extremes, signal.optional} <= {0, 1}:
            raise DamagedError(f"the list of its signals has no valid signal {signal.name}")
        found[signal.name] = signal
    if "time" not in found:
        raise DamagedError("the list of its signals has no time")
    return Layout(tuple(found.values()))
