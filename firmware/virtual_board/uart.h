// Virtual board: the Hapkit firmware in the simulator simavr, connected to a simulated paddle.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

// The chip's serial port, accurate to the bit: shift registers, a transmit buffer of one byte, a receive
// buffer of two.
#pragma once

#include <sim_avr.h>
#include <avr_uart.h>
#include <stdbool.h>
#include <stdint.h>

enum { UART_FIFO = 2 };

struct uart {
	avr_t *avr;
	avr_uart_t *chip;             // simavr's port, of which only the interrupt vectors are used, not the timing
	// callbacks: a byte was sent; get the next byte for the board, or -1
	void (*sent)(void *outside, uint8_t byte);
	int (*next)(void *outside);
	void *outside;

	// baud rate of the computer [bit/s], 0 for any; bytes at a different rate are misread
	unsigned line_speed;
	bool sending, buffered;       // transmit shift register and buffer are occupied
	uint8_t shifting, buffer;
	uint8_t fifo[UART_FIFO];
	int filled;                   // number of bytes in the receive buffer
	bool waiting;                 // a third byte waits in the receive shift register
	uint8_t waiting_byte;
	int arriving;                 // the byte on the line; -1 while the line is idle

	uint64_t received, transmitted;
	uint64_t overruns;            // number of bytes lost because the firmware read too late
	uint64_t deaf;                // number of bytes lost because the receiver was disabled
	uint64_t overwritten;         // number of bytes lost because the firmware wrote into a full buffer
	avr_cycle_count_t last_received;
};

// Replace simavr's serial port of the chip. Call uart_reset after every reset of the chip.
void uart_attach(struct uart *u, avr_t *avr, avr_uart_t *chip);
void uart_reset(struct uart *u);

// If the line is idle, check for a byte to receive.
void uart_poll(struct uart *u);
