// Virtual board: the Hapkit firmware in the simulator simavr, connected to a simulated paddle.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

// The chip's SPI port as master, accurate to the cycle, with one device that D10 selects.
#pragma once

#include <sim_avr.h>
#include <stdbool.h>
#include <stdint.h>

struct spi {
	avr_t *avr;
	avr_int_vector_t *vector;
	// Callbacks of the device. select: the device was selected or deselected. exchange: eight bits were shifted
	// in both directions; take the received byte and return the device's next byte.
	void (*select)(void *device, bool selected);
	uint8_t (*exchange)(void *device, uint8_t byte);
	void *device;

	bool selected, shifting;
	uint8_t leaving;
	avr_cycle_count_t changed;  // time of the last change of selection
	// number of selections and clocks that are within 350 ns of each other, so that the result is undefined
	unsigned hasty;
	unsigned overwritten;       // number of bytes written while another byte was being shifted
};

// Replace simavr's SPI port, which takes 100 us per byte. Call spi_reset after every reset.
void spi_attach(struct spi *s, avr_t *avr);
void spi_reset(struct spi *s);
