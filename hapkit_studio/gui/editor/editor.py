"""The editor, a card in the plots' place: a page for what is new, for code, for a stranger's source."""

from collections.abc import Sequence

from PySide6.QtWidgets import QFrame, QStackedWidget, QVBoxLayout, QWidget

from hapkit_studio.gui.dress import dress
from hapkit_studio.gui.editor.chooser import Chooser
from hapkit_studio.gui.editor.code_page import CodePage
from hapkit_studio.gui.editor.source_page import SourcePage
from hapkit_studio.workshop.templates import Template

_SHEET = """
#code {
  background: @surface; color: @ink;
  selection-background-color: @accent; selection-color: @onaccent;
}
#code::corner { background: @surface; }
"""


class Editor(QFrame):
    """Shows one page at a time."""

    def __init__(self, templates: Sequence[Template], parent: QWidget | None = None):
        super().__init__(parent)
        self.setProperty("card", True)
        self.chooser, self.page, self.source = Chooser(templates), CodePage(), SourcePage()
        dress(self, _SHEET)
        self.stack = QStackedWidget(self)
        for page in (self.chooser, self.page, self.source):
            self.stack.addWidget(page)
        column = QVBoxLayout(self)
        column.setContentsMargins(1, 1, 1, 1)
        column.addWidget(self.stack)

    def show_page(self, page: QWidget) -> None:
        """Bring one of the three to the front."""
        self.stack.setCurrentWidget(page)

    def shows(self, page: QWidget) -> bool:
        """Say whether one of the three is in front."""
        return self.stack.currentWidget() is page
