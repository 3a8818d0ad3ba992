"""From the duty that a board reports to the force on the handle, by its settings."""

import numpy as np

from hapkit_studio.devices.profiles import full_force
from hapkit_studio.protocol.messages import Board, MotorMap

TOP = 255.0


def share_of(board: Board, pwm: np.ndarray) -> np.ndarray:
    """Return the share (n,) of the full torque, signed, at signed duties pwm (n,) of 255."""
    size = np.abs(np.asarray(pwm, dtype=float))
    duty = np.clip((size - board.dead_band) / (TOP - board.dead_band), 0.0, 1.0)
    if board.motor_map == MotorMap.SQUARE:
        share = duty * duty
    elif board.motor_map == MotorMap.LINEAR:
        share = duty
    else:
        share = np.interp(duty, np.arange(9) / 8.0, np.array((0.0, *board.table)) / TOP)
    return np.sign(pwm) * share


def force_of(board: Board, pwm: np.ndarray) -> np.ndarray:
    """Return the force on the handle (n,) in N at signed duties pwm (n,) of 255, positive to the right."""
    return full_force(board) * share_of(board, pwm)
