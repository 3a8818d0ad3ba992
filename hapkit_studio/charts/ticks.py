"""Tick labels of matplotlib's axes in the number formats of ``formatting``."""

from collections.abc import Sequence

from matplotlib.ticker import Formatter, LogFormatter

from hapkit_studio.formatting import compact, tick_labels


class Ticks(Formatter):
    """Tick labels of an axis; on a linear axis all have the same number of decimals."""

    def __init__(self, linear: bool):
        self._linear = linear

    def __call__(self, x: float, pos: int | None = None) -> str:
        return compact(x)

    def format_ticks(self, values: Sequence[float]) -> list[str]:
        if self._linear:
            return tick_labels(values)
        return [compact(value) for value in values]


class MinorTicks(LogFormatter):
    """Labels of the minor ticks of a logarithmic axis, if matplotlib finds room for them."""

    def __call__(self, x: float, pos: int | None = None) -> str:
        return compact(x) if super().__call__(x, pos) else ""
