// Virtual board: the Hapkit firmware in the simulator simavr, connected to a simulated paddle.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

#include "loader.h"

#include <sim_elf.h>
#include <sim_hex.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static void fail(const char *path, const char *why)
{
	fprintf(stderr, "virtual_board: %s: %s\n", path, why);
	exit(1);
}

// simavr logs much on standard output, which is reserved for the replies of this program.
static void log_errors(avr_t *avr, const int level, const char *format, va_list arguments)
{
	(void)avr;
	if (level <= LOG_ERROR)
		vfprintf(stderr, format, arguments);
}

// Load an Intel hex file; return the lowest address of its data.
static uint32_t load_hex(avr_t *avr, const char *path)
{
	ihex_chunk_p chunks = NULL;
	int count = read_ihex_chunks(path, &chunks);
	if (count <= 0)
		fail(path, "not an Intel hex file");
	uint32_t lowest = avr->flashend;
	for (int i = 0; i < count; i++) {
		if (chunks[i].size == 0)  // a record with the start address, which the chip ignores
			continue;
		if (chunks[i].baseaddr + chunks[i].size > avr->flashend + 1)
			fail(path, "larger than the chip's flash memory");
		avr_loadcode(avr, chunks[i].data, chunks[i].size, chunks[i].baseaddr);
		if (chunks[i].baseaddr < lowest)
			lowest = chunks[i].baseaddr;
	}
	avr->codeend = avr->flashend;
	free_ihex_chunks(chunks);
	return lowest;
}

static void load_elf(avr_t *avr, const char *path)
{
	elf_firmware_t firmware;
	memset(&firmware, 0, sizeof firmware);
	if (elf_read_firmware(path, &firmware) != 0 || firmware.flashsize == 0)
		fail(path, "not a firmware");
	if (firmware.flashbase + firmware.flashsize > avr->flashend + 1)
		fail(path, "larger than the chip's flash memory");
	avr_load_firmware(avr, &firmware);
}

avr_t *load_firmware(const char *path, uint32_t frequency, uint32_t millivolts)
{
	if (access(path, R_OK) != 0)
		fail(path, "cannot be read; build the firmware first");
	avr_global_logger_set(log_errors);
	avr_t *avr = avr_make_mcu_by_name("atmega328p");
	if (!avr || avr_init(avr) != 0)
		fail("simavr", "does not know the ATmega328P");
	size_t length = strlen(path);
	if (length > 4 && strcmp(path + length - 4, ".hex") == 0)
		load_hex(avr, path);
	else
		load_elf(avr, path);
	avr->frequency = frequency;
	avr->vcc = avr->avcc = avr->aref = millivolts;
	return avr;
}

void load_bootloader(avr_t *avr, const char *path)
{
	if (access(path, R_OK) != 0)
		fail(path, "cannot be read");
	avr->reset_pc = load_hex(avr, path);
	avr->codeend = avr->flashend;
	avr->pc = avr->reset_pc;
}
