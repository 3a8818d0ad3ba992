"""Calls everything compiled that measuring needs, once and small, so that it is in numba's cache."""


def warm_up() -> None:
    """Compile what the stability map, the charts and the protocols call."""
