// Virtual board: the Hapkit firmware in the simulator simavr, connected to a simulated paddle.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

#include "reading.h"

#include "encoder.h"

#include <avr_adc.h>
#include <avr_extint.h>
#include <avr_timer.h>
#include <sim_core.h>
#include <sim_irq.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { REG_ADCSRA = 0x7a, REG_ADMUX = 0x7c, SENSOR_CHANNEL = 2, CLOCK_VECTOR = 11 };
enum { REG_TIFR1 = 0x36, REG_TIMSK1 = 0x6f, COMPARE_B = 1 << 2 };

static void note_reading(struct board *b, int value)
{
	b->converted = value;
	if (b->log_cycles == 0)
		board_log(b);
}

// The converter samples its input one and a half of its clock periods after the start.
static avr_cycle_count_t sample_and_hold(avr_t *avr, avr_cycle_count_t when, void *param)
{
	struct board *b = param;
	(void)avr;
	(void)when;
	board_sync(b);
	int value = misread(&b->misreading, sensor_count(&b->sensor, b->plant.x), (int)b->sensor.lowest,
	                    (int)b->sensor.counts_per_turn);
	avr_raise_irq(b->sensor_pin, (uint32_t)sensor_millivolts(value, MILLIVOLTS));
	note_reading(b, value);
	return 0;
}

static void conversion_started(avr_irq_t *irq, uint32_t value, void *param)
{
	struct board *b = param;
	(void)irq;
	(void)value;
	if ((b->avr->data[REG_ADMUX] & 0x0f) != SENSOR_CHANNEL || b->sensor.kind != MAGNETORESISTIVE)
		return;
	unsigned prescaler = b->avr->data[REG_ADCSRA] & 7;
	avr_cycle_timer_register(b->avr, (3u << (prescaler ? prescaler : 1)) / 2, sample_and_hold, b);
}

static int hall_angle(void *outside)
{
	struct board *b = outside;
	board_sync(b);
	if (b->misreading.stuck == 0.0)
		b->misreading.last = sensor_count(&b->sensor, b->plant.x);
	note_reading(b, b->misreading.last);
	return b->misreading.last;
}

// The encoder counts independently; the program reads the count in the handler of the clock.
static void clock_handler(avr_irq_t *irq, uint32_t running, void *param)
{
	struct board *b = param;
	(void)irq;
	if (running && b->sensor.kind == QUADRATURE)
		note_reading(b, b->steps);
}

static avr_timer_t *find_timer_1(avr_t *avr)
{
	for (avr_io_t *io = avr->io_port; io; io = io->next)
		if (strcmp(io->kind, "timer") == 0 && ((avr_timer_t *)io)->name == '1')
			return (avr_timer_t *)io;
	fprintf(stderr, "virtual_board: this simavr has no timer 1 in the ATmega328P\n");
	exit(1);
}

// An interrupt that is enabled while its flag is set is triggered at once, but not by simavr.
static void clock_mask_written(avr_irq_t *irq, uint32_t value, void *param)
{
	struct board *b = param;
	(void)irq;
	if (value & b->avr->data[REG_TIFR1] & COMPARE_B)
		avr_raise_interrupt(b->avr, &find_timer_1(b->avr)->comp[AVR_TIMER_COMPB].interrupt);
}

static void attach_converter(struct board *b)
{
	avr_t *avr = b->avr;
	b->sensor_pin = avr_io_getirq(avr, AVR_IOCTL_ADC_GETIRQ, ADC_IRQ_ADC0 + SENSOR_CHANNEL);
	avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_ADC_GETIRQ, ADC_IRQ_OUT_TRIGGER),
	                        conversion_started, b);
}

// The program uses only edges. If levels are selected, as after a reset, simavr checks a low pin in every
// cycle, even if the chip sleeps or the interrupt of the pin is disabled.
static void forget_levels(avr_t *avr)
{
	for (int pin = EXTINT_IRQ_OUT_INT0; pin <= EXTINT_IRQ_OUT_INT1; pin++)
		avr_extint_set_strict_lvl_trig(avr, (uint8_t)pin, 0);
}

void reading_attach(struct board *b)
{
	attach_converter(b);
	forget_levels(b->avr);
	b->hall.angle = hall_angle;
	b->hall.outside = b;
	b->spi.select = as5048a_select;
	b->spi.exchange = as5048a_exchange;
	b->spi.device = &b->hall;
	spi_attach(&b->spi, b->avr);
	avr_irq_register_notify(avr_get_interrupt_irq(b->avr, CLOCK_VECTOR) + AVR_INT_IRQ_RUNNING, clock_handler, b);
	avr_irq_register_notify(avr_iomem_getirq(b->avr, REG_TIMSK1, NULL, AVR_IOMEM_IRQ_ALL), clock_mask_written,
	                        b);
	reading_reset(b);
}

void reading_reset(struct board *b)
{
	spi_reset(&b->spi);
	if (b->sensor.kind == QUADRATURE)
		encoder_reset(b);
}
