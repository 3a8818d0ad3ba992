"""What of the simulated device the loop models: what the scene needs, or everything."""

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QLabel, QVBoxLayout, QWidget

from hapkit_studio.devices.terms import MODELS, OPTIONAL, TERMS
from hapkit_studio.environments.base import Environment
from hapkit_studio.gui.rich import rich
from hapkit_studio.gui.segmented import Segmented

_OPTIONS = ("As needed", "Everything")


def modelled(needs: tuple[str, ...], model: str) -> list[str]:
    """Return the keys of the device's terms that are modelled; () was never looked at and gets them all."""
    whole = model == "everything" or not needs
    return ["mass", *(key for key in OPTIONAL if whole or key in needs)]


def _words(keys: list[str]) -> str:
    return ", ".join(TERMS[key].word for key in keys)


class ModelLine(QWidget):
    """Says what is modelled; emits ``chosen`` with "scene" or "everything" when a person switches."""

    chosen = Signal(str)

    def __init__(self, parent: QWidget | None = None):
        super().__init__(parent)
        self.words = QLabel()
        self.words.setWordWrap(True)
        self.words.setProperty("role", "hint")
        self.switch = Segmented("Model", _OPTIONS)
        self.switch.chosen.connect(lambda index: self.chosen.emit(MODELS[index]))
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(4)
        column.addWidget(self.words)
        column.addWidget(self.switch)

    def show_model(self, environment: Environment, model: str, simulated: bool) -> None:
        """Show what is in force; a real device is not modelled, and a scene that needs all has no switch."""
        self.setVisible(simulated)
        needs = environment.needs
        spare = [key for key in OPTIONAL if key not in modelled(needs, "scene")]
        keys = modelled(needs, model)
        whole = len(keys) > len(OPTIONAL)
        self.words.setText(f"Modelled: {'everything' if whole else _words(keys)}")
        self.switch.setVisible(bool(spare))
        self.switch.show_index(MODELS.index(model))
        self.setToolTip(f"<p>{rich(_why(environment.title, spare, judged=bool(needs)))}</p>")


def _why(title: str, spare: list[str], judged: bool) -> str:
    """Return what is left out and what it would change."""
    if not judged:
        return f"{title} was not judged yet, so everything is modelled: {_words(modelled((), 'scene'))}."
    if not spare:
        all_of_it = _words(modelled((), "scene"))
        return (
            f"{title} needs {all_of_it}: without any one, a force, place or count differs by more than 2 %."
        )
    return (
        f"{title} does without {_words(spare)}: with the parameters it starts with, no force, place or count "
        "differs by more than about 2 % of its scale. Other parameters may need more."
    )
