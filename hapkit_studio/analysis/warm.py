"""Calls everything compiled that measuring needs, once and small, so that it is in numba's cache."""

from hapkit_studio.analysis.failures import failures
from hapkit_studio.analysis.failures.shown import show


def warm_up() -> None:
    """Compile what the stability map, the charts and the protocols call."""
    for failure in failures().values():
        show(failure)
