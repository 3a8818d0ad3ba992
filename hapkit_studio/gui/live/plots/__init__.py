"""Plots: one file a plot, found by the name ``PLOT``."""
