"""The views in the header: Live, the measuring views, and Law while a law is open."""

from collections.abc import Callable

from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QWidget

from hapkit_studio.gui import pages
from hapkit_studio.gui.editor.controller import EditorController
from hapkit_studio.gui.live.centre import Centre
from hapkit_studio.gui.live.live import Live
from hapkit_studio.gui.pages.base import Page
from hapkit_studio.gui.state.permissions import HIDDEN_BY_LESSON
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.gui.widgets.tabs import Tabs

LIVE, LAW = "live", "law"
_MAP = "stability"


class Views(QObject):
    """Keeps tab, page and side panel consistent.

    A page is built when first shown. ``show_side(widget)`` replaces the parameter panel by a page's side
    panel; ``show_beside(widget)`` replaces the gallery by a page. ``changed`` is emitted when another view is
    shown, or when a view's actions may have changed.
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
        show_beside: Callable[[QWidget | None], None],
    ):
        super().__init__(centre)
        self._studio, self._live, self._show_side = studio, live, show_side
        self._show_beside = show_beside
        self._bar, self._centre, self._editor = bar, centre, editor
        self._library = pages.discover()
        self._pages: dict[str, Page] = {}
        self._shown: Page | None = None
        self.covered = False
        """True if only Live can be shown, with a fixed side panel."""
        self._bar.pinned = LAW
        self._bar.setTabData(0, LIVE)
        for key, tab in self._library.items():
            self._bar.setTabData(self._bar.addTab(tab.title), key)
        self._centre.add_page(self._editor.editor)
        self._bar.currentChanged.connect(self._follow)
        self._editor.shown.connect(self.show_law)
        studio.lock_changed.connect(self._hide_map)
        self._editor.page.unsaved_changed.connect(self._mark)

    @property
    def key(self) -> str:
        """Return the key of the visible view."""
        return self._bar.tabData(self._bar.currentIndex())

    @property
    def has_law(self) -> bool:
        """Return whether a law is open and has a tab."""
        return self._index(LAW) >= 0

    @property
    def shown(self) -> Page | None:
        """Return the visible page; None while the plots or a law are visible."""
        return self._shown

    def page(self, key: str) -> Page:
        """Return a view's page; build it if it does not exist yet."""
        if key not in self._pages:
            page = self._pages[key] = self._library[key].build(self._studio, self._live)
            if not page.beside:
                self._centre.add_page(page)
            page.marked.connect(lambda text, key=key: self._show_mark(key, text))
            page.view_wanted.connect(self.show)
            page.plot_wanted.connect(self._centre.phase.choose_channel)
            page.changed.connect(self._place_beside)
            page.changed.connect(self.changed)
        return self._pages[key]

    def built(self, key: str) -> Page | None:
        """Return a view's page; None if it is not built yet."""
        return self._pages.get(key)

    def show(self, key: str) -> None:
        """Show a view and give it the keyboard focus."""
        index = self._index(key)
        if not self.covered and index >= 0 and not self._bar.isTabEnabled(index):
            self._studio.refused.emit(f"{self._library[key].title}: {HIDDEN_BY_LESSON.lower()}.")
        elif not self.covered:
            self._bar.setCurrentIndex(index)
        elif key != self.key:
            self._studio.refused.emit(f"{self._studio.hidden}.")
        self.take_focus()

    def cover(self, side: QWidget | None, page: Page | None = None, scene: bool = False) -> None:
        """Allow only the view Live, and show ``side`` in place of the parameter panel; None undoes both.

        If ``page`` is given, it replaces the plots. The scene stays visible above it if ``scene`` is True, or
        if the user moves the simulated hand in the scene.
        """
        self._bar.setCurrentIndex(self._index(LIVE))
        self.covered = side is not None
        if page is not None:
            self._centre.add_page(page)
        self._bar.setEnabled(side is None)
        self._centre.show_page(page, scene=scene or page is None or self._studio.hand_is_ours)
        self._show_side(side, fixed=self.covered)
        self.take_focus()
        self.changed.emit()

    def take_focus(self) -> None:
        """Give the keyboard focus to the scene, or to the page if the scene is hidden.

        In the scene, the arrow keys move the hand.
        """
        if self._centre.scene.isVisible():
            self._centre.scene.setFocus()
        elif self._shown is not None:
            self._shown.setFocus()

    def show_law(self, on: bool) -> None:
        """Show the editor and its tab, or hide both."""
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

    def toggle_law(self) -> None:
        """Switch from the scene to the running law, or from the law to the scene."""
        code = self._editor.page.code
        if code.isVisible() and code.hasFocus():
            self._centre.scene.setFocus()
            return
        path = self._editor.path or self._editor.own.active
        if path is not None:
            self._editor.edit(path)

    def end(self) -> None:
        """Stop the pages' background work."""
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
        if page is not None and not page.beside:
            self._centre.show_page(page, scene=self._library[key].scene)
        else:
            self._centre.show_page(self._editor.editor if key == LAW else None, law=True)
        self._show_side(page.side if page else None)
        self._place_beside()
        if page is not None:
            page.set_shown(True)
        if key != LAW and not self._bar.hasFocus():  # without this call, Qt moves the focus to the status bar
            self.take_focus()
        self.changed.emit()

    def _hide_map(self) -> None:
        """Disable the view of the stability map while a lesson hides the map."""
        hidden, index = "map" in self._studio.permissions.left_out, self._index(_MAP)
        if hidden and self.key == _MAP:
            self._bar.setCurrentIndex(self._index(LIVE))
        if self._bar.isTabEnabled(index) == hidden:
            self._bar.setTabEnabled(index, not hidden)
            self._bar.setTabToolTip(index, HIDDEN_BY_LESSON if hidden else "")

    def _place_beside(self) -> None:
        """Show a page in place of the gallery if such a page is open, otherwise show the gallery."""
        beside = (page for page in self._pages.values() if page.beside)
        self._show_beside(next((page for page in beside if page.stays or page is self._shown), None))

    def _show_mark(self, key: str, text: str) -> None:
        index, title = self._index(key), self._library[key].title
        self._bar.setTabText(index, f"{title} ●" if text else title)
        self._bar.setTabToolTip(index, text)

    def _mark(self) -> None:
        index = self._index(LAW)
        if index >= 0:
            self._bar.setTabText(index, "Law ●" if self._editor.page.unsaved else "Law")
