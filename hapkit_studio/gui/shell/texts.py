"""Lists all texts that a student can see in the window, for proofreading.

Texts of widgets are read from a window without a device: all views, environments, dialogs and menus,
including hidden widgets. Texts that appear only after an event (a fault, a result, a refusal) are read from
the source, see :mod:`hapkit_studio.gui.shell.source_texts`. Each text is listed once, with the first place
that shows it; the option ``--json`` adds the source.

Left out are:

* keys, values, units and formulas alone ("Ctrl+S", "30 min", "N/m", "F = −k d in the wall"), file paths, and
  texts without a word;
* texts that differ from an earlier one only in their numbers;
* tooltips that repeat a label, and accessible names that only join visible texts and values;
* texts that depend on the student's own work: names of files, and the change that Undo would undo.
"""

import re
from collections.abc import Iterable, Iterator
from functools import cache
from typing import NamedTuple

from PySide6.QtCore import QAbstractListModel, QCoreApplication, QEvent, Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractItemView,
    QApplication,
    QCheckBox,
    QComboBox,
    QDialog,
    QFileDialog,
    QGroupBox,
    QLabel,
    QLineEdit,
    QMenu,
    QMenuBar,
    QTabBar,
    QWidget,
)

from hapkit_studio.devices import DeviceEntry
from hapkit_studio.gui import pages
from hapkit_studio.gui.shell.actions import new_window
from hapkit_studio.gui.shell.source_texts import messages, without_tags
from hapkit_studio.gui.shell.window import MainWindow
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.gui.teach import demos
from hapkit_studio.gui.widgets import style

TOOLTIP, NAME = "tooltip", "name for a screen reader"
_ROWS = 100  # maximum number of rows that are read from a table

# Maps the beginning of a module's path to the place where its texts are shown, in words that a student knows.
# The longest matching beginning applies; "" means the place of the widget's parent.
_PLACES = {
    "analysis": "experiments and results",
    "analysis/accuracy": "Speed and accuracy view",
    "analysis/bode": "Bode view",
    "analysis/calibrate": "Set up my Hapkit",
    "analysis/calibrate/checks": "Test my Hapkit",
    "analysis/failures": "Break it view",
    "analysis/identify": "Identify view",
    "analysis/perception": "Speed and accuracy view",
    "analysis/stability": "stability card and Stability view",
    "analysis/zwidth": "Z-width view",
    "charts": "chart",
    "charts/accuracy": "Speed and accuracy view, chart",
    "charts/bode": "Bode view, chart",
    "charts/experiments": "experiment, chart",
    "charts/failures": "Break it view, chart",
    "charts/identify": "Identify view, chart",
    "charts/stability": "Stability view, map",
    "charts/zwidth": "Z-width view, chart",
    "devices": "connection to the device",
    "devices/avrdude": "Flash firmware",
    "devices/flash": "Flash firmware",
    "devices/profiles": "Set up my Hapkit, list of kits",
    "environments": "description of a scene",
    "gui/editor": "law editor",
    "gui/live": "Live view",
    "gui/live/comparison": "comparison with a kept or recorded curve",
    "gui/live/replay": "replay of a recording",
    "gui/live/trigger": "Trigger settings",
    "gui/pages": "",
    "gui/pages/break_it": "Break it view",
    "gui/pages/lessons": "Lessons view",
    "gui/pages/open_recording": "Identify view, opening a table",
    "gui/pages/review": "review of a student's work",
    "gui/pages/stability": "Stability view",
    "gui/panel": "panel of settings",
    "gui/panel/loop": "panel of settings, loop",
    "gui/panel/rows": "",
    "gui/panel/rendering": "panel of settings, rendering",
    "gui/panel/stability_card": "panel of settings, stability card",
    "gui/scenes": "picture of the scene",
    "gui/shell": "window",
    "gui/shell/actions": "menu",
    "gui/shell/banners": "message across the window",
    "gui/shell/command_palette": "Find a command",
    "gui/shell/export_dialog": "Export for Arduino",
    "gui/shell/gallery": "list of scenes",
    "gui/shell/header": "header of the window",
    "gui/shell/notices": "message across the window",
    "gui/shell/portraits": "list of scenes",
    "gui/shell/projector_view": "projector view",
    "gui/shell/rail_names": "list of scenes",
    "gui/shell/status_bar": "status bar",
    "gui/state": "window",
    "gui/state/device_link": "connection to the device",
    "gui/state/own_environments": "environment of your own",
    "gui/state/presets": "presets",
    "gui/state/recording": "recording",
    "gui/teach": "teaching tools",
    "gui/teach/blind": "Compare A and B blind",
    "gui/teach/demo": "demo",
    "gui/teach/lock_dialog": "Lock settings",
    "gui/teach/pointing": "Experiment: pointing with friction",
    "gui/teach/quiz": "Quiz: find the hidden value",
    "gui/teach/threshold": "Experiment: just-noticeable difference",
    "gui/widgets": "",
    "gui/widgets/glossary": "glossary",
    "gui/wizard": "Set up my Hapkit",
    "gui/wizard/check": "Test my Hapkit",
    "gui/wizard/flash_dialog": "Flash firmware",
    "haptics": "control loop",
    "haptics/health": "fault",
    "haptics/priority": "Real-time priority",
    "haptics/realtime_linux": "Real-time priority",
    "laws": "law editor, error in a law",
    "lessons": "Lessons view",
    "sessions": "Sessions view",
    "workshop": "law editor, error in a file",
    "workshop/sketch": "Export for Arduino",
}
_NAMED = r"F\d+|Esc|Space|Backspace|Page (?:Up|Down)|Home|End|Left|Right|[Ww]heel|drag|[←→↑↓ ]+"
_KEY = rf"(?:(?:Ctrl|Shift|Alt)\+)*(?:\S|{_NAMED})"
_KEYS = re.compile(rf"^{_KEY}(?:(?:, | or ){_KEY})*$")
_UNIT = r"(?:mm|ms|min|N|m|s|g|kg|Hz|kHz|mJ|J|counts?|%|°|µs|µm|rad|periods?|[mNkgs]+[/·²³mskgN⁠]+|× ?\d*|JND)"
_VALUE = re.compile(rf"^[^A-Za-z]*{_UNIT}?(?: (?:±|to|/) [^A-Za-z]*{_UNIT}?)?$")
_FORMULA = re.compile(r"^[^.]{1,14}[=≤] (?!.*, with |.*[^\W\d]{3,} [^\W\d]{3,} [^\W\d]{3,})")
_OWN = re.compile(r"^Undo .+ → |^[/~]\S+$|^[A-Z]:\\|\.(?:toml|hks|py|ino|csv)$")


