"""A handle thrown at a wall, simulated in plain Python in tiny steps: shares nothing with the studio's."""

import math

ON = {"viscous": 0.5, "coulomb": 0.10, "quantization": 20.7e-6, "sampling": 1000.0, "delay": 1e-3}
MASS, STIFFNESS, SURFACE, SPEED = 0.044, 250.0, 0.005, 0.5
STEP = 2.5e-6
SECONDS = 0.09


class PlainWall:
    """The largest force the wall commands, and the speed back over the speed in."""

    def __init__(self, viscous, coulomb, quantization, sampling, delay):
        x, v, force = 0.0, SPEED, 0.0
        pending = []
        every = round(1.0 / sampling / STEP)
        late = round(delay / STEP)
        self.peak_force, fastest_back = 0.0, 0.0
        for k in range(round(SECONDS / STEP)):
            if k % every == 0:
                seen = quantization * math.floor(x / quantization) if quantization else x
                asked = -STIFFNESS * max(seen - SURFACE, 0.0)
                self.peak_force = max(self.peak_force, -asked)
                pending.append((k + late, asked))
                fastest_back = max(fastest_back, -v)
            while pending and pending[0][0] <= k:
                force = pending.pop(0)[1]
            drag = math.copysign(coulomb, v)
            half = v + 0.5 * STEP * (force - viscous * v - drag) / MASS
            x += STEP * half
            v += STEP * (force - viscous * half - drag) / MASS
        self.restitution = fastest_back / SPEED
