"""The verdict beside the map, what each line means, and the conditions that all of it holds for."""

import math
from dataclasses import dataclass, replace

from PySide6.QtWidgets import QSizePolicy

from hapkit_studio.analysis.stability.kb_plane import Plane
from hapkit_studio.analysis.stability.margin import Margin, hand_words, remedy, short, stable_again
from hapkit_studio.gui.pages.base import Pairs, SidePanel
from hapkit_studio.gui.pages.stability.map_data import Measured
from hapkit_studio.gui.widgets.parts import Sign, across, hint, label
from hapkit_studio.gui.widgets.style import mark

_SIGNS = (("check", "ok"), ("circle", "warn"), ("cross", "danger"))
_OPEN = ("circle", "ink2")
# DECAYS, BUZZES, GROWS of the measured classes
_KINDS = ("comes to rest", "buzzes, does not grow", "grows")


@dataclass(frozen=True)
class Verdict:
    """What the column says: headline, one line below it, what else to know, and a sign with its token."""

    headline: str
    words: str
    more: str = ""
    sign: tuple[str, str] = _OPEN


def kind_at(measured: Measured, damping: float, stiffness: float) -> int | None:
    """Return the class measured at a point; None beyond the axes that were measured."""
    rows, columns = measured.cells.classes.shape
    across, up = damping / measured.axes[0], stiffness / measured.axes[1]
    if not (0.0 <= across <= 1.0 and 0.0 <= up <= 1.0):
        return None
    return int(measured.cells.classes[min(int(up * rows), rows - 1), min(int(across * columns), columns - 1)])


def verdict(plane: Plane, measured: Measured | None = None) -> Verdict:
    """Judge the dot; measured: what was measured for this very setting, if anything was."""
    margin, real = plane.margin, measured is not None and measured.real
    found = None if measured is None else kind_at(measured, margin.damping, margin.stiffness)
    if plane.setting.controller:
        return _controlled(margin, found)
    plain, open_ = _exact(margin, plane.setting.coulomb > 0.0), math.isnan(margin.limit)
    if found is None or not (real or open_):
        return plain
    said = f"Measured{' with friction' if real else ''}: {_KINDS[found]}."
    sign = _SIGNS[found] if open_ else plain.sign
    return replace(plain, more=f"{plain.more}\n{said}".strip(), sign=sign)


def _exact(margin: Margin, friction: bool) -> Verdict:
    """Return the verdict of the exact limit alone."""
    said, hand = short(margin), hand_words(margin.hand)
    head, cut, rest = said.partition(" from " if margin.island else " the limit")
    without = ", without dry friction" if friction and not math.isnan(margin.limit) else ""
    words = f"{cut.lstrip()}{rest}; {hand}{without}." if cut else f"{hand}{without}.".capitalize()
    if said.endswith(hand):
        words = f"{without.removeprefix(', ')}.".capitalize() if without else ""
    sign = _OPEN if math.isnan(margin.limit) else _SIGNS[0] if margin.stable else _SIGNS[2]
    return Verdict(head, words, f"{remedy(margin)} {stable_again(margin)}".strip(), sign)


def _controlled(margin: Margin, found: int | None) -> Verdict:
    """Return the verdict with the passivity controller on: the exact limit knows nothing of it."""
    plain = _exact(margin, False)
    if found is None:
        words = f"{plain.words.rstrip('.')}. This is the limit without the controller."
        return Verdict(plain.headline, words, "With the controller only measuring can tell.")
    name = _KINDS[found].partition(",")[0].capitalize()
    words = f"Measured with the controller; {hand_words(margin.hand)}."
    without = "" if math.isnan(margin.limit) else f"Without it: {short(margin)}."
    return Verdict(name, words, without, _SIGNS[found])


class VerdictColumn(SidePanel):
    """Verdict, lines and conditions in a column that scrolls where it is too long."""

    def __init__(self) -> None:
        super().__init__()
        self.setFixedWidth(276)
        self.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Ignored)
        self.setObjectName("beside")
        self.body.setObjectName("beside")
        self.sign, self.out, self.lines = Sign(24), label(), hint()
        mark(self.heading, "role", "verdict")
        mark(self.words, "role", "axis")
        self.column.insertLayout(0, across(self.sign, (self.heading, 1), gap=10))
        self.add(self.out, self.lines)
        self.conditions = Pairs(self.section("Conditions"))
        self.add(self.conditions)

    def show_verdict(self, verdict: Verdict) -> None:
        """Say how far the rendered impedance is from the limit, or why nothing can be said."""
        texts = verdict.headline, verdict.words, verdict.more
        for part, text in zip((self.heading, self.words, self.out), texts, strict=True):
            part.setText(text)
            part.setVisible(bool(text))
        self.sign.show_sign(*verdict.sign)
        danger = verdict.sign[1] == "danger"
        mark(self.heading, "ink", "danger" if danger else "ink")
        mark(self.out, "ink", "danger" if danger else "ink2")

    def show_lines(self, words: dict[str, tuple[str, str]]) -> None:
        """Say what each line of the map means."""
        self.lines.setText("\n".join(f"{name}: {meaning}" for name, meaning in words.values()))
