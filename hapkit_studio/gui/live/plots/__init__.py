"""Plots: one file per plot, discovered by the name ``PLOT``."""
