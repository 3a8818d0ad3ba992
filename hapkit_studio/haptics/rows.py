"""The telemetry row: what every tick writes, and where in the row it stands. SI units.

HOST_TIME is the computer's monotonic clock (time.perf_counter), so rows before and after a lost connection
stand on one axis; BOARD_TIME is the device's own clock since it started.
"""

TICK = 0
HOST_TIME = 1
BOARD_TIME = 2
POSITION = 3
VELOCITY = 4
ASKED = 5
APPLIED = 6
LATENESS = 7
COMPUTE = 8
ENERGY = 9
FLAGS = 10
TRUE_POSITION = 11
TRUE_VELOCITY = 12
HAND_FORCE = 13
HAND_TARGET = 14
PERIOD = 15
STATE = 16
STATES = 16
ROW_WIDTH = STATE + STATES

CLAMPED = 1
STOPPED = 2
FAULT = 4
STALE = 8
FADING = 16
GAP = 32
# the passivity observer: more was given than could be stored; the controller adds damping
ACTIVE = 64
DAMPED = 128
