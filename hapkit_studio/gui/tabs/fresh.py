"""What a result was measured for, and in words what has become another since."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hapkit_studio.gui.studio import Studio

Facts = Mapping[str, object]

PALE = 0.35  # how much of its colours a chart keeps that is out of date


def loop_facts(studio: "Studio", model: bool = True) -> dict[str, object]:
    """Return what a measurement of a loop is for: device, hand and loop as they are chosen.

    model: it also depends on how much of the device is modelled live.
    """
    device = studio.entry.key if studio.entry else ""
    loop = studio.loop if model else replace(studio.loop, model="")
    return {"device": device, "loop": loop, "hand": studio.grip}


class Fresh:
    """Remembers what one result was for; facts gives, by name, what it would be for now."""

    def __init__(self, facts: Callable[[], Facts], again: str = "Measure again"):
        self._facts, self._again = facts, again
        self._asked: Facts | None = None
        self._then: Facts | None = None

    def begin(self) -> None:
        """Note what is measured from now on."""
        self._asked = dict(self._facts())

    def keep(self) -> None:
        """Note that the result has come: it is for what was noted at its beginning."""
        self._then = self._asked

    @property
    def outdated(self) -> str:
        """Say what has changed since and what to do, "" where nothing has."""
        if self._then is None:
            return ""
        now = self._facts()
        changed = next((name for name, value in self._then.items() if now.get(name) != value), "")
        return f"Out of date: the {changed} changed. {self._again}." if changed else ""
