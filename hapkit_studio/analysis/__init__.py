"""Analyses of a haptic loop, one per file or folder: stability, speed and accuracy, Z-width, failures."""
