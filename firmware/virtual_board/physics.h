// Virtual board: the Hapkit firmware in the simulator simavr, connected to a simulated paddle.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

// The paddle's physics: mass, viscous and Coulomb friction, a hand on a spring and a damper, end stops.
#pragma once

#include <stdbool.h>

struct plant {
	double mass, viscous, coulomb;  // kg, N s/m, N at the handle
	double stop;                    // end stops at +-stop [m]; infinite means none
	bool held;                      // a hand holds the handle
	bool arriving;                  // the hand has taken the handle and moves to its first target
	double hand_mass, hand_damping, hand_stiffness;
	bool prescribed;                // the handle follows the target exactly
	double target, goal, ramp;      // [m], [m]; remaining time [s] until the target reaches the goal
	double motor, external;         // N, constant until changed
	double x, v;                    // m, m/s
};

// Move the hand's target linearly to goal within the given time; if the time is 0, move it at once.
void plant_aim(struct plant *p, double goal, double seconds);

// Advance exactly by dt seconds with constant motor and external force.
void plant_advance(struct plant *p, double dt);

// Return the force of the hand on the handle [N].
double plant_hand_force(const struct plant *p);
