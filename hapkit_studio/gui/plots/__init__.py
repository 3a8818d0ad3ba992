"""Plots: one file a plot, found by the name ``PLOT``."""

from hapkit_studio.gui.plots.phase import ForcePosition
from hapkit_studio.gui.plots.time import TimePlots

__all__ = ["ForcePosition", "TimePlots"]
