"""The views beside Live: one file each, found by the name ``TAB``; their pages are built when first shown."""

from functools import cache

from hapkit_studio.discovery import declared
from hapkit_studio.gui.tabs.base import Tab


@cache
def discover() -> dict[str, Tab]:
    """Return every tab by its key, in the order in which the header shows them."""
    return {tab.key: tab for tab in sorted(declared(__name__, "TAB", Tab), key=lambda tab: tab.order)}
