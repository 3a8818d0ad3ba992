"""The gallery: the library, below it a person's own environments, last the way to a new one."""

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QButtonGroup, QLabel, QScrollArea, QVBoxLayout, QWidget

from hapkit_studio.gui import readiness
from hapkit_studio.gui.gallery_row import (
    LEAST_RAIL_ROW,
    LEAST_ROW,
    RAIL,
    RAIL_ROW,
    ROW,
    WIDE,
    GalleryRow,
    icon_name,
)
from hapkit_studio.gui.own import OwnEnvironments
from hapkit_studio.gui.own_row import NewRow, OwnRow
from hapkit_studio.gui.studio import Studio

__all__ = ["RAIL", "WIDE", "Gallery", "GalleryRow", "icon_name"]


def _heading(words: str) -> QLabel:
    label = QLabel(words)
    label.setProperty("role", "section")
    label.setContentsMargins(14, 10, 14, 6)
    return label


class Gallery(QScrollArea):
    """A click on an environment switches at once; own ones can be edited, shown, deleted."""

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
        self.heading, self.own_heading = _heading("Environments"), _heading("Yours")
        self.rows = {
            key: GalleryRow(icon_name(e.scene), e.title, e.summary, e.shortcut)
            for key, e in studio.environments.items()
        }
        self.own_rows: dict[object, OwnRow] = {}
        self.new_row = NewRow(self)
        self._group = QButtonGroup(self)
        self.rail = False
        self._arrange()
        own.changed.connect(self.show_own)
        studio.environment_changed.connect(self.show_state)
        studio.readiness.changed.connect(self.show_readiness)
        self.show_own()

    def set_rail(self, rail: bool) -> None:
        """Switch between the list and the rail."""
        self.rail = rail
        self.setFixedWidth(RAIL if rail else WIDE)
        self.heading.setVisible(not rail)
        self.own_heading.setVisible(bool(self.own_rows) and not rail)
        policy = Qt.ScrollBarPolicy
        self.setVerticalScrollBarPolicy(policy.ScrollBarAlwaysOff if rail else policy.ScrollBarAsNeeded)
        self._share_height()

    def show_state(self) -> None:
        """Mark the environment in force, whatever was clicked."""
        row = self._row_in_force()
        if row is not None:
            row.setChecked(True)
            self.ensureWidgetVisible(row, 0, 0)

    def _row_in_force(self) -> GalleryRow | None:
        key = self._studio.environment.key
        return self.rows.get(key) or self.own_rows.get(self._own.path_of(key))

    def show_readiness(self) -> None:
        """Say which environments are still being prepared; a click on one does not put it in force."""
        for key, row in self.rows.items():
            row.set_waiting(readiness.WORDS.get(self._studio.readiness.state(key), ""))
        in_force = self._row_in_force()
        if in_force is not None:
            in_force.setChecked(True)

    def show_own(self) -> None:
        """Show the person's own environments as they now stand."""
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
                self.own_rows[path] = self._own_row(place, file)
        self.set_rail(self.rail)
        self.show_state()
        self.order()

    def order(self) -> None:
        """Let Tab go from the library over the own environments to the new one."""
        before: QWidget = list(self.rows.values())[-1]
        for row in self.own_rows.values():
            QWidget.setTabOrder(before, row)
            before = row
        QWidget.setTabOrder(before, self.new_row)

    def _share_height(self) -> None:
        """Give each row what there is; the way to a new one stays in sight, the list scrolls under it."""
        rows = (*self.rows.values(), *self.own_rows.values(), self.new_row)
        heading, own = (h.sizeHint().height() * (not h.isHidden()) for h in (self.heading, self.own_heading))
        least, most = (LEAST_RAIL_ROW, RAIL_ROW) if self.rail else (LEAST_ROW, ROW)
        above, seen = heading + own, len(rows)
        scrolls = self.height() - above < least * seen
        if scrolls:  # at its top the list ends with a whole row
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
        self._share_height()

    def _own_row(self, place: int, file) -> OwnRow:
        row = OwnRow(file)
        row.clicked.connect(lambda: self._choose_own(row))
        row.edit_pressed.connect(self.edit_pressed)
        row.reveal_pressed.connect(self.reveal_pressed)
        row.delete_pressed.connect(self.delete_pressed)
        self._group.addButton(row)
        self._own_column.insertWidget(place, row)
        return row

    def _choose_own(self, row: OwnRow) -> None:
        self._own.choose(row.file.path)
        self.show_state()

    def _arrange(self) -> None:
        body = QWidget(self.viewport())
        body.setObjectName("galleryBody")
        column = QVBoxLayout(body)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addWidget(self.heading)
        for key, row in self.rows.items():
            self._group.addButton(row)
            column.addWidget(row)
            row.clicked.connect(lambda _on=False, key=key: self._own.choose_built_in(key))
        column.addWidget(self.own_heading)
        self._own_column = QVBoxLayout()
        self._own_column.setSpacing(0)
        column.addLayout(self._own_column)
        column.addStretch(1)
        self.setWidget(body)
        self.new_row.clicked.connect(self.new_pressed)
