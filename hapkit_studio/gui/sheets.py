"""Sheets of words on the studio and its loop."""

from importlib.metadata import version
from typing import TYPE_CHECKING

from PySide6.QtWidgets import QWidget

from hapkit_studio.gui.help_dialog import Sheet, words_sheet

if TYPE_CHECKING:
    from hapkit_studio.haptics.priority import Priority


def priority_sheet(found: "Priority", parent: QWidget) -> Sheet:
    """Return the sheet on what the loop has obtained from the system, and how to get more."""
    more = found.how or "This is the most this system gives."
    return words_sheet("Real-time priority", [f"The loop has obtained: {found.text}.", more], parent)


def about_sheet(parent: QWidget) -> Sheet:
    """Return the sheet on the studio itself."""
    text = "Feel, tune and measure virtual environments on a Hapkit, real or simulated."
    return words_sheet("Hapkit Studio", [text, f"Version {version('hapkit-studio')}, BSD-3-Clause."], parent)
