// Virtual board: the Hapkit firmware in simavr with the paddle around it.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

#include "eeprom.h"

#include <avr_eeprom.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SIZE = 1024, ERASED = 0xff };

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

void eeprom_save(avr_t *avr, const char *path)
{
	if (!path)
		return;
	uint8_t bytes[SIZE];
	avr_eeprom_desc_t all = {.ee = bytes, .offset = 0, .size = SIZE};
	avr_ioctl(avr, AVR_IOCTL_EEPROM_GET, &all);
	FILE *file = fopen(path, "wb");
	if (!file || fwrite(bytes, 1, SIZE, file) != SIZE || fclose(file) != 0)
		fail(path);
}
