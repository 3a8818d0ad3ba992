"""The foot of the wizard: what Next means, Skip, Back and Next; after a failure Try again and Close."""

from PySide6.QtWidgets import QHBoxLayout, QLabel, QPushButton, QWidget

from hapkit_studio.gui.widgets.style import dress


class Foot(QWidget):
    """Try again and Close are there only while the board is not."""

    def __init__(self, parent: QWidget | None = None):
        super().__init__(parent)
        self.setObjectName("shellFoot")
        self.setFixedHeight(60)
        self.hint = QLabel()
        self.hint.setWordWrap(True)
        dress(self.hint, "QLabel { font-size: 13px; color: @ink2; }")
        self.skip, self.back, self.next = QPushButton("Skip"), QPushButton("Back"), QPushButton("Next")
        self.again, self.shut = QPushButton("Try again"), QPushButton("Close")
        row = QHBoxLayout(self)
        row.setContentsMargins(24, 0, 16, 0)
        row.setSpacing(10)
        row.addWidget(self.hint, 1)
        for button in (self.skip, self.back, self.next, self.again, self.shut):
            button.setProperty("tall", True)
            button.setAutoDefault(False)
            button.setMinimumWidth(96)
            row.addWidget(button)
        self.show_failed(False)

    def show_failed(self, failed: bool) -> None:
        """Offer the way on after a failure, or the steps again."""
        for button in (self.again, self.shut):
            button.setVisible(failed)
        for button in (self.skip, self.back, self.next):
            button.setVisible(not failed)
            button.setEnabled(not failed)
        if failed:
            self.hint.setText("Check the cable, then try again.")
            self.again.setFocus()
