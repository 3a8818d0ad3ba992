"""The views in the header: Live, and the law while one is open."""

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QTabBar

from hapkit_studio.gui.centre import Centre
from hapkit_studio.gui.editor.desk import Desk

LIVE, LAW = range(2)


class Views(QObject):
    """Keeps tabs, centre and desk of one mind."""

    def __init__(self, tabs: QTabBar, centre: Centre, desk: Desk):
        super().__init__(tabs)
        self._tabs, self._centre, self._desk = tabs, centre, desk
        tabs.currentChanged.connect(lambda index: centre.show_law(index == LAW))
        desk.shown.connect(self.show_law)
        desk.page.unsaved_changed.connect(self._mark)

    def show_law(self, on: bool) -> None:
        """Bring the editor into sight, its tab with it, or take both away."""
        if on and self._tabs.count() == LAW:
            self._tabs.addTab("Law")
        if on:
            self._tabs.setCurrentIndex(LAW)
        elif self._tabs.count() > LAW:
            self._tabs.removeTab(LAW)
            self._centre.scene.setFocus()
        self._mark()

    def change_over(self) -> None:
        """Go from the scene to the law in force, or from the law back to the scene."""
        code = self._desk.page.code
        if code.isVisible() and code.hasFocus():
            self._centre.scene.setFocus()
            return
        path = self._desk.path or self._desk.own.in_force
        if path is not None:
            self._desk.edit(path)

    def _mark(self) -> None:
        if self._tabs.count() > LAW:
            self._tabs.setTabText(LAW, "Law ●" if self._desk.page.unsaved else "Law")
