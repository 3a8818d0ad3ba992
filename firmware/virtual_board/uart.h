// Virtual board: the Hapkit firmware in simavr with the paddle around it.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

// The chip's serial port with bit-time accuracy: shift registers, one byte of transmit buffer, two of
// receive.
#pragma once

#include <sim_avr.h>
#include <avr_uart.h>
#include <stdbool.h>
#include <stdint.h>

enum { UART_FIFO = 2 };

struct uart {
	avr_t *avr;
	avr_uart_t *chip;             // simavr's own port: only its interrupt vectors are used, not its timing
	// Callbacks: a byte was sent; get the next byte for the board, or -1.
	void (*sent)(void *outside, uint8_t byte);
	int (*next)(void *outside);
	void *outside;

	// baud rate of the computer [bit/s], 0: any; bytes at a different rate are misread
	unsigned line_speed;
	bool sending, buffered;       // transmit shift register and buffer are occupied
	uint8_t shifting, buffer;
	uint8_t fifo[UART_FIFO];
	int filled;                   // number of bytes in the receive buffer
	bool waiting;                 // a third byte waits in the receive shift register
	uint8_t waiting_byte;
	int arriving;                 // byte on the line, -1: idle

	uint64_t received, transmitted;
	uint64_t overruns;            // bytes lost because the firmware read too late
	uint64_t deaf;                // bytes lost because the receiver was disabled
	uint64_t overwritten;         // bytes lost because the firmware wrote into a full buffer
	avr_cycle_count_t last_received;
};

// Replace simavr's serial port of the chip. Call uart_reset after every reset of the chip.
void uart_attach(struct uart *u, avr_t *avr, avr_uart_t *chip);
void uart_reset(struct uart *u);

// Check for a byte to receive if the line is idle.
void uart_poll(struct uart *u);
