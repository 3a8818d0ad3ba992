"""Calibration: computations on recorded tracks for a kit's sensor, scale, motor and paddle."""
