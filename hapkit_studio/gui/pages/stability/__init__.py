"""The view Stability: its name, and the page that is built when it is first shown."""

from hapkit_studio.gui.pages.base import View
from hapkit_studio.gui.pages.stability.page import StabilityPage

VIEW = View("stability", "Stability", 10, StabilityPage)
