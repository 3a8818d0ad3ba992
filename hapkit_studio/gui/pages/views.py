"""The views in the header: Live, what is measured, and the law while one is open."""

from collections.abc import Callable

from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QWidget

from hapkit_studio.gui import pages
from hapkit_studio.gui.editor.controller import EditorController
from hapkit_studio.gui.live.centre import Centre
from hapkit_studio.gui.live.live import Live
from hapkit_studio.gui.pages.base import Page
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.gui.widgets.tabs import Tabs

LIVE, LAW = "live", "law"


class Views(QObject):
    """Keeps tab, page and side panel in sync.

    A page is built when it is first shown. show_side(widget) puts a page's own side in the panel's place.
    ``changed``: another view is in sight, or what its actions depend on has changed.
    """

    changed = Signal()

    def __init__(
        self,
        studio: Studio,
        live: Live,
        bar: Tabs,
        centre: Centre,
        editor: EditorController,
        show_side: Callable[..., None],
    ):
        super().__init__(centre)
        self._studio, self._live, self._show_side = studio, live, show_side
        self._bar, self._centre, self._editor = bar, centre, editor
        self._library = pages.discover()
        self._pages: dict[str, Page] = {}
        self._shown: Page | None = None
        self.covered = False
        """Whether no other view than Live can be shown, and the side stays."""
        self._bar.kept = LAW
        self._bar.setTabData(0, LIVE)
        for key, tab in self._library.items():
            self._bar.setTabData(self._bar.addTab(tab.title), key)
        self._centre.add_page(self._editor.editor)
        self._bar.currentChanged.connect(self._follow)
        self._editor.shown.connect(self.show_law)
        self._editor.page.unsaved_changed.connect(self._mark)

    @property
    def key(self) -> str:
        """Return the key of the view in sight."""
        return self._bar.tabData(self._bar.currentIndex())

    @property
    def has_law(self) -> bool:
        """Return whether a law is open, so that its tab is there."""
        return self._index(LAW) >= 0

    @property
    def shown(self) -> Page | None:
        """Return the page in sight, None where plots or a law are."""
        return self._shown

    def page(self, key: str) -> Page:
        """Return a tab's page, built if it was not yet."""
        if key not in self._pages:
            page = self._pages[key] = self._library[key].build(self._studio, self._live)
            self._centre.add_page(page)
            page.marked.connect(lambda words, key=key: self._show_mark(key, words))
            page.changed.connect(self.changed)
        return self._pages[key]

    def show(self, key: str) -> None:
        """Bring a view into sight, and give it the keyboard."""
        if not self.covered:
            self._bar.setCurrentIndex(self._index(key))
        elif key != self.key:
            self._studio.refused.emit(f"{self._studio.hidden}.")
        self.take_keys()

    def cover(self, side: QWidget | None, page: Page | None = None) -> None:
        """Leave of all views only Live, and put a side in the panel's place; None brings all back.

        page, if any, stands in the plots' place; the scene stays above it only where the hand moves in it.
        """
        self._bar.setCurrentIndex(self._index(LIVE))
        self.covered = side is not None
        if page is not None:
            self._centre.add_page(page)
        self._bar.setEnabled(side is None)
        self._centre.show_page(page, scene=page is None or self._studio.hand_is_ours)
        self._show_side(side, fixed=self.covered)
        self.take_keys()

    def take_keys(self) -> None:
        """Give the keyboard to the view in sight; where its scene is, the arrow keys move the hand."""
        if self._centre.scene.isVisible():
            self._centre.scene.setFocus()
        elif self._shown is not None:
            self._shown.setFocus()

    def show_law(self, on: bool) -> None:
        """Bring the editor into sight, its tab with it, or take both away."""
        index = self._index(LAW)
        if on and index < 0:
            index = self._bar.addTab("Law")
            self._bar.setTabData(index, LAW)
        if on:
            self._bar.setCurrentIndex(index)
        elif index >= 0:
            if self.key == LAW:
                self._bar.setCurrentIndex(0)
            self._bar.removeTab(index)
            self._centre.scene.setFocus()
        self._mark()

    def change_over(self) -> None:
        """Go from the scene to the law in force, or from the law back to the scene."""
        code = self._editor.page.code
        if code.isVisible() and code.hasFocus():
            self._centre.scene.setFocus()
            return
        path = self._editor.path or self._editor.own.in_force
        if path is not None:
            self._editor.edit(path)

    def end(self) -> None:
        """End what pages still do."""
        for page in self._pages.values():
            page.end()

    def _index(self, key: str) -> int:
        keys = [self._bar.tabData(index) for index in range(self._bar.count())]
        return keys.index(key) if key in keys else -1

    def _follow(self) -> None:
        if self.covered:
            return
        key = self.key
        page = self.page(key) if key in self._library else None
        if self._shown is not None:
            self._shown.set_shown(False)
        self._shown = page
        if page is not None:
            self._centre.show_page(page, scene=self._library[key].scene)
        else:
            self._centre.show_page(self._editor.editor if key == LAW else None, law=True)
        self._show_side(page.side if page else None)
        if page is not None:
            page.set_shown(True)
        if key != LAW and not self._bar.hasFocus():  # else Qt gives it to what comes next, the status bar
            self.take_keys()
        self.changed.emit()

    def _show_mark(self, key: str, words: str) -> None:
        index, title = self._index(key), self._library[key].title
        self._bar.setTabText(index, f"{title} ●" if words else title)
        self._bar.setTabToolTip(index, words)

    def _mark(self) -> None:
        index = self._index(LAW)
        if index >= 0:
            self._bar.setTabText(index, "Law ●" if self._editor.page.unsaved else "Law")