class Text(NamedTuple):
    """A text, the place in the window that shows it (with the kind of widget), and its source module."""

    place: str
    text: str
    source: str


def texts() -> list[Text]:
    """Return all texts that a student can see in the window."""
    application = QApplication.instance() or QApplication(["hapkit-studio"])
    assert isinstance(application, QApplication)
    style.apply(application)
    window = new_window(Studio(list[DeviceEntry]))
    found = [*_in_window(window), *_demos(), *_messages()]
    window.close()
    return shown(found)


def shown(found: Iterable[Text]) -> list[Text]:
    """Return the texts without repetitions and without those that say nothing by themselves."""
    tidied = [text._replace(text=" ".join(without_tags(text.text).split())) for text in found]
    tips = {text.text for text in tidied if text.place.endswith(TOOLTIP)}
    visible = {text.text.rstrip("…") for text in tidied if not text.place.endswith((TOOLTIP, NAME))}
    labels = sorted((label for label in visible if len(label) > 2), key=len, reverse=True)
    first: dict[str, Text] = {}
    for text in tidied:
        if text.place.endswith(TOOLTIP) and text.text in visible:
            continue
        key = text.text
        if text.place.endswith(NAME):
            key = "" if key in tips else re.sub(r",? (?:to )?[−+]?\d[\d.,]* ?\S*$", "", key)
            for label in labels:
                if label in key:
                    key = re.sub(rf"(?<!\w){re.escape(label)}(?!\w)", "", key)
            known = any(label.startswith(key.strip()) for label in labels)
            key = "" if known or not re.search(r"[A-Za-z]{3}", key) else f"name: {key}"
        if key and not _says_nothing(text.text):
            first.setdefault(re.sub(r"\d[\d,.]*", "0", key), text)
    return list(first.values())


def _says_nothing(text: str) -> bool:
    return not re.search(r"[A-Za-z]{2}", text) or any(
        pattern.search(text) for pattern in (_KEYS, _VALUE, _FORMULA, _OWN)
    )


def _in_window(window: MainWindow) -> Iterator[Text]:
    for action in window.actions():
        yield from _of_action("menu", action)
    for key, environment in window.studio.environments.items():
        window.studio.choose(key)
        _settle()
        yield from of_widgets(window, f"scene {environment.title}")
    for key, view in pages.discover().items():
        window.views.show(key)
        _settle()
        yield from of_widgets(window, f"{view.title} view")
    window.views.show("live")
    for action in window.findChildren(QAction):
        if action.text().endswith("…") and action.isEnabled():
            action.trigger()
            _settle()
            yield from _of_dialogs(action.text().rstrip("…"), window)
    window.show_keys()
    yield from _of_dialogs("Keys and glossary", window)


