"""Analyses of a haptic loop, one per module or folder: stability, accuracy, Z-width, failures."""
