// Virtual board: the Hapkit firmware in the simulator simavr, connected to a simulated paddle.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

// simavr's serial port has a receive buffer of 64 bytes and bytes that take 11 bits. The chip has neither,
// and this program tests whether the firmware reads in time. Therefore the three registers are replaced.

#include "uart.h"

#include <string.h>

enum { UDRE = 1 << 5, TXC = 1 << 6, RXC = 1 << 7, DOR = 1 << 3, WRITABLE_A = 0x03 };
enum { TXEN = 1 << 3, RXEN = 1 << 4, UDRIE = 1 << 5, RXCIE = 1 << 7, BITS_PER_BYTE = 10 };

static uint8_t *status(struct uart *u)
{
	return &u->avr->data[u->chip->r_ucsra];
}

static uint8_t control(const struct uart *u)
{
	return u->avr->data[u->chip->r_ucsrb];
}

static avr_cycle_count_t byte_cycles(const struct uart *u)
{
	const uint8_t *data = u->avr->data;
	unsigned divisor = data[u->chip->ubrrl.reg] | (data[u->chip->ubrrh.reg] & 0x0f) << 8;
	unsigned per_bit = data[u->chip->r_ucsra] & 2 ? 8 : 16;
	return (avr_cycle_count_t)(divisor + 1) * per_bit * BITS_PER_BYTE;
}

// Return the value that is received for a byte sent at a different baud rate; a receiver tolerates up to 4 %.
static uint8_t on_the_line(const struct uart *u, uint8_t byte)
{
	double own = (double)u->avr->frequency * BITS_PER_BYTE / (double)byte_cycles(u);
	double ratio = u->line_speed ? own / u->line_speed : 1.0;
	return ratio > 0.96 && ratio < 1.04 ? byte : (uint8_t)~(byte << 3);
}

// An interrupt is requested while its flag is set. When it is served, the flag of the last request is cleared
// here.
static void ask(struct uart *u)
{
	if (*status(u) & RXC)
		avr_raise_interrupt(u->avr, &u->chip->rxc);
	if (*status(u) & UDRE)
		avr_raise_interrupt(u->avr, &u->chip->udrc);
	if (*status(u) & TXC)
		avr_raise_interrupt(u->avr, &u->chip->txc);
}

static void withdraw(struct uart *u, avr_int_vector_t *vector, uint8_t flag)
{
	if (vector->pending)
		avr_clear_interrupt(u->avr, vector);
	*status(u) &= (uint8_t)~flag;
}

static void begin_byte(struct uart *u)
{
	u->shifting = u->buffer;
	u->buffered = false;
	*status(u) |= UDRE;
	ask(u);
}

static avr_cycle_count_t byte_left(avr_t *avr, avr_cycle_count_t when, void *param)
{
	struct uart *u = param;
	(void)avr;
	u->transmitted++;
	u->sent(u->outside, on_the_line(u, u->shifting));
	u->sending = u->buffered;
	if (!u->buffered) {
		avr_raise_interrupt(u->avr, &u->chip->txc);
		return 0;
	}
	begin_byte(u);
	return when + byte_cycles(u);
}

static avr_cycle_count_t bit_began(avr_t *avr, avr_cycle_count_t when, void *param)
{
	struct uart *u = param;
	begin_byte(u);
	avr_cycle_timer_register(avr, byte_cycles(u) - (avr->cycle - when), byte_left, u);
	return 0;
}

// The transmitter's bit clock runs continuously, so a byte may wait for up to one bit before an idle shift
// register takes it; the data sheet promises nothing better. Until then the buffer is full.
static void write_data(avr_t *avr, avr_io_addr_t addr, uint8_t value, void *param)
{
	struct uart *u = param;
	(void)addr;
	if (!(control(u) & TXEN))
		return;
	if (u->buffered) {
		u->overwritten++;
		return;
	}
	u->buffered = true;
	u->buffer = value;
	withdraw(u, &u->chip->udrc, UDRE);
	if (u->sending)
		return;
	u->sending = true;
	avr_cycle_count_t bit = byte_cycles(u) / BITS_PER_BYTE;
	avr_cycle_timer_register(avr, bit - avr->cycle % bit, bit_began, u);
}

