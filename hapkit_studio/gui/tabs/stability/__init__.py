"""The view Stability: its name, and the page that is built when it is first shown."""

from hapkit_studio.gui.tabs.base import Tab
from hapkit_studio.gui.tabs.stability.page import StabilityPage

TAB = Tab("stability", "Stability", 10, StabilityPage)
