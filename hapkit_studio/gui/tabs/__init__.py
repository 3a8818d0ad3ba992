"""The views beside Live: one file each, found by the name ``TAB``; their pages are built when first shown."""

import importlib
import pkgutil
from functools import cache

from hapkit_studio.gui.tabs.base import Tab


@cache
def discover() -> dict[str, Tab]:
    """Return every tab by its key, in the order in which the header shows them."""
    modules = [importlib.import_module(info.name) for info in pkgutil.iter_modules(__path__, __name__ + ".")]
    found = [module.TAB for module in modules if hasattr(module, "TAB")]
    return {tab.key: tab for tab in sorted(found, key=lambda tab: tab.order)}
