"""The layout of the window's parts."""

from PySide6.QtWidgets import QMainWindow, QSplitter, QStackedWidget, QWidget

from hapkit_studio.gui.live.centre import Centre, fill
from hapkit_studio.gui.shell.header import Header
from hapkit_studio.gui.state.stored import StoredSettings
from hapkit_studio.gui.widgets import breakpoints
from hapkit_studio.gui.widgets.parts import vbox
from hapkit_studio.gui.widgets.theme import theme


class WindowLayout(QWidget):
    """Arranges header, status bar and, in a splitter between them, gallery, centre and panel.

    In a small window the panel is a drawer. The borders can be dragged, and their positions are stored.
    """

    def __init__(self, window: QMainWindow, settings: StoredSettings):
        super().__init__(window)
        self._window, self._settings = window, settings
        self._drawer_open: bool | None = None
        self._beside_page: QWidget | None = None
        self.projected = self.side_fixed = False
        self._gallery_width = settings.pixels("gallery_width", breakpoints.GALLERY)
        self._panel_width = settings.pixels("panel_width", breakpoints.PANEL)
        # create each part inside its final parent, because moving it would style it twice
        self.borders = QSplitter(self)
        self._left, self.side = QWidget(self.borders), QStackedWidget(self.borders)
        self.inner = QSplitter(self._left)

    def arrange(
        self,
        header: Header,
        gallery: QWidget,
        centre: Centre,
        panel: QWidget,
        replay_bar: QWidget,
        caption: QWidget,
        status: QWidget,
        banners: QWidget,
    ) -> None:
        """Place the parts, each of which was created inside this widget."""
        self._header, self._gallery, self._centre, self._banners = header, gallery, centre, banners
        self._panel = panel
        self.side.addWidget(panel)
        fill(self.inner, 1, 1, gallery, centre)
        fill(self.borders, 1, 0, self._left, self.side)
        self._beside = vbox((self.inner, 1), replay_bar, into=self._left)
        self._column = vbox(header, (self.borders, 1), caption, status, into=self)
        self._place_banners(False)
        self.inner.splitterMoved.connect(self._gallery_dragged)
        self.borders.splitterMoved.connect(self._panel_dragged)

    def open_drawer(self, on: bool) -> None:
        """Show or hide the panel, independent of the window's size."""
        self._drawer_open = on
        self.share()

    def show_side(self, side: QWidget | None, fixed: bool = False) -> None:
        """Show a page's side panel, or the parameter panel if ``side`` is None.

        If ``fixed`` is True, the user cannot hide it.
        """
        self.side_fixed = fixed
        shown = side or self._panel
        if self.side.indexOf(shown) < 0:
            self.side.addWidget(shown)
        self.side.setCurrentWidget(shown)
        self.share()
        shown.resize(self.side.size())  # resize now, because the page reads its side panel's width next

    def show_beside(self, page: QWidget | None) -> None:
        """Show a page in place of the gallery; None shows the gallery."""
        if page is self._beside_page:
            return
        if self._beside_page is not None:
            self._beside_page.hide()
        if page is not None and self.inner.indexOf(page) < 0:
            self.inner.insertWidget(0, page)
        self._beside_page = page
        self.share()

    def set_scale(self) -> None:
        """Set the theme's scale for the window's size."""
        window = self._window
        if self.projected:
            theme.set_scale(breakpoints.projected_scale(window.width(), window.height()), breakpoints.FRAME)
        else:
            theme.set_scale(breakpoints.scale(window.width(), window.height()))

    def share(self) -> None:
        """Lay out the window; hide parts for which there is no space."""
        self.set_scale()
        window, wide, px = self._window, self._window.width(), theme.px
        page = None if self.projected else self._beside_page
        if self._beside_page is not None:
            self._beside_page.setHidden(self.projected)
            self._beside_page.setFixedWidth(px(breakpoints.lesson_width(wide / theme.scale)))
        self._gallery.setHidden(self.projected or self._beside_page is not None)
        self._gallery.setMinimumWidth(px(breakpoints.RAIL))
        self._gallery.setMaximumWidth(px(breakpoints.GALLERY_MOST))
        self.side.setMinimumWidth(px(breakpoints.PANEL_NARROW))
        self.side.setMaximumWidth(px(breakpoints.PANEL_MOST))
        small = wide < breakpoints.DRAWER_WIDTH or window.height() < breakpoints.DRAWER_HEIGHT
        opened = not small if self._drawer_open is None else self._drawer_open
        opened = not self.projected and (opened or self.side_fixed)
        self._header.panel.setVisible(small and not self.projected and not self.side_fixed)
        self.side.setVisible(opened)
        self._place_banners(wide < breakpoints.BANNERS_BESIDE_PANEL and opened)
        self._column.activate()  # lay out now; otherwise one frame would show some parts in their old sizes
        usual = breakpoints.gallery_width(wide / theme.scale, self._gallery_width, self._panel_width)
        narrow = usual == breakpoints.RAIL != self._gallery_width
        if page is not None:
            usual = breakpoints.lesson_width(wide / theme.scale)
            narrow = wide / theme.scale < breakpoints.LESSON_WINDOW
        gallery, panel = px(usual), px(breakpoints.PANEL_NARROW if narrow else self._panel_width)
        self.borders.setSizes([wide - panel - 1, panel])
        self._beside.activate()
        widths = {self._gallery: gallery, page: gallery}
        rest = self._left.width() - gallery - 1
        parts = map(self.inner.widget, range(self.inner.count()))
        self.inner.setSizes([widths.get(part, rest) for part in parts])
        self._centre.lay_out()

    def _gallery_dragged(self, place: int, _handle: int) -> None:
        """Snap the gallery to a width that shows all titles, or to the narrow rail."""
        half, usual = (breakpoints.RAIL + breakpoints.GALLERY) / 2, place / theme.scale
        self._gallery_width = breakpoints.RAIL if usual < half else max(usual, breakpoints.GALLERY)
        gallery = theme.px(self._gallery_width)
        self.inner.setSizes([gallery, self._left.width() - gallery - 1])
        self._settings.setValue("gallery_width", self._gallery_width)

    def _panel_dragged(self) -> None:
        self._panel_width = self.side.width() / theme.scale
        self._settings.setValue("panel_width", self._panel_width)

    def _place_banners(self, across: bool) -> None:
        """Place the banners beside the panel or, if ``across``, above all parts.

        A banner beside the panel does not move a slider that the user is dragging.
        """
        if across:
            self._column.insertWidget(1, self._banners)
        else:
            self._beside.insertWidget(0, self._banners)
