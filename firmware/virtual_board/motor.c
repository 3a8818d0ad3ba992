// Virtual board: the Hapkit firmware in the simulator simavr, connected to a simulated paddle.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

// simavr generates no events in phase-correct mode, so the duty is read from the timer's registers.

#include "motor.h"

#include <math.h>
#include <stdio.h>

enum {
	DDRB = 0x24, PORTB = 0x25, DDRD = 0x2a, PORTD = 0x2b,
	TCCR0A = 0x44, TCCR0B = 0x45, OCR0B = 0x48, TCCR2A = 0xb0, TCCR2B = 0xb1, OCR2B = 0xb4,
};
enum { WGM2 = 1 << 3, PHASE_CORRECT_255 = 1, NO_PRESCALER = 1 };

struct pins {
	const char *name;
	int timer;
	uint8_t pwm, direction;  // bits of port D and port B
	uint8_t a, b, compare;   // registers of the timer
};

static const struct pins NEW_PINS = {"D5", 0, 1 << 5, 1 << 0, TCCR0A, TCCR0B, OCR0B};
static const struct pins OLD_PINS = {"D3", 2, 1 << 3, 1 << 4, TCCR2A, TCCR2B, OCR2B};

const uint8_t motor_registers[MOTOR_REGISTERS] = {DDRB,   PORTB, DDRD,   PORTD,  TCCR0A,
                                                  TCCR0B, OCR0B, TCCR2A, TCCR2B, OCR2B};

static const struct pins *pins_of(const struct motor *m)
{
	return m->old_pins ? &OLD_PINS : &NEW_PINS;
}

static int pin_duty(struct motor *m, const uint8_t *data)
{
	const struct pins *p = pins_of(m);
	uint8_t a = data[p->a], b = data[p->b];
	int compare = (a >> 4) & 3;
	m->known = true;
	if (!(data[DDRD] & p->pwm))
		return 0;
	if (compare == 0)
		return data[PORTD] & p->pwm ? 255 : 0;
	m->known = compare >= 2 && (a & 3) == PHASE_CORRECT_255 && !(b & WGM2) && (b & 7) == NO_PRESCALER;
	return compare == 3 ? 255 - data[p->compare] : data[p->compare];
}

bool motor_read(struct motor *m, const uint8_t *data)
{
	bool was_known = m->known;
	bool high = data[DDRB] & data[PORTB] & pins_of(m)->direction;
	int duty = pin_duty(m, data) * (int)(high ? m->high_direction : -m->high_direction);
	bool changed = duty != m->duty || m->known != was_known;
	m->duty = duty;
	return changed;
}

double motor_force(const struct motor *m)
{
	double share = fmax(fabs((double)m->duty) - m->dead_band, 0.0) / (255.0 - m->dead_band);
	double force = m->full_force * (m->power == 2.0 ? share * share : pow(share, m->power));
	return m->duty < 0 ? -force : force;
}

void motor_complain(const struct motor *m, const uint8_t *data, double seconds)
{
	const struct pins *p = pins_of(m);
	fprintf(stderr,
	        "virtual_board: %s is driven by timer %d in a mode that is not modelled: TCCR%dA = 0x%02x, "
	        "TCCR%dB = 0x%02x (8-bit phase-correct, prescaler 1, is) at %.6f s\n",
	        p->name, p->timer, p->timer, data[p->a], p->timer, data[p->b], seconds);
}
