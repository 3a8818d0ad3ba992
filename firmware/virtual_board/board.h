// Virtual board: the Hapkit firmware in the simulator simavr, connected to a simulated paddle.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

// The whole board: chip, paddle, sensor, motor, cable, log.
#pragma once

#include "as5048a.h"
#include "link.h"
#include "motor.h"
#include "options.h"
#include "physics.h"
#include "sensor.h"
#include "spi.h"
#include "truth.h"
#include "uart.h"

#include <sim_avr.h>
#include <stdbool.h>

// Number of cycles that simavr runs per call: one instruction, so that every event is handled at its cycle.
enum { CHUNK = 1 };
enum { FREQUENCY = 16000000, MILLIVOLTS = 5000, VECTORS = 26 };

struct board {
	avr_t *avr;
	struct uart uart;
	struct link link;
	struct plant plant;
	struct sensor sensor;
	struct misreading misreading;
	struct motor motor;
	struct truth truth;

	struct spi spi;
	struct as5048a hall;
	int steps;                       // steps of the encoder, as its pins show them
	const char *eeprom;              // file of the EEPROM; NULL means none

	avr_irq_t *sensor_pin;
	avr_cycle_count_t plant_cycle;   // cycle up to which the paddle has been advanced
	avr_cycle_count_t log_cycles;    // period of the log; 0 writes a row per conversion
	avr_cycle_count_t next_row;
	int converted;                   // last value read from the sensor

	avr_cycle_count_t off_since;     // cycle at which interrupts were disabled; 0 while they are enabled
	bool started;                    // interrupts have been enabled at least once
	avr_flashaddr_t off_pc;
	// longest time with disabled interrupts, and the program counter at its start
	avr_cycle_count_t longest_off;
	avr_flashaddr_t longest_off_pc;
	avr_cycle_count_t asleep;        // cycles in which the processor slept
	unsigned stack, stack_stays;     // the stack pointer, and the number of instructions since it changed
	unsigned lowest_stack;           // its lowest value since interrupts were first enabled
	// how often the motor was switched off after 20 ms without a byte from the computer
	unsigned silent_offs;
	bool quit, frozen;
	// number of bytes sent since the cable was plugged in, as reported by the computer; negative without a
	// report
	double announced;
	// the cable behaves like a real one: opening the port resets the board, and baud rates must agree
	bool adapter;
	// simavr's function, which it replaces by a reset when the watchdog expires
	avr_run_t run_one;
};

// Load the firmware and connect everything except the cable. Exit with a message if the file is not a
// firmware.
void board_start(struct board *b, const struct options *o);

// Run the chip up to a cycle; with stop_at_frame, stop earlier when a frame that needs an answer has been
// sent.
void board_run(struct board *b, avr_cycle_count_t until, bool stop_at_frame);

// Press the reset button.
void board_reset(struct board *b);

// Advance the paddle to the chip's present cycle.
void board_sync(struct board *b);

// Write a row of the truth log.
void board_log(struct board *b);

double board_seconds(const struct board *b);
