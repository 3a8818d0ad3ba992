"""The view Identify: its name, and the page that is built when it is first shown."""

from hapkit_studio.gui.tabs.base import Tab
from hapkit_studio.gui.tabs.identify.page import IdentifyPage

TAB = Tab("identify", "Identify", 50, IdentifyPage)
