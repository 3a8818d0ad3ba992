"""The views beside Live: one file per view, discovered by the name ``VIEW`` and built when first shown."""

from functools import cache

from hapkit_studio.discovery import declared
from hapkit_studio.gui.pages.base import View


@cache
def discover() -> dict[str, View]:
    """Return every view by key, in the order of the header."""
    return {view.key: view for view in sorted(declared(__name__, "VIEW", View), key=lambda view: view.order)}
