"""A tab bar. Tabs for which there is no space are in a menu at its end."""

from functools import partial

from PySide6.QtCore import QSize, Qt
from PySide6.QtWidgets import QMenu, QPushButton, QTabBar, QWidget

from hapkit_studio.gui.widgets import icons


class Tabs(QTabBar):
    """A row of tabs. If the row is too short, its last tabs move to a menu, and its first tab as the last.

    The current tab and the tab with the data ``pinned`` always stay visible.
    """

    _fitting = True  # True until the construction is complete

    def __init__(self, parent: QWidget | None = None):
        super().__init__(parent, drawBase=False, expanding=False, usesScrollButtons=False)
        self.setElideMode(Qt.TextElideMode.ElideNone)
        self.pinned: object = None
        self.more = QPushButton("More", self)
        self.more.setAccessibleName("More views")
        self.more.setToolTip("Show the views that do not fit into the header")
        self.more.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.more.setProperty("flat", True)
        self.more.setLayoutDirection(Qt.LayoutDirection.RightToLeft)
        icons.bind(self.more, "chevron_down", "ink2", 16)
        self.menu = QMenu(self)
        self.more.clicked.connect(
            lambda: self.menu.popup(self.mapToGlobal(self.more.geometry().bottomLeft()))
        )
        self.currentChanged.connect(self._fit)
        self._fitting = False

    def sizeHint(self) -> QSize:
        return QSize(sum(self._widths()), super().sizeHint().height())

    def minimumSizeHint(self) -> QSize:
        return QSize(self.more.sizeHint().width(), super().minimumSizeHint().height())

    def tabLayoutChange(self) -> None:
        self._fit()

    def resizeEvent(self, event) -> None:
        super().resizeEvent(event)
        self._fit()

    def _widths(self) -> list[int]:
        return [self.tabSizeHint(index).width() for index in range(self.count())]

    def _fit(self) -> None:
        """Show as many tabs as there is space for; the menu offers the others."""
        if self._fitting:  # showing or hiding a tab triggers a layout
            return
        self._fitting = True
        widths, button = self._widths(), self.more.sizeHint()
        room, hidden = self.width(), set[int]()
        for index in reversed(range(self.count())):
            left = sum(widths) - sum(widths[i] for i in hidden) + (button.width() if hidden else 0)
            if left <= room:
                break
            if index != self.currentIndex() and (self.pinned is None or self.tabData(index) != self.pinned):
                hidden.add(index)
        for index in range(self.count()):
            # Qt bug: a no-op setTabVisible discards the change before it
            if self.isTabVisible(index) == (index in hidden):
                self.setTabVisible(index, index not in hidden)
        self._offer(sorted(hidden))
        shown = sum(width for index, width in enumerate(widths) if index not in hidden)
        self.more.setGeometry(shown, (self.height() - button.height()) // 2, button.width(), button.height())
        self.more.setVisible(bool(hidden))
        self._fitting = False

    def _offer(self, hidden: list[int]) -> None:
        self.menu.clear()
        for index in hidden:
            self.menu.addAction(self.tabText(index)).triggered.connect(partial(self.setCurrentIndex, index))
