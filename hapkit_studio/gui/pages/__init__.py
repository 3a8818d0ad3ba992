"""The views beside Live. Each file declares one view as ``VIEW``; its page is built when first shown."""

from functools import cache

from hapkit_studio.discovery import declared
from hapkit_studio.gui.pages.base import View


@cache
def discover() -> dict[str, View]:
    """Return every view by key, in the order of the window's header."""
    return {view.key: view for view in sorted(declared(__name__, "VIEW", View), key=lambda view: view.order)}
