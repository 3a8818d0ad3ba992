"""Building blocks of pages and dialogs: rows, columns, labels, signs, and a line with an answer."""

from collections.abc import Callable, Iterable, Iterator
from typing import TypeVar

from PySide6.QtCore import QCoreApplication, QDir, QEvent, QObject, QPoint, Qt
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import (
    QBoxLayout,
    QFileDialog,
    QFrame,
    QHBoxLayout,
    QLabel,
    QLayout,
    QPushButton,
    QScrollArea,
    QVBoxLayout,
    QWidget,
)

from hapkit_studio.formatting import printable, unbroken
from hapkit_studio.gui.widgets import icons
from hapkit_studio.gui.widgets.style import mark
from hapkit_studio.gui.widgets.theme import theme

Part = QWidget | QLayout | int | tuple[QWidget | QLayout, int] | None
Margins = tuple[int, int, int, int]
_Box = TypeVar("_Box", bound=QBoxLayout)
# px: narrower answers have smaller letters. Answers are 240 px wide in the narrow panel, and 268 px
# otherwise.
_NARROW_ANSWERS = 256


def hbox(
    *parts: Part, into: QWidget | None = None, margins: Margins = (0, 0, 0, 0), gap: int = 8
) -> QHBoxLayout:
    """Return a row of widgets. A number is a space in px, None a stretch, (part, n) a part with stretch n.

    ``into`` is the widget that gets the layout.
    """
    return _filled(QHBoxLayout(into) if into else QHBoxLayout(), parts, margins, gap)


def vbox(
    *parts: Part, into: QWidget | None = None, margins: Margins = (0, 0, 0, 0), gap: int = 0
) -> QVBoxLayout:
    """Return a column of widgets; the arguments are those of ``hbox``."""
    return _filled(QVBoxLayout(into) if into else QVBoxLayout(), parts, margins, gap)


def _filled(box: _Box, parts: tuple[Part, ...], margins: Margins, gap: int) -> _Box:
    box.setContentsMargins(*margins)
    box.setSpacing(gap)
    for part in parts:
        item, stretch = part if isinstance(part, tuple) else (part, 0)
        if isinstance(item, QWidget):
            box.addWidget(item, stretch)
        elif isinstance(item, QLayout):
            box.addLayout(item, stretch)
        elif item is None:
            box.addStretch(1)
        else:
            box.addSpacing(item)
    return box


def refill(box: QBoxLayout, parts: Iterable[QWidget]) -> None:
    """Replace the widgets of a row or column and delete the old ones."""
    while item := box.takeAt(0):
        if old := item.widget():
            old.hide()
            old.deleteLater()
    for part in parts:
        box.addWidget(part)


class Words(QLabel):
    """A label that does not wrap between a number and its unit, nor within a unit.

    ``text`` returns the text as it was set, without the non-breaking characters.
    """

    def __init__(self, text: str):
        super().__init__(textFormat=Qt.TextFormat.PlainText)
        self.setText(text)

    def setText(self, text: str) -> None:
        self._text = text
        super().setText(unbroken(printable(text)))

    def text(self) -> str:
        return self._text


def label(text: str = "", role: str = "", wrap: bool = True) -> QLabel:
    """Return a plain-text label with a style-sheet role."""
    made = Words(text)
    made.setWordWrap(wrap)
    made.setProperty("role", role)
    return made


def hint(text: str = "") -> QLabel:
    """Return a label in the style of a hint."""
    return label(text, "hint")


def rule() -> QFrame:
    """Return a thin horizontal line."""
    line = QFrame()
    line.setProperty("rule", True)
    line.setFixedHeight(1)
    return line


def lay_out(area: QScrollArea) -> None:
    """Update the layout of a scroll area immediately, so that a longer text is complete in the next frame."""
    for part in (*reversed(area.findChildren(QWidget)), area):
        if part is area or part.layout() is not None:
            QCoreApplication.sendEvent(part, QEvent(QEvent.Type.LayoutRequest))


def keep_size_when_hidden(widget: QWidget) -> None:
    """Reserve a hidden widget's space, so that no other widget moves when it appears."""
    policy = widget.sizePolicy()
    policy.setRetainSizeWhenHidden(True)
    widget.setSizePolicy(policy)


class Sign(QLabel):
    """An icon in the colour of a token; without a name it is empty."""

    def __init__(self, size: int = 18, name: str = "", token: str = "ink2"):
        super().__init__()
        self.size_px, self.name, self.token = size, name, token
        theme.changed.connect(self._paint)
        self._paint()

    def show_sign(self, name: str, token: str) -> None:
        """Show an icon by its name."""
        self.name, self.token = name, token
        self._paint()

    def _paint(self) -> None:
        if self.name:
            size = theme.px(self.size_px)
            self.setPixmap(icons.pixmap(self.name, size, self.token, self.devicePixelRatioF()))
        else:
            self.clear()


class AnswerLine(QWidget):
    """A sign and one sentence with the answer; before there is an answer, the sentence is an instruction."""

    def __init__(self, text: str = "", margins: Margins = (0, 0, 0, 0)):
        super().__init__()
        self.sign, self.label = Sign(), label(role="headline")
        hbox(self.sign, (self.label, 1), into=self, margins=margins)
        self.show_text(text)

    def show_text(self, text: str, sign: str = "circle", token: str = "ink2") -> None:
        """Show a text with a sign; the default sign is neutral."""
        self.label.setText(text)
        self.sign.show_sign(sign, token)


