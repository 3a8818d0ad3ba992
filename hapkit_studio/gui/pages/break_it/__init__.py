"""The view Break it: its name, and the page that is built when it is first shown."""

from hapkit_studio.gui.pages.base import View
from hapkit_studio.gui.pages.break_it.page import BreakItPage

VIEW = View("break_it", "Break it", 30, BreakItPage)
