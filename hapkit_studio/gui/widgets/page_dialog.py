"""A documentation page in a dialog next to the window."""

from PySide6.QtGui import QShowEvent, QTextBlockFormat, QTextCursor, QTextFormat, QTextTable
from PySide6.QtWidgets import QLineEdit, QTextBrowser, QWidget

from hapkit_studio.gui.widgets.dialogs import TextDialog
from hapkit_studio.gui.widgets.parts import hbox
from hapkit_studio.gui.widgets.theme import theme

_WIDE, _HIGH = 860, 480  # px: size of the dialog
_BESIDE = 200  # px: height of the dialog's other widgets and of the header of a small window
_AROUND = 60  # px: width of the dialog's margins and of its surroundings
_MARGIN, _PADDING, _ABOVE_HEADING, _APART = 12, 4, 18, 8


class PageDialog(TextDialog):
    """A documentation page with a search field; it opens at a section or at a word's first occurrence."""

    def __init__(
        self, title: str, text: str, parent: QWidget | None = None, word: str = "", section: str = ""
    ):
        """``text`` is Markdown without the page's title."""
        super().__init__(title, parent)
        self.field = QLineEdit(placeholderText="Find a word in this page")
        self.field.setAccessibleName("Find in this page")
        self.page = QTextBrowser()
        self.page.setAccessibleName(title)
        self.page.setOpenExternalLinks(True)
        self.page.setMarkdown(text)
        self.page.document().setDocumentMargin(_MARGIN)
        wide, high = theme.px(_WIDE), theme.px(_HIGH)
        if parent is not None:
            room = parent.window().size()
            wide, high = min(wide, room.width() - _AROUND), min(high, room.height() - theme.px(_BESIDE))
        self.page.setMinimumSize(wide, high)
        self.field.textChanged.connect(self.find_first)
        self.field.returnPressed.connect(self.find_next)
        theme.changed.connect(self._format)
        self.leave.setAutoDefault(False)  # Enter starts a search and must not close the dialog
        self.column.addWidget(self.field)
        self.column.addWidget(self.page)
        self.column.addLayout(hbox(None, self.leave))
        self._section = section
        self._format()
        self.field.setText(word)

    def showEvent(self, event: QShowEvent) -> None:
        """Scroll to the section, whose position depends on the page's final width."""
        super().showEvent(event)
        document = self.page.document()
        block = document.begin()
        while self._section and block.isValid():
            if block.blockFormat().headingLevel() and block.text() == self._section:
                top = document.documentLayout().blockBoundingRect(block).top()
                self.page.verticalScrollBar().setValue(round(top) - _PADDING)
                return
            block = block.next()

    def find_first(self, word: str) -> None:
        """Select the first occurrence of a word, if the page contains this word."""
        self.page.moveCursor(QTextCursor.MoveOperation.Start)
        self.page.find(word)

    def find_next(self) -> None:
        """Select the next occurrence; after the last one, start again at the top."""
        if not self.page.find(self.field.text()):
            self.find_first(self.field.text())

    def _format(self) -> None:
        """Format headings, code and tables in the theme's colours."""
        document, was_code = self.page.document(), False
        block = document.begin()
        while block.isValid():
            form, found = QTextBlockFormat(), block.blockFormat()
            is_code = found.hasProperty(QTextFormat.Property.BlockCodeLanguage)
            if found.headingLevel():
                form.setTopMargin(_ABOVE_HEADING)
                form.setBottomMargin(_APART)
            elif is_code != was_code:
                form.setTopMargin(_APART)
            if is_code:
                form.setNonBreakableLines(False)  # in a small window a long line is wrapped, not cut off
                form.setBackground(theme.color("side"))
            QTextCursor(block).mergeBlockFormat(form)
            block, was_code = block.next(), is_code
        for frame in document.rootFrame().childFrames():
            if isinstance(frame, QTextTable):
                table = frame.format()
                table.setBorderBrush(theme.color("line"))
                table.setBorderCollapse(True)
                table.setCellPadding(_PADDING)
                frame.setFormat(table)
