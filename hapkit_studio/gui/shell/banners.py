"""Banners below the header. Each shows a problem and its remedy."""

from collections.abc import Callable
from dataclasses import dataclass

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QPushButton, QWidget

from hapkit_studio.gui.widgets import breakpoints
from hapkit_studio.gui.widgets.parts import Sign, hbox, label, vbox
from hapkit_studio.gui.widgets.theme import theme

Button = tuple[str, Callable[[], object]]


@dataclass(frozen=True)
class Notice:
    """One banner; the banner with the lowest rank is shown first. ``tone`` is danger, warn or accent."""

    key: str
    rank: int
    tone: str
    icon: str
    title: str
    text: str
    buttons: tuple[Button, ...] = ()

    @property
    def shape(self) -> tuple:
        """Return every field except the texts.

        A banner is rebuilt only if this value changes, because rebuilding makes the banner flicker.
        """
        return self.key, self.rank, self.tone, self.icon, [text for text, _ in self.buttons]


class Banner(QWidget):
    """A banner with a sign, a title, one line of text and buttons."""

    def __init__(self, notice: Notice, parent: QWidget | None = None):
        super().__init__(parent)
        self.notice = notice
        self.setObjectName("banner")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.setFixedHeight(theme.px(breakpoints.BANNER_HEIGHT))
        self.setProperty("tone", notice.tone)
        self.title, self.text = label(wrap=False), label()
        self.title.setFont(theme.font("banner"))
        self.buttons = [self._button(at, text) for at, (text, _) in enumerate(notice.buttons)]
        column = vbox(None, self.title, self.text, None, gap=1)
        sign = Sign(24, notice.icon, notice.tone)
        hbox(sign, (column, 1), *self.buttons, into=self, margins=(14, 0, 12, 0), gap=12)
        self.show_notice(notice)

    def show_notice(self, notice: Notice) -> None:
        """Show the texts of another notice with the same ``shape``."""
        self.notice = notice
        self.title.setText(notice.title)
        self.text.setText(notice.text)
        self.setAccessibleName(f"{notice.title} {notice.text}")

    def _button(self, at: int, text: str) -> QPushButton:
        button = QPushButton(text)
        button.setProperty("tall", True)
        # a click must not move the focus to this button, because the button disappears after the click
        button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        button.clicked.connect(lambda: self.notice.buttons[at][1]())
        return button


class BannerStack(QWidget):
    """Shows at most two banners, the most important one first.

    ``changed`` is emitted when the number of banners has changed.
    """

    changed = Signal()

    def __init__(self, parent: QWidget | None = None):
        super().__init__(parent)
        self._notices: dict[str, Notice] = {}
        self.banners: list[Banner] = []
        self._column = vbox(into=self)
        theme.changed.connect(self._rebuild)
        self.hide()

    def set(self, key: str, notice: Notice | None) -> None:
        """Add or change the banner with a key; None removes it."""
        if self._notices.get(key) == notice:
            return
        if notice is None:
            self._notices.pop(key, None)
        else:
            self._notices[key] = notice
        worst = self._worst()
        if [banner.notice.shape for banner in self.banners] == [shown.shape for shown in worst]:
            for banner, shown in zip(self.banners, worst, strict=True):
                banner.show_notice(shown)
        else:
            self._rebuild()

    def warn(self, key: str, title: str, text: str, rank: int = 9) -> None:
        """Add a warning with a Close button."""
        close = ("Close", lambda: self.set(key, None))
        self.set(key, Notice(key, rank, "warn", "triangle", title, text, (close,)))

    def get(self, key: str) -> Notice | None:
        """Return the notice with a key; it may be hidden because more important banners are shown."""
        return self._notices.get(key)

    def _worst(self) -> list[Notice]:
        return sorted(self._notices.values(), key=lambda notice: notice.rank)[: breakpoints.BANNERS]

    def _rebuild(self) -> None:
        before = len(self.banners)
        for banner in self.banners:
            self._column.removeWidget(banner)
            banner.hide()
            banner.deleteLater()
        self.banners = [Banner(notice) for notice in self._worst()]
        for banner in self.banners:
            self._column.addWidget(banner)
        self.setVisible(bool(self.banners))
        if len(self.banners) != before:
            self.changed.emit()