class AnswerLines(QWidget):
    """Shows one answer per line, each with a sign; warnings and dangers are coloured."""

    def __init__(self) -> None:
        super().__init__()
        self.lines: list[AnswerLine] = []
        self._column = vbox(into=self, gap=4)

    @property
    def text(self) -> str:
        """Return the texts, separated by line breaks."""
        return "\n".join(line.label.text() for line in self.lines if not line.isHidden())

    def show_text(self, *answers: tuple[str, str, str]) -> None:
        """Show answers, each with its sign and token."""
        while len(self.lines) < len(answers):
            self.lines.append(AnswerLine())
            self._column.addWidget(self.lines[-1])
        for line, (text, sign, token) in zip(self.lines, answers, strict=False):
            line.show_text(text, sign, token)
            mark(line.label, "ink", token if token in ("danger", "warn") else "ink")
        for at, line in enumerate(self.lines):
            line.setVisible(at < len(answers))
        self._fit()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()

    def _fit(self) -> None:
        """Use smaller letters in the panel of a small window, so that most answers need only two lines."""
        narrow = self.width() < theme.px(_NARROW_ANSWERS)
        for line in self.lines:
            mark(line.label, "role", "strong" if narrow else "headline")
            line.layout().setSpacing(2 if narrow else 8)  # type: ignore[union-attr]


def rows_of(column: QWidget) -> Iterator[QWidget]:
    """Yield the visible widgets of a column, including those of each column or form inside."""
    for part in column.findChildren(QWidget, options=Qt.FindChildOption.FindDirectChildrenOnly):
        if part.isVisibleTo(column):
            if isinstance(part.layout(), QVBoxLayout) or part.property("form"):
                yield from rows_of(part)
            else:
                yield part


SIDE = 16


class ScrollColumn(QScrollArea):
    """A scrolling column. The scroll bar is in the column's margin, so that showing it moves no widget.

    A row that the bottom edge cuts is hidden, unless it is at least half as tall as the view.
    """

    def __init__(self, top: int = 12, gap: int = 8):
        super().__init__()
        self.setObjectName("panel")
        self.setWidgetResizable(True)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.body = QWidget(self.viewport())
        self.body.setObjectName("panelBody")
        self.setVerticalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOn)
        bar = self.verticalScrollBar()
        bar.ensurePolished()  # the bar's width comes from the style sheet
        beside = max(SIDE - bar.sizeHint().width(), 0)
        self.column = vbox(None, into=self.body, margins=(SIDE, top, beside, top), gap=gap)
        self._cover = QWidget(self)
        self._cover.setObjectName("panelBody")
        self._cover.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.setWidget(self.body)
        bar.rangeChanged.connect(self._show_bar_if_needed)
        bar.valueChanged.connect(self._cover_cut_row)

    def _show_bar_if_needed(self, _low: int, high: int) -> None:
        self.verticalScrollBar().setEnabled(high > 0)  # a disabled scroll bar is invisible

    def add(self, *parts: QWidget) -> None:
        """Add widgets at the bottom."""
        for part in parts:
            self.column.insertWidget(self.column.count() - 1, part)

    def reveal(self, part: QWidget) -> None:
        """Scroll to a widget that has just grown, to show as much of it as possible."""
        grown: QWidget | None = part
        while grown is not None and grown is not self:  # lay out now, because the sizes are needed below
            QCoreApplication.sendEvent(grown, QEvent(QEvent.Type.LayoutRequest))
            grown = grown.parentWidget()
        bar, top = self.verticalScrollBar(), part.mapTo(self.body, QPoint()).y()
        bottom = top + part.height() + self.column.contentsMargins().bottom()
        bar.setValue(max(bar.value(), min(top, bottom - self.viewport().height())))

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Cover a row that is only partly visible after the column or one of its rows has been resized."""
        done = super().eventFilter(watched, event)
        if event.type() in (QEvent.Type.Resize, QEvent.Type.LayoutRequest):
            self._cover_cut_row()
        return done

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._cover_cut_row()

    def _cover_cut_row(self) -> None:
        """Cover a row that the bottom edge cuts, and a dividing line directly above covered rows."""
        view = self.viewport()
        end = edge = self.verticalScrollBar().value() + view.height()
        spans = [(part.mapTo(self.body, QPoint()).y(), part.height()) for part in rows_of(self.body)]
        for top, height in sorted(spans, key=sum, reverse=True):
            cut = edge < top + height < top + view.height() / 2
            if top < edge and (cut or height == 1):
                edge = top
            elif top < edge:
                break
        self._cover.setGeometry(0, view.height() - end + edge, view.width(), end - edge)


def primary(button: QPushButton) -> QPushButton:
    """Style a button as the primary button of its window."""
    button.setProperty("primary", True)
    return button


def choose_file(
    parent: QWidget,
    title: str,
    kinds: str,
    then: Callable[[str], object],
    save_as: str = "",
    folder: bool = False,
) -> QFileDialog:
    """Open a non-modal file dialog.

    ``save_as`` is the proposed name of a file to be saved. If ``folder`` is True, the user chooses a folder.
    """
    dialog = QFileDialog(parent, title, QDir.homePath(), kinds)
    modes = QFileDialog.FileMode
    dialog.setFileMode(modes.Directory if folder else modes.AnyFile if save_as else modes.ExistingFile)
    if save_as:
        dialog.setAcceptMode(QFileDialog.AcceptMode.AcceptSave)
        dialog.setDefaultSuffix(save_as.rpartition(".")[2])
        dialog.filterSelected.connect(lambda kind: dialog.setDefaultSuffix(kind.split("*.")[1][:-1]))
        dialog.selectFile(save_as)
    dialog.fileSelected.connect(then)
    dialog.setModal(False)
    dialog.finished.connect(dialog.deleteLater)
    dialog.show()
    return dialog
