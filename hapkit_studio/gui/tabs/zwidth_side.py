"""Beside the Z-width: the points in numbers, the conditions, how to read it, how a device is treated."""

from typing import TYPE_CHECKING

from PySide6.QtWidgets import QHBoxLayout, QLabel, QWidget

from hapkit_studio.analysis.zwidth_limits import CARE_FORCE
from hapkit_studio.errors import ParameterError
from hapkit_studio.gui.number_box import NumberBox
from hapkit_studio.gui.quantity import Quantity
from hapkit_studio.gui.tabs.side import Pairs, SidePanel, hint

if TYPE_CHECKING:
    from hapkit_studio.analysis.zwidth_result import ZWidth

_READ = (
    "Each point is the stiffest wall that comes to rest after a hit and a push. Hollow: the motor reached "
    "its limit. Dashed: the limit of the linear loop, without friction and sensor steps."
)
_CARE = (
    "A hand presses into walls of rising stiffness until one keeps buzzing. Nothing stiffer is tried. Force, "
    "speed and travel are limited, Esc stops at once, and your settings come back."
)
_BOX_WIDTH = 92


class ZWidthSide(SidePanel):
    """Shows one result; keeps the force limit for a device."""

    def __init__(self) -> None:
        super().__init__("Z-width", "How stiff a wall is rendered without buzzing, over virtual damping.")
        self.max_force = CARE_FORCE.default
        self._result: ZWidth | None = None
        self.points, self.conditions, self.point, self.refusal = Pairs(), Pairs(), hint(), hint()
        self.force = NumberBox(Quantity.of(CARE_FORCE))
        self.force.show_value(CARE_FORCE.default)
        self.force.setFixedWidth(_BOX_WIDTH)
        self.force.setAccessibleName("Force limit, N")
        self.force.entered.connect(self._take_force)
        self.add(self.points)
        self.add(self.point)
        self.conditions.stand_under(self.section("Conditions"))
        self.add(self.conditions)
        self.section("Read the chart")
        self.add(hint(_READ))
        self.section("On this device")
        self.add(self._force_row())
        self.add(self.refusal)
        self.add(hint(_CARE))
        self.refusal.hide()

    def show_result(self, result: "ZWidth | None") -> None:
        """Show points and conditions, None for nothing."""
        from hapkit_studio.analysis.zwidth_result import newtons_per_metre

        self._result = result
        self.point.setText("")
        if result is None:
            self.points.show_pairs([])
            self.conditions.show_pairs([])
            return
        limits = (newtons_per_metre(float(k)) for k in result.stiffness)
        names = (f"B = {b:g} N·s/m" for b in result.damping)
        self.points.show_pairs(list(zip(names, limits, strict=True)))
        place = [("Where", result.place)]
        self.conditions.show_pairs(place + [(c.name, c.text) for c in result.conditions])

    def show_point(self, index: int | None) -> None:
        """Say in words what a point is, and why nothing stiffer."""
        result = self._result
        if result is None or index is None or index >= len(result.damping):
            self.point.setText("")
            return
        from hapkit_studio.analysis.zwidth_result import ENDED

        self.point.setText(f"{result.at(index)}{result.motor(index)}. Beyond: {ENDED[result.ends[index]]}.")

    def lock(self, on: bool) -> None:
        """Keep the force limit as it is while a device is tried."""
        self.force.setEnabled(not on)

    def _take_force(self, value: float) -> None:
        try:
            self.max_force = CARE_FORCE.check(value)
            self.refusal.hide()
        except ParameterError as error:
            self.refusal.setText(str(error))
            self.refusal.show()

    def _force_row(self) -> QWidget:
        row = QWidget()
        across = QHBoxLayout(row)
        across.setContentsMargins(0, 0, 0, 0)
        across.addWidget(QLabel(CARE_FORCE.label), 1)
        across.addWidget(self.force)
        across.addWidget(QLabel("N"))
        return row
