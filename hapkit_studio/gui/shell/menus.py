"""The menu bar with all actions, the devices found, and the user's own environments."""

from functools import partial

from PySide6.QtGui import QAction
from PySide6.QtWidgets import QMenu, QMenuBar

from hapkit_studio.gui.shell.action_set import ActionSet
from hapkit_studio.gui.shell.header import fill_menu
from hapkit_studio.gui.state.own_environments import OwnEnvironments
from hapkit_studio.gui.state.studio import Studio


def build_menus(bar: QMenuBar, actions: ActionSet, studio: Studio, own: OwnEnvironments) -> None:
    """Fill the menu bar in the order of the action table."""
    menus: dict[str, QMenu] = {}
    for entry in actions.entries:
        menu = _menu(bar, menus, entry.menu)
        if entry.rule:
            menu.addSeparator()
        menu.addAction(actions.qt[entry.key])
    for menu in menus.values():
        menu.aboutToShow.connect(actions.refresh)
    _add_devices(menus["Device"], studio)
    _add_own(menus["Environment"], actions.qt["environment.new"], own)


def _menu(bar: QMenuBar, menus: dict[str, QMenu], path: str) -> QMenu:
    if path not in menus:
        parent, _, name = path.rpartition("/")
        menus[path] = _menu(bar, menus, parent).addMenu(name) if parent else bar.addMenu(path)
    return menus[path]


def _add_devices(menu: QMenu, studio: Studio) -> None:
    choose = QMenu("Choose device", menu)
    choose.aboutToShow.connect(lambda: fill_menu(choose, studio))
    first = menu.actions()[0]
    menu.insertMenu(first, choose)
    menu.insertSeparator(first)


def _add_own(menu: QMenu, before: QAction, own: OwnEnvironments) -> None:
    yours = QMenu("Your own", menu)
    entry = menu.insertMenu(before, yours)

    def fill() -> None:
        yours.clear()
        for file in own.files:
            yours.addAction(file.title, partial(own.choose, file.path))
        entry.setVisible(bool(own.files))

    menu.aboutToShow.connect(fill)
    fill()
