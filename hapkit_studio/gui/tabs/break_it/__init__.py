"""The view Break it: its name, and the page that is built when it is first shown."""

from hapkit_studio.gui.tabs.base import Tab
from hapkit_studio.gui.tabs.break_it.page import BreakItPage

TAB = Tab("break_it", "Break it", 30, BreakItPage)
