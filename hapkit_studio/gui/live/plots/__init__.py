"""The plots. Each file declares one plot, which is discovered by the name ``PLOT``."""
