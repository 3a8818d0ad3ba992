// Virtual board: the Hapkit firmware in the simulator simavr, connected to a simulated paddle.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

#include "board.h"
#include "eeprom.h"
#include "loader.h"
#include "reading.h"
#include "reset.h"

#include <math.h>
#include <sim_core.h>
#include <sim_irq.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { R_SMCR = 0x53, SLEEP_ENABLE = 1 };
enum { SETTLING = 160, SILENCE = FREQUENCY / 50, EXIT_UNKNOWN_MODE = 3, EXIT_CRASHED = 4 };

double board_seconds(const struct board *b)
{
	return (double)b->avr->cycle / FREQUENCY;
}

void board_sync(struct board *b)
{
	avr_cycle_count_t now = b->avr->cycle;
	plant_advance(&b->plant, (double)(now - b->plant_cycle) / FREQUENCY);
	b->plant_cycle = now;
}

void board_log(struct board *b)
{
	board_sync(b);
	const double row[TRUTH_COLUMNS] = {
		board_seconds(b),  b->plant.x,     b->plant.v,
		b->plant.motor,    b->motor.duty,  plant_hand_force(&b->plant),
		b->plant.target,   b->converted,
	};
	truth_write(&b->truth, row);
}

static _Noreturn void give_up(struct board *b, int code)
{
	link_unplug(&b->link);
	truth_close(&b->truth);
	eeprom_save(b->avr, b->eeprom);
	exit(code);
}

static avr_cycle_count_t output_settled(avr_t *avr, avr_cycle_count_t when, void *param)
{
	struct board *b = param;
	(void)when;
	if (b->motor.known)
		return 0;
	motor_complain(&b->motor, avr->data, board_seconds(b));
	give_up(b, EXIT_UNKNOWN_MODE);
}

static void registers_touched(avr_irq_t *irq, uint32_t value, void *param)
{
	struct board *b = param;
	(void)irq;
	(void)value;
	int before = b->motor.duty;
	if (!motor_read(&b->motor, b->avr->data))
		return;
	board_sync(b);
	b->plant.motor = motor_force(&b->motor);
	if (before && !b->motor.duty && b->avr->cycle - b->uart.last_received > SILENCE)
		b->silent_offs++;
	if (!b->motor.known)
		avr_cycle_timer_register(b->avr, SETTLING, output_settled, b);
}

// simavr enters a handler in zero time; the chip needs four cycles.
static void handler_entered(avr_irq_t *irq, uint32_t running, void *param)
{
	struct board *b = param;
	(void)irq;
	if (running)
		b->avr->cycle += 4;
}

// Interrupts were disabled at this cycle, or by an instruction before the next cycle.
static void note_off(struct board *b, avr_cycle_count_t cycle, avr_flashaddr_t pc)
{
	if (b->started && !b->off_since) {
		b->off_since = cycle;
		b->off_pc = pc;
	}
}

static void note_on(struct board *b)
{
	avr_cycle_count_t off = b->off_since ? b->avr->cycle - b->off_since : 0;
	b->started = true;
	b->off_since = 0;
	if (off > b->longest_off) {
		b->longest_off = off;
		b->longest_off_pc = b->off_pc;
	}
}

static _Noreturn void crashed(struct board *b, const char *how)
{
	fprintf(stderr, "virtual_board: the firmware %s at 0x%04x, %.6f s\n", how, b->avr->pc,
	        board_seconds(b));
	give_up(b, EXIT_CRASHED);
}

// A program changes the stack pointer byte by byte, with one instruction in between. A value is intended if
// it remains for four instructions.
static void watch_stack(struct board *b)
{
	unsigned pointer = b->avr->data[R_SPL] | b->avr->data[R_SPH] << 8;
	b->stack_stays = pointer == b->stack ? b->stack_stays + 1 : 0;
	b->stack = pointer;
	if (b->started && b->stack_stays >= 3 && (b->lowest_stack == 0 || pointer < b->lowest_stack))
		b->lowest_stack = pointer;
}

// After the instruction that follows the enabling of interrupts, simavr waits for one more instruction. The
// chip does not wait, and a program may disable the interrupts again in that instruction.
static void serve_interrupts(struct board *b)
{
	bool behind = b->avr->interrupt_state == -1;
	avr_service_interrupts(b->avr);
	if (behind && b->avr->interrupt_state > 0)
		avr_service_interrupts(b->avr);
}

