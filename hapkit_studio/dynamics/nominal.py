"""Nominal values of a Hapkit at the handle, in SI units."""

MASS = 0.044  # kg, mass of the moving parts
VISCOUS = 0.5  # N·s/m
COULOMB_FORCE = 0.10  # N
QUANTUM = 20.7e-6  # m per count of the sensor
MAX_FORCE = 3.0  # N, default of the force limit
