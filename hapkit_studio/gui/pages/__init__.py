"""The views beside Live: one file each, found by the name ``VIEW``; built when first shown."""

from functools import cache

from hapkit_studio.discovery import declared
from hapkit_studio.gui.pages.base import View


@cache
def discover() -> dict[str, View]:
    """Return every view by its key, in the order in which the header shows them."""
    return {view.key: view for view in sorted(declared(__name__, "VIEW", View), key=lambda view: view.order)}
