"""The panel's row for presets, with a menu that saves, restores, compares and imports presets."""

from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import partial
from pathlib import Path

from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QCheckBox, QComboBox, QLineEdit, QMenu, QPushButton, QWidget

from hapkit_studio.errors import ParameterError
from hapkit_studio.formatting import printable
from hapkit_studio.gui.panel.differences import DifferenceTable
from hapkit_studio.gui.state import presets
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.gui.state.undo import (
    ENVIRONMENT,
    Difference,
    Snapshot,
    UndoHistory,
    differences,
    differing,
    put,
    settings_of,
    settings_of_scene,
)
from hapkit_studio.gui.widgets.dialogs import FormDialog, text_dialog
from hapkit_studio.gui.widgets.parts import choose_file, hbox, label
from hapkit_studio.gui.widgets.text import plain_tip

_MOST_LINES = 12
DEFAULTS, OWN = "Default values", "Your own values"
_ABOUT = "Saves the values of the scene {} under a name, in a file that others can import."


class Presets(QObject):
    """Applies, saves and compares presets; each change is one undo step.

    ``changed`` is emitted when another preset was applied.
    """

    changed = Signal()

    def __init__(self, studio: Studio, history: UndoHistory, window: QWidget):
        super().__init__(window)
        self._studio, self._history, self._window = studio, history, window
        self._chosen: dict[str, tuple[str, Snapshot]] = {}

    @property
    def chosen(self) -> str:
        """Return the name of the preset chosen last for the current environment; "" if none was chosen."""
        return self._chosen.get(self._studio.environment.key, ("", {}))[0]

    @property
    def different(self) -> Snapshot:
        """Return the settings of the preset chosen last that differ from the current ones."""
        return differing(self._studio, self._chosen.get(self._studio.environment.key, ("", {}))[1])

    @property
    def names(self) -> dict[str, str]:
        """Return the name of the preset chosen last for each environment."""
        return {key: name for key, (name, _) in self._chosen.items()}

    def remember(self, names: Mapping[str, object]) -> None:
        """Restore the names of the presets chosen last, without applying them."""
        for key in names.keys() & self._studio.environments.keys():
            path = presets.found(key).get(str(names[key]))
            with suppress(ParameterError):  # the preset's file was damaged meanwhile
                if path is not None:
                    self._chosen[key] = path.stem, presets.read(path, self._studio.environments)
        self.changed.emit()

    def compared(self, path: Path) -> list[Difference]:
        """Return the settings that a preset would change; raise PresetError if its file is invalid."""
        settings = presets.read(path, self._studio.environments)
        return differences(self._studio, settings_of(self._studio), settings)

    def apply(self, path: Path) -> Snapshot:
        """Apply a preset and return its settings; if it is refused, show its errors and return {}."""
        try:
            settings = presets.read(path, self._studio.environments)
            self._put(printable(path.stem), settings)
        except ParameterError as error:
            lines = str(error).splitlines()
            more = (
                [f"{len(lines) - _MOST_LINES} more errors are not shown."] if len(lines) > _MOST_LINES else []
            )
            self._show_message(f"Preset {path.stem[:40]} not applied", [*lines[:_MOST_LINES], *more])
            return {}
        return settings

    def restore(self) -> None:
        """Restore the settings of the preset that was chosen last."""
        try:
            self._put(*self._chosen[self._studio.environment.key])
        except ParameterError as error:  # the device does not allow these settings any more
            self._show_message("Preset not restored", [str(error)])

    def bring(self) -> None:
        """Ask for a preset's file, apply it, and store a copy."""
        choose_file(
            self._window, "Import preset", "Presets (*.toml)", lambda path: self.import_file(Path(path))
        )

    def import_file(self, path: Path) -> None:
        """Apply a preset from another folder; if the preset is valid, store a copy with the same name."""
        if settings := self.apply(path):
            try:
                presets.write(self._studio.environments[settings[ENVIRONMENT]], path.stem, settings)
            except (OSError, ParameterError) as error:
                self._show_message("Preset not saved", [f"{path.name} was applied, but not saved: {error}"])

    def save(self, name: str, with_loop: bool) -> None:
        """Save the current settings under a name.

        Raise ParameterError for an invalid name, and OSError if the file cannot be written.
        """
        environment, saved = self._studio.environment, settings_of_scene(self._studio, with_loop)
        presets.write(environment, name, saved)
        self._chosen[environment.key] = name, saved
        self.changed.emit()

    def ask_to_compare(self) -> None:
        """Open the dialog that compares presets with the current settings."""
        CompareDialog(self._studio, self, self._window).show()

    def ask_to_save(self) -> None:
        """Open the dialog that asks for a name to save under."""
        SavePresetDialog(self._studio, self, self._window).show()

    def _show_message(self, title: str, lines: list[str]) -> None:
        text_dialog(title, lines, self._window).show()

    def _put(self, name: str, settings: Snapshot) -> None:
        with self._history.named(f"preset {name}"):
            put(self._studio, differing(self._studio, settings))
        self._chosen[self._studio.environment.key] = name, settings
        self.changed.emit()


