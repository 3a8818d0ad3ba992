// Virtual board: the Hapkit firmware in the simulator simavr, connected to a simulated paddle.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

// Converts the chip's registers to the motor's force: PWM on D5 (OC0B) and direction on D8, or PWM on D3
// (OC2B) and direction on D12.
#pragma once

#include <stdbool.h>
#include <stdint.h>

struct motor {
	double full_force;      // N at the handle at full duty
	double power;           // force = full_force * share^power, share = (duty - dead band) / (255 - dead band)
	double dead_band;       // duty below which the motor does not turn; 255 is full duty
	double high_direction;  // +1 or -1: sign of the force while the direction pin is high
	bool old_pins;          // the motor is connected to D3 and D12 instead of D5 and D8
	int duty;               // -255 to 255 (full duty), because the sign is the direction of the force
	bool known;             // false if the output is on in a timer mode that is not modelled
};

// The registers that determine the output, by their data addresses on the ATmega328P.
enum { MOTOR_REGISTERS = 10 };
extern const uint8_t motor_registers[MOTOR_REGISTERS];

// Read duty and direction from the chip's data memory; return true if one of them has changed.
bool motor_read(struct motor *m, const uint8_t *data);

// Return the force on the handle [N].
double motor_force(const struct motor *m);

// Report a timer mode that is not modelled on standard error.
void motor_complain(const struct motor *m, const uint8_t *data, double seconds);
