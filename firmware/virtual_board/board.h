// Virtual board: the Hapkit firmware in simavr with the paddle around it.
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

// Cycles that simavr runs without looking up: an instruction, so that everything is seen when it happens.
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
	int steps;                       // of the encoder, as its pins say
	const char *eeprom;              // file, NULL: none

	avr_irq_t *sensor_pin;
	avr_cycle_count_t plant_cycle;   // up to which the paddle has moved
	avr_cycle_count_t log_cycles;    // period of the log, 0: at every conversion
	avr_cycle_count_t next_row;
	int converted;                   // last value that was read of the sensor

	avr_cycle_count_t off_since;     // interrupts off since, 0: on
	bool started;                    // interrupts have been on once
	avr_flashaddr_t off_pc;
	avr_cycle_count_t longest_off;   // and where it began
	avr_flashaddr_t longest_off_pc;
	avr_cycle_count_t asleep;        // cycles in which the processor slept
	unsigned stack, stack_stays;     // stack pointer, and for how many instructions it has been there
	unsigned lowest_stack;           // lowest one seen once interrupts were on
	unsigned silent_offs;            // motor off after 20 ms without a byte from the computer
	bool quit, frozen;
	double told;                     // bytes that the computer says it has sent since the plug; negative: nothing
	bool adapter;                    // a real cable: opening the port resets, speeds must agree
	avr_run_t run_one;               // simavr replaces its own to reset by watchdog
};

// Load the firmware and connect everything but the cable. Exits with a message if the file is no firmware.
void board_start(struct board *b, const struct options *o);

// Run the chip up to a cycle, or until a frame that wants an answer has gone out, if so asked.
void board_run(struct board *b, avr_cycle_count_t until, bool stop_at_frame);

// Press the reset button.
void board_reset(struct board *b);

// Let the paddle move up to the chip's present cycle.
void board_sync(struct board *b);

// Write a row of the truth log.
void board_log(struct board *b);

double board_seconds(const struct board *b);