static void store(struct uart *u, uint8_t byte)
{
	if (u->filled < UART_FIFO) {
		u->fifo[u->filled++] = byte;
		*status(u) |= RXC;
		ask(u);
	} else {
		u->waiting = true;
		u->waiting_byte = byte;
	}
}

static void overrun(struct uart *u)
{
	u->overruns++;
	*status(u) |= DOR;
}

static avr_cycle_count_t byte_arrived(avr_t *avr, avr_cycle_count_t when, void *param)
{
	struct uart *u = param;
	u->received++;
	u->last_received = avr->cycle;
	if (!(control(u) & RXEN))
		u->deaf++;
	else if (u->waiting)
		overrun(u);
	else
		store(u, on_the_line(u, (uint8_t)u->arriving));
	u->arriving = u->next(u->outside);
	return u->arriving < 0 ? 0 : when + byte_cycles(u);
}

static uint8_t read_data(avr_t *avr, avr_io_addr_t addr, void *param)
{
	struct uart *u = param;
	uint8_t byte = u->fifo[0];
	*status(u) &= (uint8_t)~DOR;
	if (u->filled > 0) {
		u->filled--;
		u->fifo[0] = u->fifo[1];
	}
	if (u->waiting) {
		u->waiting = false;
		store(u, u->waiting_byte);
	}
	if (u->filled == 0)
		withdraw(u, &u->chip->rxc, RXC);
	ask(u);
	avr->data[addr] = byte;
	return byte;
}

static uint8_t read_status(avr_t *avr, avr_io_addr_t addr, void *param)
{
	(void)param;
	return avr->data[addr];
}

static void write_status(avr_t *avr, avr_io_addr_t addr, uint8_t value, void *param)
{
	struct uart *u = param;
	avr->data[addr] = (uint8_t)((avr->data[addr] & ~WRITABLE_A) | (value & WRITABLE_A));
	if (value & TXC)
		withdraw(u, &u->chip->txc, TXC);
}

static void write_control(avr_t *avr, avr_io_addr_t addr, uint8_t value, void *param)
{
	struct uart *u = param;
	avr->data[addr] = value;
	if (!(value & RXEN)) {
		u->filled = 0;
		u->waiting = false;
		withdraw(u, &u->chip->rxc, RXC);
	}
	ask(u);
}

// A level-triggered interrupt fires again if its handler ended without serving it.
static void handler_ended(avr_irq_t *irq, uint32_t running, void *param)
{
	(void)irq;
	if (!running)
		ask(param);
}

void uart_poll(struct uart *u)
{
	if (u->arriving >= 0)
		return;
	u->arriving = u->next(u->outside);
	if (u->arriving >= 0)
		avr_cycle_timer_register(u->avr, byte_cycles(u), byte_arrived, u);
}

void uart_reset(struct uart *u)
{
	u->sending = u->buffered = u->waiting = false;
	u->filled = 0;
	u->arriving = -1;
	*status(u) = UDRE;
	u->avr->data[u->chip->r_ucsrb] = 0;
}

static void take_over(avr_t *avr, avr_io_addr_t addr, avr_io_read_t read, avr_io_write_t write, void *u)
{
	avr_io_addr_t io = AVR_DATA_TO_IO(addr);
	if (read) {
		avr->io[io].r.c = read;
		avr->io[io].r.param = u;
	}
	avr->io[io].w.c = write;
	avr->io[io].w.param = u;
}

void uart_attach(struct uart *u, avr_t *avr, avr_uart_t *chip)
{
	u->avr = avr;
	u->chip = chip;
	take_over(avr, chip->r_udr, read_data, write_data, u);
	take_over(avr, chip->r_ucsra, read_status, write_status, u);
	take_over(avr, chip->r_ucsrb, NULL, write_control, u);
	avr_irq_register_notify(chip->rxc.irq + AVR_INT_IRQ_RUNNING, handler_ended, u);
	avr_irq_register_notify(chip->udrc.irq + AVR_INT_IRQ_RUNNING, handler_ended, u);
	uart_reset(u);
}
