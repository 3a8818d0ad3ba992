// Virtual board: the Hapkit firmware in simavr with the paddle around it.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

// An AS5048A at the SPI port: frames of 16 bits with even parity, answers one frame late.
#pragma once

#include "spi.h"

struct as5048a {
	int (*angle)(void *outside);  // 0..16383, at this moment
	void *outside;
	double flip;                  // probability that a bit of an answer is turned on its way
	bool absent;                  // nothing is connected
	uint64_t random;

	bool error;                   // stands until it is cleared
	uint16_t command, answer;
	int bytes;                    // of the frame so far
	uint64_t frames, turned;      // whole frames; answers in which a bit was turned
};

void as5048a_select(void *device, bool selected);
uint8_t as5048a_exchange(void *device, uint8_t byte);
