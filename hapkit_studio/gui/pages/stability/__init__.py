"""The view Stability; its page is built when first shown."""

from hapkit_studio.gui.pages.base import View
from hapkit_studio.gui.pages.stability.page import StabilityPage

VIEW = View("stability", "Stability", 10, StabilityPage)
