"""Options of a Z-width and their defaults; this module imports nothing slow, so it loads at once."""

from hapkit_studio.parameters import Parameter

DAMPING = Parameter("damping", "Damping", "N·s/m", 0.0, 0.0, 1000.0, "Virtual damping of the walls")
SPEED = Parameter("speed", "Speed", "m/s", 0.1, 0.001, 3.0, "Speed at which the handle hits the wall")
PUSH = Parameter("push", "Push", "N", 1.0, 0.01, 20.0, "Constant force into the wall")
MAX_FORCE = Parameter("max_force", "Force limit", "N", 3.0, 0.01, 100.0, "Largest force of the motor")
DEVICE_FORCE = Parameter("max_force", "Force limit", "N", 2.0, 0.1, 3.0, "Largest force in a trial")

# reason why a search ended: even the stiffest wall did not fail
HIGHEST = "highest"

SIMULATED_DAMPING = (0.0, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0)
DEVICE_DAMPING = (0.0, 1.0, 2.0, 5.0)
