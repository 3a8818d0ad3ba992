"""Lists all texts of the window: those of all widgets in all views and dialogs, and all messages.

Texts of widgets are read from a window without a device. A text that appears only after an event (a fault, a
result, a refusal) is read from the program's source, with its values in braces.
"""

import ast
import re
from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path
from typing import NamedTuple

from PySide6.QtCore import QCoreApplication, QEvent
from PySide6.QtGui import QAction
from PySide6.QtWidgets import (
    QAbstractButton,
    QApplication,
    QComboBox,
    QDialog,
    QFileDialog,
    QGroupBox,
    QLabel,
    QLineEdit,
    QTabBar,
    QWidget,
)

from hapkit_studio.devices import DeviceEntry
from hapkit_studio.gui import pages
from hapkit_studio.gui.shell.actions import new_window
from hapkit_studio.gui.shell.window import MainWindow
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.gui.teach import demos
from hapkit_studio.gui.widgets import style

_WORDS = re.compile(r"[A-Za-z]{2,}[^A-Za-z]* [^A-Za-z]*[A-Za-z]{2,}")
_NO_TEXT = re.compile(r"[{;]\s*\w+-?\w*:|^[#&./<]|::|^from |^import |^def |^return |\| None|\n.*\n")
_FOLDERS = ("gui", "analysis", "charts", "haptics", "devices", "environments", "laws", "sessions", "workshop")


class Text(NamedTuple):
    """A text and where it is shown: a view, a dialog, or the source file of a message."""

    place: str
    words: str


def texts() -> list[Text]:
    """Return all texts of the window, each with the first place that shows it."""
    application = QApplication.instance() or QApplication(["hapkit-studio"])
    assert isinstance(application, QApplication)
    style.apply(application)
    window = new_window(Studio(list[DeviceEntry]))
    found = [*_in_window(window), *_demos(), *messages()]
    window.close()
    first: dict[str, str] = {}
    for place, words in found:
        first.setdefault(" ".join(words.split()), place)
    return [Text(place, words) for words, place in first.items() if re.search(r"[A-Za-z]{2}", words)]


def _in_window(window: MainWindow) -> Iterator[Text]:
    for action in window.actions():
        yield from _of_action("menu", action)
    for key, environment in window.studio.environments.items():
        window.studio.choose(key)
        _settle()
        yield from _of_widgets(environment.title, window)
    for key, view in pages.discover().items():
        window.views.show(key)
        _settle()
        yield from _of_widgets(view.title, window)
    window.views.show("live")
    for action in window.findChildren(QAction):
        if action.text().endswith("…") and action.isEnabled():
            action.trigger()
            _settle()
            yield from _of_dialogs(action.text(), window)
    window.show_keys()
    yield from _of_dialogs("Keys", window)


def _of_dialogs(place: str, window: MainWindow) -> Iterator[Text]:
    """Yield the texts of the visible dialogs, and close these dialogs."""
    for dialog in window.findChildren(QDialog):
        if dialog.isVisible():
            if isinstance(dialog, QFileDialog):
                yield Text(place, dialog.windowTitle())
            else:
                yield from _of_widgets(place, dialog)
            dialog.close()
    _settle()


def _of_widgets(place: str, top: QWidget) -> Iterator[Text]:
    """Yield texts, tooltips and accessible names of a widget and its children, including hidden ones."""
    for widget in (top, *top.findChildren(QWidget)):
        if isinstance(widget, QLabel | QAbstractButton | QLineEdit):
            yield Text(place, re.sub(r"<[^>]+>", "", widget.text()))
        if isinstance(widget, QLineEdit):
            yield Text(place, widget.placeholderText())
        if isinstance(widget, QGroupBox):
            yield Text(place, widget.title())
        if isinstance(widget, QComboBox):
            yield from (Text(place, widget.itemText(index)) for index in range(widget.count()))
        if isinstance(widget, QTabBar):
            yield from (Text(place, widget.tabText(index)) for index in range(widget.count()))
        yield Text(f"{place}, tooltip", widget.toolTip())
        yield Text(f"{place}, accessible name", widget.accessibleName())
        for action in widget.actions():
            yield from _of_action(place, action)


def _of_action(place: str, action: QAction) -> Iterator[Text]:
    yield Text(place, action.text().replace("&", ""))
    if action.toolTip() != action.text():
        yield Text(f"{place}, tooltip", action.toolTip())


def _demos() -> Iterator[Text]:
    for name, path in demos.shipped().items():
        for words in re.findall(r'caption = "(.+)"', path.read_text("utf-8")):
            yield Text(f"demo {name}", words)


def messages() -> Iterator[Text]:
    """Yield texts of several words from the source, except docstrings and style sheets."""
    top = Path(str(files("hapkit_studio")))
    for path in sorted(path for folder in _FOLDERS for path in (top / folder).rglob("*.py")):
        tree = ast.parse(path.read_text("utf-8"))
        nodes = list(ast.walk(tree))
        parts = {id(part) for node in nodes if isinstance(node, ast.JoinedStr) for part in node.values}
        docs = {id(node.value) for node in nodes if isinstance(node, ast.Expr)}
        for node in nodes:
            if id(node) not in parts | docs and (words := _literal(node)):
                yield Text(f"{path.relative_to(top)}:{node.lineno}", words)  # type: ignore[attr-defined]


def _literal(node: ast.AST) -> str:
    """Return a literal's text with its values in braces; "" if it is not a text of several words."""
    words = ""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        words = node.value
    elif isinstance(node, ast.JoinedStr):
        for part in node.values:
            value = part.value  # type: ignore[attr-defined]
            words += str(value) if isinstance(part, ast.Constant) else f"{{{ast.unparse(value)}}}"
    bare = re.sub(r"\{[^}]*\}", "Xx", words)
    return words if _WORDS.search(bare) and not _NO_TEXT.search(bare) else ""


def _settle() -> None:
    QCoreApplication.processEvents()
    QCoreApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)
