"""Banners under the header: what is wrong, and what to do about it."""

from collections.abc import Callable
from dataclasses import dataclass

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget

from hapkit_studio.gui.widgets import icons
from hapkit_studio.gui.widgets.text import plain
from hapkit_studio.gui.widgets.theme import theme

HEIGHT = 54
MOST = 2

Button = tuple[str, Callable[[], object]]


@dataclass(frozen=True)
class Notice:
    """One banner; the lower rank stands above. tone is danger or warn."""

    key: str
    rank: int
    tone: str
    icon: str
    title: str
    text: str
    buttons: tuple[Button, ...] = ()


class Banner(QWidget):
    """Sign, title, one line, buttons."""

    def __init__(self, notice: Notice, parent: QWidget | None = None):
        super().__init__(parent)
        self.notice = notice
        self.setObjectName("banner")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.setFixedHeight(HEIGHT)
        self.setProperty("tone", notice.tone)
        self.sign = QLabel()
        self.sign.setPixmap(icons.pixmap(notice.icon, 24, notice.tone, self.devicePixelRatioF()))
        self.title, self.text = plain(QLabel()), plain(QLabel())
        self.title.setFont(theme.font("banner"))
        self.text.setWordWrap(True)
        self.buttons = [self._button(at, words) for at, (words, _) in enumerate(notice.buttons)]
        self._arrange()
        self.say(notice)

    def fits(self, notice: Notice) -> bool:
        """Tell whether a notice differs in words only: it is then shown without a flicker."""
        mine, other = (
            (n.key, n.rank, n.tone, n.icon, [words for words, _ in n.buttons]) for n in (self.notice, notice)
        )
        return mine == other

    def say(self, notice: Notice) -> None:
        """Show the words of a notice that fits."""
        self.notice = notice
        self.title.setText(notice.title)
        self.text.setText(notice.text)
        self.setAccessibleName(f"{notice.title} {notice.text}")

    def _arrange(self) -> None:
        words = QVBoxLayout()
        words.setSpacing(1)
        words.addStretch(1)
        words.addWidget(self.title)
        words.addWidget(self.text)
        words.addStretch(1)
        row = QHBoxLayout(self)
        row.setContentsMargins(14, 0, 12, 0)
        row.setSpacing(12)
        row.addWidget(self.sign)
        row.addLayout(words, 1)
        for button in self.buttons:
            row.addWidget(button)

    def _button(self, at: int, words: str) -> QPushButton:
        button = QPushButton(words)
        button.setProperty("tall", True)
        # it goes away when clicked, and must not take the focus along
        button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        button.clicked.connect(lambda: self.notice.buttons[at][1]())
        return button


class BannerStack(QWidget):
    """At most two banners, the worse first; empty it takes no room. ``changed``: another number of them."""

    changed = Signal()

    def __init__(self, parent: QWidget | None = None):
        super().__init__(parent)
        self._notices: dict[str, Notice] = {}
        self.banners: list[Banner] = []
        self._column = QVBoxLayout(self)
        self._column.setContentsMargins(0, 0, 0, 0)
        self._column.setSpacing(0)
        theme.changed.connect(self._rebuild)
        self.hide()

    def set(self, key: str, notice: Notice | None) -> None:
        """Put up, change or take down the banner of a key."""
        if self._notices.get(key) == notice:
            return
        if notice is None:
            self._notices.pop(key, None)
        else:
            self._notices[key] = notice
        worst = self._worst()
        pairs = list(zip(self.banners, worst, strict=False))
        if len(self.banners) == len(worst) and all(banner.fits(shown) for banner, shown in pairs):
            for banner, shown in pairs:
                banner.say(shown)
        else:
            self._rebuild()

    def get(self, key: str) -> Notice | None:
        """Return the notice of a key, shown or waiting behind worse ones."""
        return self._notices.get(key)

    def _worst(self) -> list[Notice]:
        return sorted(self._notices.values(), key=lambda notice: notice.rank)[:MOST]

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
