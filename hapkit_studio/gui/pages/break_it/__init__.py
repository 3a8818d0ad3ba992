"""The view Break it; its page is built when first shown."""

from hapkit_studio.gui.pages.base import View
from hapkit_studio.gui.pages.break_it.page import BreakItPage

VIEW = View("break_it", "Break it", 30, BreakItPage)
