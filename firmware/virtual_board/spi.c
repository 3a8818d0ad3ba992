// Virtual board: the Hapkit firmware in the simulator simavr, connected to a simulated paddle.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

#include "spi.h"

#include <avr_spi.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { DDRB = 0x24, PORTB = 0x25, SPCR = 0x4c, SPSR = 0x4d, SPDR = 0x4e, SELECT = 1 << 2 };
enum { SPE = 1 << 6, MSTR = 1 << 4, CPOL = 1 << 3, CPHA = 1 << 2, SPIF = 1 << 7, WCOL = 1 << 6, SPI2X = 1 };
enum { HASTE = 5 };  // number of whole cycles in 350 ns

static unsigned cycles_per_bit(const uint8_t *data)
{
	static const unsigned DIVIDER[] = {4, 16, 64, 128};
	unsigned divider = DIVIDER[data[SPCR] & 3];
	return data[SPSR] & SPI2X ? divider / 2 : divider;
}

static avr_cycle_count_t shifted(avr_t *avr, avr_cycle_count_t when, void *param)
{
	struct spi *s = param;
	(void)when;
	uint8_t answer = 0xff;  // the line is not driven, so the pull-up makes it high
	// the device samples data at the falling edge of a clock that is low when idle
	bool understood = (avr->data[SPCR] & (CPOL | CPHA)) == CPHA && s->selected;
	if (understood)
		answer = s->exchange(s->device, s->leaving);
	avr->data[SPDR] = answer;
	s->shifting = false;
	avr_raise_interrupt(avr, s->vector);
	return 0;
}

static void write_data(avr_t *avr, avr_io_addr_t addr, uint8_t value, void *param)
{
	struct spi *s = param;
	(void)addr;
	if ((avr->data[SPCR] & (SPE | MSTR)) != (SPE | MSTR))
		return;
	if (s->shifting) {
		s->overwritten++;
		avr->data[SPSR] |= WCOL;
		return;
	}
	if (s->vector->pending)
		avr_clear_interrupt(avr, s->vector);
	avr->data[SPSR] &= (uint8_t)~(SPIF | WCOL);
	if (avr->cycle - s->changed <= HASTE)
		s->hasty++;
	s->shifting = true;
	s->leaving = value;
	avr_cycle_timer_register(avr, 8 * cycles_per_bit(avr->data), shifted, s);
}

static uint8_t read_data(avr_t *avr, avr_io_addr_t addr, void *param)
{
	struct spi *s = param;
	if (s->vector->pending)
		avr_clear_interrupt(avr, s->vector);
	avr->data[SPSR] &= (uint8_t)~SPIF;
	return avr->data[addr];
}

static void write_status(avr_t *avr, avr_io_addr_t addr, uint8_t value, void *param)
{
	(void)param;
	avr->data[addr] = (uint8_t)((avr->data[addr] & ~SPI2X) | (value & SPI2X));
}

// If the interrupt is enabled while its flag is set, it is triggered.
static void write_control(avr_t *avr, avr_io_addr_t addr, uint8_t value, void *param)
{
	struct spi *s = param;
	avr->data[addr] = value;
	if (avr->data[SPSR] & SPIF)
		avr_raise_interrupt(avr, s->vector);
}

static void pins_touched(avr_irq_t *irq, uint32_t value, void *param)
{
	struct spi *s = param;
	const uint8_t *data = s->avr->data;
	(void)irq;
	(void)value;
	bool selected = (data[DDRB] & SELECT) && !(data[PORTB] & SELECT);
	if (selected == s->selected)
		return;
	if (selected && s->avr->cycle - s->changed <= HASTE)
		s->hasty++;
	s->selected = selected;
	s->changed = s->avr->cycle;
	s->select(s->device, selected);
}

void spi_reset(struct spi *s)
{
	s->shifting = false;
	s->avr->data[SPCR] = s->avr->data[SPSR] = 0;
	pins_touched(NULL, 0, s);
}

static avr_spi_t *find(avr_t *avr)
{
	for (avr_io_t *io = avr->io_port; io; io = io->next)
		if (strcmp(io->kind, "spi") == 0)
			return (avr_spi_t *)io;
	fprintf(stderr, "virtual_board: this simavr has no SPI port in the ATmega328P\n");
	exit(1);
}

static void take_over(avr_t *avr, avr_io_addr_t addr, avr_io_read_t read, avr_io_write_t write, void *s)
{
	avr_io_addr_t io = AVR_DATA_TO_IO(addr);
	avr->io[io].r.c = read;
	avr->io[io].r.param = s;
	avr->io[io].w.c = write;
	avr->io[io].w.param = s;
}

void spi_attach(struct spi *s, avr_t *avr)
{
	s->avr = avr;
	s->vector = &find(avr)->spi;
	take_over(avr, SPDR, read_data, write_data, s);
	take_over(avr, SPSR, NULL, write_status, s);
	take_over(avr, SPCR, NULL, write_control, s);
	avr_irq_register_notify(avr_iomem_getirq(avr, PORTB, NULL, AVR_IOMEM_IRQ_ALL), pins_touched, s);
	avr_irq_register_notify(avr_iomem_getirq(avr, DDRB, NULL, AVR_IOMEM_IRQ_ALL), pins_touched, s);
	spi_reset(s);
}
