"""The plots. Each file declares one plot under the name ``PLOT``."""
