// Virtual board: the Hapkit firmware in the simulator simavr, connected to a simulated paddle.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

// The equation M x" + c x' + k x = f0 + f1 t - sigma Fc is linear between events (a stop of the motion, an
// end stop, the end of the target's ramp). Each piece is a power series in s = t / h. The series is exact to
// rounding, because h is short compared to the system's time constants. The events are roots of the series.

#include "physics.h"

#include <math.h>

enum { ORDER = 20, HALVINGS = 60, MAX_EVENTS = 10000 };

struct series {
	double h;
	double c[ORDER + 1];  // x(s) = sum of c[n] s^n
};

struct piece {
	double mass, damping, stiffness;  // handle and hand together
	double f0, f1;                    // N, N/s
};

static double target_rate(const struct plant *p)
{
	return p->ramp > 0.0 ? (p->goal - p->target) / p->ramp : 0.0;
}

static struct piece piece_of(const struct plant *p)
{
	struct piece q = {p->mass, p->viscous, 0.0, p->motor + p->external, 0.0};
	if (p->held) {
		double rate = target_rate(p);
		q.mass += p->hand_mass;
		q.damping += p->hand_damping;
		q.stiffness = p->hand_stiffness;
		q.f0 += p->hand_stiffness * p->target + p->hand_damping * rate;
		q.f1 = p->hand_stiffness * rate;
	}
	return q;
}

static struct series expand(const struct piece *q, double x, double v, double friction, double h)
{
	struct series s = {.h = h, .c = {x, v * h}};
	for (int n = 0; n + 2 <= ORDER; n++) {
		double force = n == 0 ? q->f0 - friction : n == 1 ? q->f1 * h : 0.0;
		double pull = force - q->damping * (n + 1) * s.c[n + 1] / h - q->stiffness * s.c[n];
		s.c[n + 2] = h * h * pull / (q->mass * (n + 1) * (n + 2));
	}
	return s;
}

static double position_at(const struct series *p, double s)
{
	double sum = 0.0;
	for (int n = ORDER; n >= 0; n--)
		sum = sum * s + p->c[n];
	return sum;
}

static double velocity_at(const struct series *p, double s)
{
	double sum = 0.0;
	for (int n = ORDER; n >= 1; n--)
		sum = sum * s + n * p->c[n];
	return sum / p->h;
}

static double acceleration_at(const struct series *p, double s)
{
	double sum = 0.0;
	for (int n = ORDER; n >= 2; n--)
		sum = sum * s + n * (n - 1) * p->c[n];
	return sum / (p->h * p->h);
}

// Return the root of f - level between low, where sign * (f - level) > 0, and high, where it is <= 0.
static double root(double (*f)(const struct series *, double), const struct series *p, double level,
                   double sign, double low, double high)
{
	for (int i = 0; i < HALVINGS; i++) {
		double middle = 0.5 * (low + high);
		if (sign * (f(p, middle) - level) > 0.0)
			low = middle;
		else
			high = middle;
	}
	return high;
}

// Return the first s in (0, 1] at which a motion with this sign stops; 2 if it does not stop.
static double rest_at(const struct series *p, double v, double sign)
{
	double end = sign * velocity_at(p, 1.0);
	double a0 = sign * acceleration_at(p, 0.0), a1 = sign * acceleration_at(p, 1.0);
	if (end <= 0.0) {
		double from = v == 0.0 ? root(acceleration_at, p, 0.0, sign, 0.0, 1.0) : 0.0;
		return root(velocity_at, p, 0.0, sign, from, 1.0);
	}
	if (v != 0.0 && a0 < 0.0 && a1 > 0.0) {
		double lowest = root(acceleration_at, p, 0.0, -sign, 0.0, 1.0);
		if (sign * velocity_at(p, lowest) <= 0.0)
			return root(velocity_at, p, 0.0, sign, 0.0, lowest);
	}
	return 2.0;
}

// Return the first s in (0, 1] at which the handle reaches an end stop; 2 if it reaches none.
static double stop_at(const struct series *p, double stop)
{
	double end = position_at(p, 1.0);
	if (fabs(end) <= stop)
		return 2.0;
	double sign = end > 0.0 ? 1.0 : -1.0;
	return root(position_at, p, sign * stop, -sign, 0.0, 1.0);
}

// Return the time in s for which a resting handle sticks; also return the direction of its motion afterwards.
static double stuck_for(const struct plant *p, const struct piece *q, double *direction)
{
	double net = q->f0 - q->stiffness * p->x;
	double low = p->x <= -p->stop ? -INFINITY : -p->coulomb;
	double high = p->x >= p->stop ? INFINITY : p->coulomb;
	*direction = net > high ? 1.0 : net < low ? -1.0 : q->f1 > 0.0 ? 1.0 : -1.0;
	if (net > high || net < low)
		return 0.0;
	if (q->f1 == 0.0)
		return INFINITY;
	return ((q->f1 > 0.0 ? high : low) - net) / q->f1;
}

// Advance one piece of at most h seconds, up to the next event; return the duration of the piece.
static double advance_piece(struct plant *p, double h)
{
	struct piece q = piece_of(p);
	double sign = p->v > 0.0 ? 1.0 : -1.0;
	if (p->v == 0.0) {
		double stuck = stuck_for(p, &q, &sign);
		if (stuck > 1e-12)
			return fmin(stuck, h);
	}
	double rate = fmax(sqrt(q.stiffness / q.mass), q.damping / q.mass);
	h = fmin(h, 0.5 / fmax(rate, 1e-9));
	struct series s = expand(&q, p->x, p->v, sign * p->coulomb, h);
	double rest = p->coulomb > 0.0 ? rest_at(&s, p->v, sign) : 2.0;
	double stop = stop_at(&s, p->stop);
	double event = fmin(1.0, fmin(rest, stop));
	p->x = stop <= event ? copysign(p->stop, position_at(&s, event)) : position_at(&s, event);
	p->v = rest <= event || stop <= event ? 0.0 : velocity_at(&s, event);
	return event * h;
}

static void advance_target(struct plant *p, double dt)
{
	if (p->ramp <= dt) {
		p->target = p->goal;
		p->ramp = 0.0;
	} else {
		p->target += dt * target_rate(p);
		p->ramp -= dt;
	}
}

void plant_aim(struct plant *p, double goal, double seconds)
{
	p->goal = goal;
	p->ramp = seconds > 0.0 ? seconds : 0.0;
	if (p->ramp == 0.0)
		p->target = goal;
}

void plant_advance(struct plant *p, double dt)
{
	for (int i = 0; dt > 0.0 && i < MAX_EVENTS; i++) {
		double h = p->ramp > 0.0 ? fmin(dt, p->ramp) : dt;
		if (p->prescribed) {
			p->v = target_rate(p);
			p->x = p->target + h * p->v;
		} else {
			h = advance_piece(p, h);
		}
		advance_target(p, h);
		dt -= h;
	}
}

double plant_hand_force(const struct plant *p)
{
	if (!p->held)
		return 0.0;
	return p->hand_stiffness * (p->target - p->x) + p->hand_damping * (target_rate(p) - p->v);
}