def _of_dialogs(place: str, window: MainWindow) -> Iterator[Text]:
    """Yield the texts of the visible dialogs, and close these dialogs."""
    for dialog in window.findChildren(QDialog):
        if dialog.isVisible():
            if isinstance(dialog, QFileDialog):
                yield Text(f"{place}: title", dialog.windowTitle(), _module(type(dialog)))
            else:
                yield from of_widgets(dialog, f"dialog {place}", fixed=True)
            dialog.close()
    _settle()


def of_widgets(top: QWidget, place: str, *, fixed: bool = False) -> Iterator[Text]:
    """Yield the texts of a widget and its children, including hidden ones.

    The place of a text follows from its widget's module. If this place is unknown or ``fixed`` is True, it is
    ``place``.
    """
    for widget in (top, *top.findChildren(QWidget)):
        where = place if fixed else _place_of(widget) or place
        for kind, text in _of_widget(widget):
            yield Text(f"{where}: {kind}", text, _module(type(widget)))
        for action in widget.actions():
            yield from _of_action("menu" if isinstance(widget, QMenuBar | QMenu) else where, action)


def _of_widget(widget: QWidget) -> Iterator[tuple[str, str]]:
    """Yield the kind and the words of each text of a widget."""
    match widget:
        case QLabel():
            yield "label", widget.text()
        case QCheckBox():
            yield "check box", widget.text()
        case QAbstractButton():
            yield "button", widget.text().replace("&", "")
        case QLineEdit():
            yield "hint in an empty field", widget.placeholderText()
        case QGroupBox():
            yield "heading", widget.title()
        case QComboBox():
            yield from (("choice", widget.itemText(index)) for index in range(widget.count()))
        case QTabBar():
            yield from (("tab", widget.tabText(index)) for index in range(widget.count()))
        case QAbstractItemView():
            yield from _of_table(widget)
    yield TOOLTIP, widget.toolTip()
    yield NAME, widget.accessibleName()


def _of_table(table: QAbstractItemView) -> Iterator[tuple[str, str]]:
    model = table.model()
    if model is None:
        return
    for column in range(1 if isinstance(model, QAbstractListModel) else model.columnCount()):
        for role, kind in (
            (Qt.ItemDataRole.DisplayRole, "column heading"),
            (Qt.ItemDataRole.ToolTipRole, TOOLTIP),
        ):
            yield kind, str(model.headerData(column, Qt.Orientation.Horizontal, role) or "")
        for row in range(min(_ROWS, model.rowCount())):
            yield "table", str(model.index(row, column).data() or "")
            yield TOOLTIP, str(model.index(row, column).data(Qt.ItemDataRole.ToolTipRole) or "")


def _of_action(place: str, action: QAction) -> Iterator[Text]:
    text = action.text().replace("&", "")
    yield Text(f"{place}: command", text, "gui/shell/actions")
    if action.toolTip() != text.rstrip("…"):
        yield Text(f"{place}: {TOOLTIP}", action.toolTip(), "gui/shell/actions")


def _demos() -> Iterator[Text]:
    for name, path in demos.shipped().items():
        for text in re.findall(r'caption = "(.+)"', path.read_text("utf-8")):
            yield Text("demo: caption", text, f"demos/{name}")


def _messages() -> Iterator[Text]:
    for module, line, text in messages():
        yield Text(f"{_place(module) or 'window'}: label or message", text, f"{module}.py:{line}")


def _place_of(widget: QWidget) -> str:
    """Return the place of a widget's module or of its nearest parent's module; "" if no place is known."""
    parent: QWidget | None = widget
    while parent is not None:
        if place := _place(_module(type(parent))):
            return place if place != _PLACES["gui/shell"] else ""
        parent = parent.parentWidget()
    return ""


def _module(of: object) -> str:
    """Return the module of a class or function, as a path below the package."""
    return of.__module__.removeprefix("hapkit_studio.").replace(".", "/")


@cache
def _places() -> dict[str, str]:
    """Return the places by module: the titles of the views, and _PLACES, which takes precedence."""
    return {_module(view.build): f"{view.title} view" for view in pages.discover().values()} | _PLACES


def _place(module: str) -> str:
    """Return the place of a module's texts in words that a student knows; "" if the module has no place."""
    begins = max((start for start in _places() if module.startswith(start)), key=len, default="")
    return _places().get(begins, "")


def _settle() -> None:
    QCoreApplication.processEvents()
    QCoreApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)
