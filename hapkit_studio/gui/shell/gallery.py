"""The gallery: the library, the user's own environments, and the row for a new environment."""

from functools import partial
from pathlib import Path

from PySide6.QtCore import QRectF, QSize, Qt, Signal
from PySide6.QtGui import (
    QContextMenuEvent,
    QPainter,
    QPen,
    QResizeEvent,
)
from PySide6.QtWidgets import (
    QButtonGroup,
    QMenu,
    QScrollArea,
    QToolButton,
    QWidget,
)

from hapkit_studio.gui.state import environment_library
from hapkit_studio.gui.state.own_environments import OwnEnvironments, OwnFile
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.gui.widgets import breakpoints, icons
from hapkit_studio.gui.widgets.gallery_row import (
    LEAST_RAIL_ROW,
    LEAST_ROW,
    RAIL_ROW,
    ROW,
    GalleryRow,
    icon_name,
)
from hapkit_studio.gui.widgets.parts import label, vbox
from hapkit_studio.gui.widgets.text import plain_tip
from hapkit_studio.gui.widgets.theme import theme

# icon and text for each state of a file
_SIGNS = {"foreign": "lock", "broken": "triangle"}
_LINES = {
    "foreign": "File from someone else",
    "broken": "The file does not run yet",
    "checking": "Checking the file…",
}
_PENCIL, _RING, _LEAST = 30, 28, 120


def initials(title: str) -> str:
    """Return up to two initials of a title, for example MW for "My two walls"."""
    words = [word for word in title.split() if word[0].isalnum()]
    return "".join(word[0] for word in (words[:1] + words[1:][-1:])).upper()


