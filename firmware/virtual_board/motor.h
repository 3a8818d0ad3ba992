// Virtual board: the Hapkit firmware in simavr with the paddle around it.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

// From the chip's registers to the motor's force: PWM on D5 (OC0B), direction on D8 (PB0).
#pragma once

#include <stdbool.h>
#include <stdint.h>

struct motor {
	double full_force;      // N at the handle at full duty; force = full_force * duty^2
	double high_direction;  // +1 or -1: sign of the force while D8 is high
	int duty;               // signed, of 255
	bool known;             // false: the output is on in a timer mode that is not modelled
};

// The registers from which the output follows, by their data addresses on the ATmega328P.
enum {
	REG_DDRB = 0x24, REG_PORTB = 0x25, REG_DDRD = 0x2a, REG_PORTD = 0x2b,
	REG_TCCR0A = 0x44, REG_TCCR0B = 0x45, REG_OCR0B = 0x48,
};
extern const uint8_t motor_registers[7];

// Read duty and direction from the chip's data memory; true if anything changed.
bool motor_read(struct motor *m, const uint8_t *data);

// Force on the handle [N].
double motor_force(const struct motor *m);
