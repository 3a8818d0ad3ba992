"""Calibration in numbers: what recorded tracks tell about a kit's sensor, scale, motor and paddle."""
