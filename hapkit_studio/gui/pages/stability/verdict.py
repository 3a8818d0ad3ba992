"""The column beside the map: verdict, limits, meaning of the lines, and conditions."""

from dataclasses import dataclass

import numpy as np
from PySide6.QtWidgets import QSizePolicy

from hapkit_studio.analysis.stability.kb_plane import Plane, class_descriptions
from hapkit_studio.analysis.stability.margin import hand_text, stable_again
from hapkit_studio.gui.pages.base import Pairs, SidePanel
from hapkit_studio.gui.pages.stability.map_data import Lines, Measured
from hapkit_studio.gui.widgets.parts import AnswerLines, Sign, hbox, hint, label
from hapkit_studio.gui.widgets.style import mark
from hapkit_studio.gui.widgets.theme import number

_OPEN = ("circle", "ink2")
_WHY_SO_MANY = (
    "Passive: stable in any hand. No hand: stable without a hand. Grip: stable in a hand, which adds "
    "damping, so the limit is usually higher. These limits ignore dry friction. The view Z-width includes "
    "friction and usually finds higher limits."
)


@dataclass(frozen=True)
class Verdict:
    """The texts of the column: headline, details, a sign with its colour token, and a line for each hand."""

    headline: str
    more: str
    sign: tuple[str, str] = _OPEN
    lines: tuple[tuple[str, str, str], ...] = ()


def kind_at(measured: Measured, damping: float, stiffness: float) -> int | None:
    """Return the class that was measured for the map's cell at a point; None outside the measured axes."""
    rows, columns = measured.cells.classes.shape
    across, up = damping / measured.axes[0], stiffness / measured.axes[1]
    if not (0.0 <= across <= 1.0 and 0.0 <= up <= 1.0):
        return None
    return int(measured.cells.classes[min(int(up * rows), rows - 1), min(int(across * columns), columns - 1)])


def verdict(plane: Plane, measured: Measured | None = None) -> Verdict:
    """Return the verdict on the dot; ``measured`` is a measurement with the same settings, or None."""
    judged = plane.verdict
    if judged is None:
        return Verdict("", "")
    more = [judged.reason, judged.unknown, plane.caption, stable_again(plane.margin)]
    found = None if measured is None else kind_at(measured, plane.margin.damping, plane.margin.stiffness)
    if measured is not None and found is not None:
        handle = "with friction" if measured.real else "of an ideal handle"
        more.append(f"Measurement {handle}: {class_descriptions(plane.setting.controller)[found]}.")
    return Verdict(judged.headline, "\n".join(filter(None, more)), judged.sign, judged.signed)


def limits(lines: Lines) -> tuple[str, list[tuple[str, str]]]:
    """Return a title, and the name and value of every limit.

    These are limits of the stiffness at the rendered damping. If no stiffness is rendered, they are limits of
    the damping.
    """
    plane, asked = lines.plane, lines.question.asked
    across = plane.margin.damping
    title = f"Limits at a damping of {number(across, 1)} N·s/m"
    if asked is not None and asked.impedance is None:
        return "", []
    if not plane.setting.linear:
        return title, [("Unknown", "the velocity filter is not linear")]
    if lines.dampings:
        title, unit, digits, own = "Limits of the damping", "N·s/m", 1, lines.dampings
        passive = float(plane.edge_damping[-1])
    else:
        unit, digits, own = "N/m", 0, plane.hands
        passive = float(np.interp(across, plane.edge_damping, plane.edge, right=0.0))
    joint = plane.verdict is not None and plane.verdict.joint
    found = {} if joint else {"Passive": passive}
    found |= {hand_text(hand).capitalize(): limit for hand, limit in own.items()}
    if plane.setting.coulomb > 0.0 and not lines.dampings and not joint:
        name = f"{hand_text(plane.setting.hand).capitalize()}, friction"
        found[name] = float(np.interp(across, plane.damping, plane.friction))
    return title, [(name, f"{number(k, digits)} {unit}" if k > 0.0 else "none") for name, k in found.items()]


class VerdictColumn(SidePanel):
    """A scrolling column with verdict, limits, lines and conditions."""

    def __init__(self) -> None:
        super().__init__()
        self.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Ignored)
        self.setObjectName("beside")
        self.body.setObjectName("beside")
        self._cover.setObjectName("besideEnd")
        self.sign, self.out, self.why, self.lines = Sign(24), label(), hint(_WHY_SO_MANY), hint()
        self.label.hide()
        self.answers = AnswerLines()
        mark(self.heading, "role", "verdict")
        mark(self.out, "ink", "ink2")
        self.column.insertLayout(0, hbox(self.sign, (self.heading, 1), gap=10))
        self.add(self.answers, self.out)
        self.limits_heading, self.limits = (above := self.section("Limits"))[1], Pairs(above)
        self.add(self.limits, self.why, self.lines)
        self.conditions = Pairs(self.section("Conditions"))
        self.add(self.conditions)

    def show_verdict(self, verdict: Verdict) -> None:
        """Show the verdict's texts and sign."""
        for part, text in ((self.heading, verdict.headline), (self.out, verdict.more)):
            part.setText(text)
            part.setVisible(bool(text))
        self.sign.show_sign(*verdict.sign)
        self.answers.show_text(*verdict.lines)
        token = verdict.sign[1]
        mark(self.heading, "ink", token if token in ("danger", "warn") else "ink")

    def show_limits(self, lines: Lines | None) -> None:
        """Show every hand's limit."""
        title, pairs = limits(lines) if lines else ("", [])
        self.limits_heading.setText(title)
        self.limits.show_pairs(pairs)
        self.why.setVisible("Passive" in dict(pairs))

    def show_lines(self, texts: dict[str, tuple[str, str]]) -> None:
        """Explain each line of the map."""
        self.lines.setText("\n".join(f"{name}: {meaning}" for name, meaning in texts.values()))
