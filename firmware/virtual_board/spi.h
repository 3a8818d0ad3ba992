// Virtual board: the Hapkit firmware in simavr with the paddle around it.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

// The chip's SPI port as master, cycle-accurate, with one device, selected by D10.
#pragma once

#include <sim_avr.h>
#include <stdbool.h>
#include <stdint.h>

struct spi {
	avr_t *avr;
	avr_int_vector_t *vector;
	// The device: selected or deselected; a byte exchanged with it, after both have been shifted.
	void (*select)(void *device, bool selected);
	uint8_t (*exchange)(void *device, uint8_t byte);
	void *device;

	bool selected, shifting;
	uint8_t leaving;
	avr_cycle_count_t changed;  // time of the last change of selection
	unsigned hasty;             // selections and clocks within 350 ns of each other: the result is undefined
	unsigned overwritten;       // bytes written while another byte was being shifted
};

// Replace simavr's SPI port, which takes 100 us per byte. Call spi_reset after every reset.
void spi_attach(struct spi *s, avr_t *avr);
void spi_reset(struct spi *s);
