// Virtual board: the Hapkit firmware in the simulator simavr, connected to a simulated paddle.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

// An AS5048A at the SPI port: frames have 16 bits with even parity, and replies come one frame later.
#pragma once

#include "spi.h"

struct as5048a {
	int (*angle)(void *outside);  // present angle, 0..16383
	void *outside;
	double flip;                  // probability that a bit of a reply is inverted on the bus
	bool absent;                  // no sensor is connected
	uint64_t random;

	bool error;                   // stays set until it is cleared
	uint16_t command, answer;
	int bytes;                    // number of received bytes of the present frame
	uint64_t frames, turned;      // number of complete frames; number of replies with an inverted bit
};

void as5048a_select(void *device, bool selected);
uint8_t as5048a_exchange(void *device, uint8_t byte);