class SavePresetDialog(FormDialog):
    """Asks for a preset's name, and whether the loop is saved, too."""

    def __init__(self, studio: Studio, presets_: Presets, parent: QWidget):
        environment = studio.environment
        super().__init__("Save preset", _ABOUT.format(environment.title), parent)
        self._presets, self._known = presets_, presets.found(environment.key)
        self.name, self.with_loop = (
            QLineEdit(presets_.chosen),
            QCheckBox("Also save the loop's settings and the grip"),
        )
        self.save = QPushButton("Save preset")
        self.add_fields([("Name of the preset", self.name, None)])
        self.column.addWidget(self.with_loop)
        self.add_verdict(1)
        self.add_buttons(self.save)
        self.save.setDefault(True)
        self.save.clicked.connect(self._save)
        self.name.textChanged.connect(self._judge)
        studio.environment_changed.connect(self.close)
        self._judge()

    def _judge(self) -> None:
        """Show what saving under the entered name would do."""
        try:
            name = presets.checked_name(self.name.text())
        except ParameterError as error:
            self.verdict.show_text(str(error))
            self.save.setEnabled(False)
            return
        self.save.setEnabled(True)
        self.verdict.show_text(
            "Saving replaces the preset that has this name." if name in self._known else ""
        )

    def _save(self) -> None:
        try:
            self._presets.save(presets.checked_name(self.name.text()), self.with_loop.isChecked())
        except (OSError, ParameterError) as error:
            self.verdict.show_text(f"The preset was not saved: {error}", "triangle", "danger")
        else:
            self.close()


class CompareDialog(FormDialog):
    """Shows what a preset would change; it follows the settings, and closes if the environment changes."""

    def __init__(self, studio: Studio, presets_: Presets, parent: QWidget):
        title = studio.environment.title
        super().__init__(
            "Compare presets", f"Shows which settings a preset of the scene {title} would change.", parent
        )
        self._presets, self._found = presets_, presets.found(studio.environment.key)
        self.picker, self.table = QComboBox(), DifferenceTable("Present value", "Value in the preset")
        self.picker.addItems([*self._found])
        self.picker.setCurrentText(presets_.chosen)
        self.use = QPushButton("Apply preset")
        self.add_fields([("Preset", self.picker, None)])
        self.column.addWidget(self.table)
        self.add_verdict(1)
        self.add_buttons(self.use)
        self.use.clicked.connect(lambda: presets_.apply(self._found[self.picker.currentText()]))
        self.picker.currentTextChanged.connect(self.compare)
        for signal in (studio.values_changed, studio.loop_changed, presets_.changed):
            signal.connect(self.compare)
        studio.environment_changed.connect(self.close)
        self.compare()

    def compare(self) -> None:
        """Show the settings that the preset would change; if it changes none, show the reason."""
        found: list[Difference] = []
        text = "No preset is saved yet."
        if self._found:
            try:
                found = self._presets.compared(self._found[self.picker.currentText()])
                text = "" if found else "The settings of this preset are already set."
            except ParameterError as error:
                text = str(error)
        self.table.show_differences(found)
        self.use.setEnabled(bool(found))
        self.verdict.show_text(text)
        self.verdict.setVisible(bool(text))


class PresetRow(QWidget):
    """Shows the active preset; its menu applies, compares, saves and imports presets."""

    def __init__(self, studio: Studio, presets_: Presets):
        super().__init__()
        self._studio, self._presets = studio, presets_
        self.button, self.menu = QPushButton(), QMenu(self)
        self.menu.setToolTipsVisible(True)
        self.menu.aboutToShow.connect(self.fill)
        self.button.setMenu(self.menu)
        self.button.setProperty("menu", True)
        self.name = label("Preset")
        self.name.setBuddy(self.button)
        hbox((self.name, 1), self.button, into=self, margins=(0, 3, 0, 3), gap=6)
        for signal in (studio.settings_changed, presets_.changed):
            signal.connect(self.show_state)
        self.show_state()

    def show_state(self) -> None:
        """Show the active preset and whether it was changed, or that no preset is active."""
        studio, chosen = self._studio, self._presets.chosen
        self.setVisible(bool(studio.environment.parameters))
        text = DEFAULTS if studio.values == studio.environment.values() else OWN
        changed = self._presets.different
        kind = "Changed preset" if changed else "Preset"
        self.name.setText(kind)
        self.button.setText(chosen or text)
        self.button.setAccessibleName(f"{kind}: {chosen or text}")
        lines = (
            ["Differences:", *map(str, differences(studio, settings_of(studio), changed))] if changed else []
        )
        self.button.setToolTip(plain_tip("\n".join(lines)))

    def fill(self) -> None:
        """Fill the menu with all presets; a tooltip lists what each would change."""
        presets_, menu, studio = self._presets, self.menu, self._studio
        menu.clear()
        self._add(DEFAULTS, studio.reset_values)
        for name, path in presets.found(studio.environment.key).items():
            action = self._add(name, partial(presets_.apply, path), self._would_change(path))
            action.setCheckable(True)
            action.setChecked(name == presets_.chosen and not presets_.different)
        menu.addSeparator()
        self._add("Compare presets…", presets_.ask_to_compare)
        if presets_.chosen and presets_.different:
            self._add(f"Restore preset {presets_.chosen}", presets_.restore)
        self._add("Save preset as…", presets_.ask_to_save)
        self._add("Import preset…", presets_.bring)

    def _would_change(self, path: Path) -> str:
        """Return one line per change that a preset would make.

        If the preset changes nothing, return a sentence; if it is invalid, return its errors.
        """
        try:
            return "\n".join(map(str, self._presets.compared(path))) or "This preset changes nothing"
        except ParameterError as error:
            return str(error)

    def _add(self, text: str, do: Callable[[], object], tip: str = "") -> QAction:
        action = self.menu.addAction(text)
        action.triggered.connect(lambda _on=False: do())
        action.setToolTip(plain_tip(tip))
        return action
