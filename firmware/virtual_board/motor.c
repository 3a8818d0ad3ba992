// Virtual board: the Hapkit firmware in simavr with the paddle around it.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

// simavr gives no events in phase-correct mode, so the duty is read from the timer's own registers.

#include "motor.h"

enum { BIT_D5 = 1 << 5, BIT_D8 = 1 << 0, WGM02 = 1 << 3, PHASE_CORRECT_255 = 1, NO_PRESCALER = 1 };

const uint8_t motor_registers[7] = {REG_DDRB,   REG_PORTB,  REG_DDRD, REG_PORTD,
                                    REG_TCCR0A, REG_TCCR0B, REG_OCR0B};

static int pin_duty(struct motor *m, const uint8_t *data)
{
	uint8_t a = data[REG_TCCR0A], b = data[REG_TCCR0B];
	int compare = (a >> 4) & 3;
	m->known = true;
	if (!(data[REG_DDRD] & BIT_D5))
		return 0;
	if (compare == 0)
		return data[REG_PORTD] & BIT_D5 ? 255 : 0;
	m->known = compare >= 2 && (a & 3) == PHASE_CORRECT_255 && !(b & WGM02) && (b & 7) == NO_PRESCALER;
	return compare == 3 ? 255 - data[REG_OCR0B] : data[REG_OCR0B];
}

bool motor_read(struct motor *m, const uint8_t *data)
{
	bool was_known = m->known;
	bool high = data[REG_DDRB] & data[REG_PORTB] & BIT_D8;
	int duty = pin_duty(m, data) * (int)(high ? m->high_direction : -m->high_direction);
	bool changed = duty != m->duty || m->known != was_known;
	m->duty = duty;
	return changed;
}

double motor_force(const struct motor *m)
{
	double duty = m->duty / 255.0;
	return m->duty < 0 ? -m->full_force * duty * duty : m->full_force * duty * duty;
}
