"""The verdict beside the map, what each line means, and the conditions that all of it holds for."""

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt
from PySide6.QtGui import QFontMetricsF
from PySide6.QtWidgets import QFrame, QHBoxLayout, QLabel, QScrollArea, QSizePolicy, QVBoxLayout, QWidget

from hapkit_studio.analysis.stability.margin import Margin, hand_words, short, way_out
from hapkit_studio.gui.pages.base import Pairs, hint
from hapkit_studio.gui.pages.stability.map_data import Measured
from hapkit_studio.gui.panel.parameter_panel import rule
from hapkit_studio.gui.widgets import icons
from hapkit_studio.gui.widgets.style import dress
from hapkit_studio.gui.widgets.text import plain
from hapkit_studio.gui.widgets.theme import theme

if TYPE_CHECKING:
    from hapkit_studio.analysis.stability.kb_plane import Plane


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


def nothing_yet(device: bool, delay: bool) -> Verdict:
    """Say what is missing before there are lines: a device, its delay, or only time."""
    if not device:
        return Verdict("Not judged yet", "Needs a device.")
    if not delay:
        return Verdict("Measuring the delay", "Half a second at zero force, on connecting.")
    return Verdict("Computing", "The map's lines come in a moment.")


def kind_at(measured: Measured, damping: float, stiffness: float) -> int | None:
    """Return the class measured at a point; None beyond the axes that were measured."""
    rows, columns = measured.cells.classes.shape
    across, up = damping / measured.axes[0], stiffness / measured.axes[1]
    if not (0.0 <= across <= 1.0 and 0.0 <= up <= 1.0):
        return None
    return int(measured.cells.classes[min(int(up * rows), rows - 1), min(int(across * columns), columns - 1)])


def verdict(plane: "Plane", measured: Measured | None = None) -> Verdict:
    """Judge the dot; measured: what was measured for this very setting, if anything was."""
    found = _measured(plane.margin, measured)
    if plane.setting.controller:
        return _controlled(plane.margin, found)
    plain = _exact(plane.margin, plane.setting.coulomb > 0.0)
    real, open_ = measured is not None and measured.real, math.isnan(plane.margin.limit)
    if found is None or not (real or open_):
        return plain
    said = f"Measured{' with friction' if real else ''}: {_KINDS[found]}."
    sign = _SIGNS[found] if open_ else plain.sign
    return replace(plain, more=f"{plain.more}\n{said}".strip(), sign=sign)


def _measured(margin: Margin, measured: Measured | None) -> int | None:
    return None if measured is None else kind_at(measured, margin.damping, margin.stiffness)


def _exact(margin: Margin, friction: bool) -> Verdict:
    """Return the verdict of the exact limit alone."""
    said, hand = short(margin), hand_words(margin.hand)
    head, cut, _ = said.partition(" the limit")
    without = ", without dry friction" if friction and not math.isnan(margin.limit) else ""
    words = f"the limit; {hand}{without}." if cut else f"{hand}{without}.".capitalize()
    if said.endswith(hand):
        words = f"{without.removeprefix(', ')}.".capitalize() if without else ""
    sign = _OPEN if math.isnan(margin.limit) else _SIGNS[0] if margin.stable else _SIGNS[2]
    return Verdict(head, words, way_out(margin), sign)


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


WIDTH = 276
_MARGIN = 10
_SMALLEST = 16
_SIGN = 24


class VerdictColumn(QScrollArea):
    """Verdict, lines and conditions in a column that scrolls where it is too long."""

    def __init__(self) -> None:
        super().__init__()
        self.setFixedWidth(WIDTH)
        self.setWidgetResizable(True)
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        dress(self, "QScrollArea, #beside { background: transparent; border: none; }")
        self.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Ignored)
        self._sign = ("circle", "ink2")
        self.sign, self.hand = QLabel(), hint()
        self.headline, self.out = plain(QLabel()), plain(QLabel())
        self.lines, self.conditions = hint(), Pairs()
        heading = QLabel("Conditions")
        heading.setProperty("role", "section")
        self._above = (rule(), heading)
        self.out.setWordWrap(True)
        dress(self.hand, "QLabel { color: @ink2; font-size: 14px; }")
        dress(self.out, "QLabel { color: @danger; }")
        self._arrange()
        theme.changed.connect(self._look)
        self._look()

    def show_verdict(self, verdict: Verdict) -> None:
        """Say how far the rendered impedance is from the limit, or why nothing can be said."""
        self.headline.setText(verdict.headline)
        self.hand.setText(verdict.words)
        self.hand.setVisible(bool(verdict.words))
        self.out.setText(verdict.more)
        self.out.setVisible(bool(verdict.more))
        self._sign = verdict.sign
        self._look()

    def show_conditions(self, pairs: list[tuple[str, str]]) -> None:
        """Show what the limits hold for."""
        self.conditions.show_pairs(pairs)

    def show_lines(self, words: dict[str, tuple[str, str]]) -> None:
        """Say what each line of the map means."""
        self.lines.setText("\n".join(f"{name}: {meaning}" for name, meaning in words.values()))

    def _look(self) -> None:
        name, token = self._sign
        self.sign.setPixmap(icons.pixmap(name, _SIGN, token, self.devicePixelRatioF()))
        size = self._fitting(self.headline.text())
        ink = "danger" if token == "danger" else "ink"
        dress(self.headline, f"QLabel {{ color: @{ink}; font-size: {size}px; font-weight: 700; }}")
        dress(self.out, f"QLabel {{ color: @{'danger' if token == 'danger' else 'ink2'}; }}")

    def _fitting(self, words: str) -> int:
        """Return the largest size in px at which the headline takes one line."""
        font, free = theme.font("verdict"), WIDTH - _SIGN - 2 * _MARGIN - 10
        size = font.pixelSize()
        while size > _SMALLEST and QFontMetricsF(font).horizontalAdvance(words) > free:
            size -= 1
            font.setPixelSize(size)
        return size

    def _arrange(self) -> None:
        first = QHBoxLayout()
        first.setSpacing(10)
        first.addWidget(self.sign)
        first.addWidget(self.headline, 1)
        self._body = QWidget()
        self._body.setObjectName("beside")
        column = QVBoxLayout(self._body)
        column.setContentsMargins(4, 10, 2 * _MARGIN - 4, 10)
        column.setSpacing(6)
        column.addLayout(first)
        column.addWidget(self.hand)
        column.addWidget(self.out)
        column.addSpacing(6)
        column.addWidget(self.lines)
        for part in self._above:
            column.addWidget(part)
        column.addWidget(self.conditions)
        column.addStretch(1)
        self.setWidget(self._body)
        self.conditions.stand_under(self._above)
