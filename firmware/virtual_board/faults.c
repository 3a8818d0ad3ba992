// Virtual board: the Hapkit firmware in the simulator simavr, connected to a simulated paddle.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

#include "faults.h"

#include <math.h>

enum { LARGEST_READING = 1023 };

// splitmix64 (Steele, Lea, Flood 2014) works with any seed.
static uint64_t draw(uint64_t *state)
{
	uint64_t z = *state += 0x9e3779b97f4a7c15u;
	z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
	z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
	return z ^ (z >> 31);
}

static double uniform(uint64_t *state)
{
	return (double)(draw(state) >> 11) * 0x1p-53;
}

static bool happens(uint64_t *state, double rate)
{
	return rate > 0.0 && uniform(state) < rate;
}

static bool shot(double *left)
{
	if (*left < 1.0)
		return false;
	*left -= 1.0;
	return true;
}

static uint8_t garbled(struct damage *d, uint8_t byte)
{
	if (happens(&d->random, d->burst))
		d->bursting = d->length;
	if (shot(&d->bursting) || shot(&d->garble)) {
		d->hurt++;
		return (uint8_t)draw(&d->random);
	}
	if (happens(&d->random, d->flip)) {
		d->hurt++;
		return byte ^ (uint8_t)(1u << (draw(&d->random) & 7));
	}
	return byte;
}

int damage_pass(struct damage *d, uint8_t byte, uint8_t out[2])
{
	int n = 0;
	if (shot(&d->add) || happens(&d->random, d->insert)) {
		out[n++] = (uint8_t)draw(&d->random);
		d->hurt++;
	}
	if (shot(&d->lose) || happens(&d->random, d->drop)) {
		d->hurt++;
		return n;
	}
	out[n++] = garbled(d, byte);
	return n;
}

// Gaussian numbers by the method of Box and Muller, 1958.
static double gaussian(uint64_t *state)
{
	double radius = sqrt(-2.0 * log1p(-uniform(state)));
	return radius * cos(2.0 * M_PI * uniform(state));
}

// Return a reading that is half a turn away, or in the gap between both ends of the saw tooth, with equal
// probability.
static int jumped(struct misreading *m, int count, int lowest, int range)
{
	if (draw(&m->random) & 1)
		return lowest + (count - lowest + range / 2) % range;
	int gap = lowest + LARGEST_READING - (lowest + range - 1);
	int at = (int)(uniform(&m->random) * gap);
	return at < lowest ? at : at + range;
}

int misread(struct misreading *m, int count, int lowest, int range)
{
	int found = count;
	if (m->stuck != 0.0)
		found = m->last;
	else
		m->last = count;
	if (m->noise > 0.0)
		found += (int)lround(m->noise * gaussian(&m->random));
	if (happens(&m->random, m->jump))
		found = jumped(m, count, lowest, range);
	found = found < 0 ? 0 : found > LARGEST_READING ? LARGEST_READING : found;
	m->wrong += found != count;
	return found;
}

void faults_seed(struct damage *to, struct damage *from, struct misreading *sensor, double seed)
{
	uint64_t start = (uint64_t)seed * 3;
	to->random = draw(&start);
	from->random = draw(&start);
	sensor->random = draw(&start);
}
