"""Figures of measurements, readable on a projector; one module per figure."""