class OwnRow(GalleryRow):
    """A row for one of the user's own environments; its pencil and menu emit the gallery's signals."""

    def __init__(self, file: OwnFile, gallery: "Gallery"):
        self.file, self._gallery = file, gallery
        super().__init__("circle", file.title, "")
        self.pencil = QToolButton(self)
        self.pencil.setFocusPolicy(Qt.FocusPolicy.NoFocus)  # for the keyboard, the row's menu has this action
        self.setAccessibleDescription(
            "Press the menu key to edit, show or delete the file of this environment."
        )
        self.pencil.clicked.connect(lambda: gallery.edit_pressed.emit(self.file.path))
        icons.bind(self.pencil, "pencil", "ink2", 18)
        self.show_file(file)

    def show_file(self, file: OwnFile) -> None:
        """Show title, summary and state of the file."""
        self.file = file
        self.set_text(
            _SIGNS.get(file.state, icon_name(file.scene)), file.title, _LINES.get(file.state, file.summary)
        )
        self.pencil.setToolTip(plain_tip(f"Edit {file.path.name}"))
        self.pencil.setAccessibleName(f"Edit {file.title}")

    def set_rail(self, rail: bool, height: int) -> None:
        super().set_rail(rail, height)
        self.pencil.setVisible(not rail and self.file.state != "foreign")

    def long_tip(self) -> str:
        return f"{self.title}\n{self.summary}\n{self.file.path.name}"

    def sizeHint(self) -> QSize:
        """Return a small size: a long title may be cut, because the tooltip shows the whole title."""
        return super().sizeHint().boundedTo(QSize(_LEAST, theme.px(LEAST_ROW)))

    def _paint_icon(self, painter: QPainter, color: str) -> None:
        """Draw a circle with the title's initials if the file names no scene."""
        if self.picture != "circle":
            super()._paint_icon(painter, color)
            return
        wide = theme.px(_RING)
        ring = QRectF(theme.px(10 if self.rail else 8), (self.height() - wide) / 2, wide, wide)
        painter.setPen(QPen(theme.color(color), 1.75))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.drawEllipse(ring)
        painter.setFont(theme.font("label"))
        painter.drawText(ring, Qt.AlignmentFlag.AlignCenter, initials(self.title))

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        size = theme.px(_PENCIL)
        self.pencil.setGeometry(self.width() - size - 8, (self.height() - size) // 2, size, size)

    def contextMenuEvent(self, event: QContextMenuEvent) -> None:
        self.menu().popup(event.globalPos())

    def menu(self) -> QMenu:
        """Return the actions for the file."""
        menu, gallery = QMenu(self), self._gallery
        menu.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        asks = {
            "Edit": gallery.edit_pressed,
            "Show in folder": gallery.reveal_pressed,
            "Delete…": gallery.delete_pressed,
        }
        for text, signal in asks.items():
            if text != "Edit" or self.file.state != "foreign":
                menu.addAction(text, partial(signal.emit, self.file.path))
        return menu


class Gallery(QScrollArea):
    """Lists the environments; a click selects one immediately.

    The user's own environments can also be edited, revealed in their folder, and deleted.
    """

    new_pressed = Signal()
    edit_pressed = Signal(object)
    reveal_pressed = Signal(object)
    delete_pressed = Signal(object)

    def __init__(self, studio: Studio, own: OwnEnvironments, parent: QWidget | None = None):
        super().__init__(parent)
        self._studio, self._own = studio, own
        self.setObjectName("gallery")
        self.setWidgetResizable(True)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.heading, self.own_heading = (label(text, "section") for text in ("Environments", "Your own"))
        for heading in (self.heading, self.own_heading):
            heading.setContentsMargins(14, 10, 14, 6)
        self.rows = {
            key: GalleryRow(icon_name(e.scene), e.title, e.summary, e.shortcut)
            for key, e in studio.environments.items()
        }
        self.own_rows: dict[object, OwnRow] = {}
        self.new_row = GalleryRow("plus", "New environment…", "", color="accent")
        self.new_row.setParent(self)
        self.new_row.setCheckable(False)
        self._group = QButtonGroup(self)
        self.rail = False
        self._arrange()
        own.changed.connect(self.show_own)
        studio.environment_changed.connect(self.show_state)
        for signal in (studio.readiness.changed, studio.lock_changed):
            signal.connect(self.show_readiness)
        self.show_own()

    def set_rail(self, rail: bool) -> None:
        """Switch between the list and the narrow rail of icons."""
        self.rail = rail
        self.heading.setVisible(not rail)
        self.own_heading.setVisible(bool(self.own_rows) and not rail)
        policy = Qt.ScrollBarPolicy
        self.setVerticalScrollBarPolicy(policy.ScrollBarAlwaysOff if rail else policy.ScrollBarAsNeeded)
        self._share_height()

    def show_state(self) -> None:
        """Mark the current environment, which may differ from the row that was clicked last."""
        row = self._present_row()
        if row is not None:
            row.setChecked(True)
            self.ensureWidgetVisible(row, 0, 0)

    def _present_row(self) -> GalleryRow | None:
        key = self._studio.environment.key
        return self.rows.get(key) or self.own_rows.get(self._own.path_of(key))

    def show_readiness(self) -> None:
        """Show which environments are still being compiled or are locked; the user cannot select these."""
        for key, row in self.rows.items():
            waiting = environment_library.WORDS.get(self._studio.readiness.state(key), "")
            for lock, why in self._studio.permissions.lasting_locks():
                if lock.covers(("environment", key)):
                    waiting = why
            if waiting != row.waiting:
                row.set_text(row.picture, row.title, row.summary, waiting)
        present = self._present_row()
        if present is not None:
            present.setChecked(True)

    def show_own(self) -> None:
        """Update the rows of the user's own environments."""
        files = {file.path: file for file in self._own.files}
        for path in [p for p in self.own_rows if p not in files]:
            row = self.own_rows.pop(path)
            self._group.removeButton(row)
            self._own_column.removeWidget(row)
            row.hide()
            row.deleteLater()
        for place, (path, file) in enumerate(files.items()):
            if path in self.own_rows:
                self.own_rows[path].show_file(file)
            else:
                row = self.own_rows[path] = OwnRow(file, self)
                row.clicked.connect(lambda _on=False, path=path: self._choose_own(path))
                self._group.addButton(row)
                self._own_column.insertWidget(place, row)
        self.set_rail(self.rail)
        self.show_state()
        self.order()

    def order(self) -> None:
        """Set the tab order: the library, the user's own environments, then the row for a new environment."""
        before: QWidget = list(self.rows.values())[-1]
        for row in self.own_rows.values():
            QWidget.setTabOrder(before, row)
            before = row
        QWidget.setTabOrder(before, self.new_row)

    def _share_height(self) -> None:
        """Distribute the height among the rows; the row for a new environment stays below the list."""
        rows = (*self.rows.values(), *self.own_rows.values(), self.new_row)
        heading, own = (h.sizeHint().height() * (not h.isHidden()) for h in (self.heading, self.own_heading))
        heights = (LEAST_RAIL_ROW, RAIL_ROW) if self.rail else (LEAST_ROW, ROW)
        least, most = map(theme.px, heights)
        above, seen = heading + own, len(rows)
        scrolls = self.height() - above < least * seen
        if scrolls:  # cut the list after a complete row
            above, seen = heading, max((self.height() - heading) // least, 2)
        height = min(most, max(least, (self.height() - above) // seen))
        for row in rows:
            row.set_rail(self.rail, height)
        self.verticalScrollBar().setSingleStep(height)
        last = above + height * (seen - 1)
        self.setViewportMargins(0, 0, 0, max(self.height() - last, 0) if scrolls else height)
        self.new_row.setGeometry(0, last, self.contentsRect().width(), height)
        self.new_row.raise_()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        rail = self.width() < theme.px(breakpoints.GALLERY)
        if rail != self.rail:
            self.set_rail(rail)
        else:
            self._share_height()

    def _choose_own(self, path: Path) -> None:
        self._own.choose(path)
        self.show_state()

    def _arrange(self) -> None:
        body = QWidget(self.viewport())
        body.setObjectName("galleryBody")
        self._own_column = vbox()
        vbox(self.heading, *self.rows.values(), self.own_heading, self._own_column, None, into=body)
        for key, row in self.rows.items():
            self._group.addButton(row)
            row.clicked.connect(lambda _on=False, key=key: self._own.choose_built_in(key))
        self.setWidget(body)
        self.new_row.clicked.connect(self.new_pressed)
