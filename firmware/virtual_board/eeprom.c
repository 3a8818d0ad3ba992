// Virtual board: the Hapkit firmware in the simulator simavr, connected to a simulated paddle.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

#include "eeprom.h"

#include <avr_eeprom.h>
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SIZE = 1024, ERASED = 0xff };

// The register and the bit that start the writing of a byte. The file is saved 20 ms later, which is after
// the last byte of a block.
enum { EECR = 0x3f, EEPE = 1 << 1, LATER = 320000 };

struct kept {
	avr_t *avr;
	char *path;
};

static void fail(const char *path)
{
	fprintf(stderr, "virtual_board: EEPROM: %s: %s\n", path, strerror(errno));
	exit(2);
}

void eeprom_load(avr_t *avr, const char *path)
{
	uint8_t bytes[SIZE];
	memset(bytes, ERASED, sizeof bytes);
	FILE *file = path ? fopen(path, "rb") : NULL;
	if (path && !file && errno != ENOENT)
		fail(path);
	if (file && fread(bytes, 1, SIZE, file) < SIZE && ferror(file))
		fail(path);
	if (file)
		fclose(file);
	avr_eeprom_desc_t all = {.ee = bytes, .offset = 0, .size = SIZE};
	avr_ioctl(avr, AVR_IOCTL_EEPROM_SET, &all);
}

// Write to a temporary file first, so that the old file stays intact if the program is interrupted.
void eeprom_save(avr_t *avr, const char *path)
{
	if (!path)
		return;
	uint8_t bytes[SIZE];
	avr_eeprom_desc_t all = {.ee = bytes, .offset = 0, .size = SIZE};
	avr_ioctl(avr, AVR_IOCTL_EEPROM_GET, &all);
	char half[PATH_MAX];
	if (snprintf(half, sizeof half, "%s.new", path) >= (int)sizeof half) {
		errno = ENAMETOOLONG;
		fail(path);
	}
	FILE *file = fopen(half, "wb");
	if (!file || fwrite(bytes, 1, SIZE, file) != SIZE || fclose(file) != 0 || rename(half, path) != 0)
		fail(path);
}

static avr_cycle_count_t written(avr_t *avr, avr_cycle_count_t when, void *param)
{
	(void)when;
	eeprom_save(avr, param);
	return 0;
}

// Setting the timer again restarts it, so that the file is saved once per block.
static void control_touched(avr_irq_t *irq, uint32_t value, void *param)
{
	struct kept *kept = param;
	(void)irq;
	if (value & EEPE)
		avr_cycle_timer_register(kept->avr, LATER, written, kept->path);
}

void eeprom_keep(avr_t *avr, const char *path)
{
	static struct kept kept;
	if (!path)
		return;
	kept = (struct kept){.avr = avr, .path = (char *)path};
	avr_irq_register_notify(avr_iomem_getirq(avr, EECR, NULL, AVR_IOMEM_IRQ_ALL), control_touched, &kept);
}
