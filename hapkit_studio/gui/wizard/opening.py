"""Opens the wizard or the test beside the window; one of them at a time has the board."""

from typing import TYPE_CHECKING

from hapkit_studio.gui.wizard.check_window import CheckWindow
from hapkit_studio.gui.wizard.shell import Shell
from hapkit_studio.gui.wizard.window import WizardWindow

if TYPE_CHECKING:
    from hapkit_studio.gui.window import MainWindow


def open_setup(window: "MainWindow") -> Shell:
    """Open Set up my Hapkit, or bring what is open to the front."""
    return _open(window, WizardWindow)


def open_check(window: "MainWindow") -> Shell:
    """Open Test my Hapkit, or bring what is open to the front."""
    return _open(window, CheckWindow)


def _open(window: "MainWindow", kind: type[WizardWindow] | type[CheckWindow]) -> Shell:
    there = [shell for shell in window.findChildren(Shell) if shell.isVisible()]
    if there:
        there[0].raise_()
        there[0].activateWindow()
        return there[0]
    shell = kind(window.studio, window)
    window.closed.connect(shell.close)
    shell.show()
    shell.begin()
    return shell