// A frame that needs an answer ends a sleep: the answer is due now, not at simavr's next event.
static void step(struct board *b, avr_cycle_count_t until, bool stop_at_frame)
{
	avr_t *avr = b->avr;
	avr_cycle_count_t before = avr->cycle;
	avr_flashaddr_t pc = avr->pc, next = pc;
	if (avr->state == cpu_Running)
		next = avr_run_one(avr);
	if (avr->state == cpu_Sleeping && !(avr->data[R_SMCR] & SLEEP_ENABLE))
		avr->state = cpu_Running;  // otherwise simavr would sleep even if sleep is not enabled
	watch_stack(b);
	avr_cycle_count_t idle = avr_cycle_timer_process(avr);
	avr->pc = next;
	if (avr->state == cpu_Sleeping) {
		if (!avr->sreg[S_I])
			crashed(b, "sleeps with interrupts off");
		bool goes_on = until > avr->cycle && !(stop_at_frame && b->link.asked);
		avr_cycle_count_t left = goes_on ? until - avr->cycle : 1;
		avr_cycle_count_t nap = idle && idle < left ? idle : left;
		avr->cycle += nap;
		b->asleep += nap;
	} else if (avr->state != cpu_Running) {
		crashed(b, "crashed");
	}
	if (!avr->sreg[S_I]) {
		note_off(b, before, pc);
		return;
	}
	note_on(b);
	before = avr->cycle;
	serve_interrupts(b);
	if (!avr->sreg[S_I])
		note_off(b, before, avr->pc);
}

static avr_cycle_count_t next_look(const struct board *b, avr_cycle_count_t until)
{
	if (b->log_cycles && b->next_row < until)
		until = b->next_row;
	return b->link.due < until ? b->link.due : until;
}

void board_run(struct board *b, avr_cycle_count_t until, bool stop_at_frame)
{
	reset_by_cable(b);
	uart_poll(&b->uart);
	while (b->avr->cycle < until && !(stop_at_frame && b->link.asked)) {
		reset_by_watchdog(b);
		step(b, next_look(b, until), stop_at_frame);
		if (b->avr->cycle >= b->link.due)
			link_tick(&b->link);
		if (b->log_cycles && b->avr->cycle >= b->next_row) {
			board_log(b);
			b->next_row += b->log_cycles;
		}
	}
}

static avr_uart_t *find_uart(avr_t *avr)
{
	for (avr_io_t *io = avr->io_port; io; io = io->next)
		if (strcmp(io->kind, "uart") == 0)
			return (avr_uart_t *)io;
	fprintf(stderr, "virtual_board: this simavr has no serial port in the ATmega328P\n");
	exit(1);
}

static void connect(struct board *b)
{
	avr_t *avr = b->avr;
	avr->run_cycle_limit = CHUNK;
	for (unsigned i = 0; i < MOTOR_REGISTERS; i++)
		avr_irq_register_notify(avr_iomem_getirq(avr, motor_registers[i], NULL, AVR_IOMEM_IRQ_ALL),
		                        registers_touched, b);
	for (uint8_t v = 1; v < VECTORS; v++) {
		avr_irq_t *irq = avr_get_interrupt_irq(avr, v);
		if (irq)
			avr_irq_register_notify(irq + AVR_INT_IRQ_RUNNING, handler_entered, b);
	}
	reading_attach(b);
	b->uart.sent = link_sent;
	b->uart.next = link_next;
	b->uart.outside = &b->link;
	uart_attach(&b->uart, avr, find_uart(avr));
}

static void set_up(struct board *b, const struct options *o)
{
	double lever = o->sector_radius / (o->handle_radius * o->pulley_radius);
	b->plant = (struct plant){
		.mass = o->mass, .viscous = o->viscous, .coulomb = o->coulomb, .stop = o->stop,
		.x = o->position, .v = o->velocity, .target = o->position,
	};
	b->motor = (struct motor){
		.full_force = o->torque * lever, .high_direction = o->direction < 0 ? -1 : 1, .known = true,
		.power = o->motor_power, .dead_band = o->dead_band, .old_pins = o->pins < 4.0,
	};
	b->sensor = sensor_make(o->sensor, o->counts, (o->sensor_sign < 0 ? -2.0 : 2.0) * M_PI / lever, o->magnet,
	                        o->lowest);
	b->hall.flip = o->spi_flip;
	b->hall.absent = o->sensor != AS5048A || o->sensor_absent != 0.0;
	b->hall.random = (uint64_t)o->seed;
	b->eeprom = o->eeprom;
	b->link.fd = -1;
	b->link.awaited = (int)o->awaited;
	b->link.alias = o->link;
	b->link.to = o->to;
	b->link.from = o->from;
	b->misreading = o->misreading;
	faults_seed(&b->link.to, &b->link.from, &b->misreading, o->seed);
	b->log_cycles = (avr_cycle_count_t)llround(o->log_period * FREQUENCY);
}

void board_start(struct board *b, const struct options *o)
{
	set_up(b, o);
	b->avr = load_firmware(o->firmware, FREQUENCY, MILLIVOLTS);
	if (o->bootloader)
		load_bootloader(b->avr, o->bootloader);
	reset_by_power(b, o->bootloader != NULL);
	eeprom_load(b->avr, o->eeprom);
	eeprom_keep(b->avr, o->eeprom);
	connect(b);
	b->link.clock = &b->avr->cycle;
	link_set_latency(&b->link, (avr_cycle_count_t)llround(o->latency * FREQUENCY));
	truth_open(&b->truth, o->log);
}
