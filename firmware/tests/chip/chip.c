// Calls functions of a program in simavr, one by one, and counts their cycles; tests/firmware/chip_calls.py speaks
// with it. Usage: chip PROGRAM.elf; on standard input, little endian:
//   'W' address, size (uint16), bytes: write memory
//   'R' address, size: read memory                                       -> bytes
//   'C' address of a function (bytes), count (uint32), then for each call the registers r18 to r25
//                                                                        -> for each, r22 to r25 and cycles (uint32)
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

#include <sim_avr.h>
#include <sim_core.h>
#include <sim_elf.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

enum { FIRST = 18, GIVEN = 8, RESULT = 22, TOP = 0x8ff, BACK = 0x7ffc, MOST = 2000000 };

static avr_t *avr;
static FILE *answers;

static void fail(const char *what)
{
	fprintf(stderr, "chip: %s\n", what);
	exit(1);
}

static void take(void *where, size_t size)
{
	if (fread(where, 1, size, stdin) != size)
		fail("input ended");
}

// Return the cycles of the call alone, from its first instruction to the end of its return.
static uint32_t call(uint16_t address)
{
	avr->data[TOP] = BACK / 2 & 0xff;
	avr->data[TOP - 1] = BACK / 2 >> 8;
	avr->data[R_SPL] = (TOP - 2) & 0xff;
	avr->data[R_SPH] = (TOP - 2) >> 8;
	avr->data[1] = 0;
	avr->pc = address;
	avr->state = cpu_Running;
	const avr_cycle_count_t before = avr->cycle;
	while (avr->pc != BACK) {
		avr->pc = avr_run_one(avr);
		if (avr->cycle - before > MOST || avr->state != cpu_Running)
			fail("a call did not come back");
	}
	if (avr->data[1] != 0)
		fail("r1 is not zero after a call");
	if ((avr->data[R_SPL] | avr->data[R_SPH] << 8) != TOP)
		fail("a call left something on the stack");
	return avr->cycle - before;
}

static void calls(void)
{
	uint16_t address;
	uint32_t count;
	take(&address, sizeof address);
	take(&count, sizeof count);
	for (; count; count--) {
		take(avr->data + FIRST, GIVEN);
		const uint32_t cycles = call(address);
		fwrite(avr->data + RESULT, 1, 4, answers);
		fwrite(&cycles, sizeof cycles, 1, answers);
	}
}

static void memory(int what)
{
	uint16_t where[2];
	take(where, sizeof where);
	if (where[0] + where[1] > avr->ramend + 1)
		fail("no such memory");
	if (what == 'W')
		take(avr->data + where[0], where[1]);
	else
		fwrite(avr->data + where[0], 1, where[1], answers);
}

int main(int count, char **words)
{
	// otherwise simavr would log the loaded file on standard output
	answers = fdopen(dup(STDOUT_FILENO), "wb");
	dup2(STDERR_FILENO, STDOUT_FILENO);
	elf_firmware_t firmware = {0};
	if (count != 2 || elf_read_firmware(words[1], &firmware))
		fail("no program");
	avr = avr_make_mcu_by_name("atmega328p");
	if (!avr)
		fail("no atmega328p");
	avr_init(avr);
	avr_load_firmware(avr, &firmware);
	while (avr->state == cpu_Running)  // run until main() sleeps
		avr->pc = avr_run_one(avr);
	for (int what; (what = getchar()) != EOF; fflush(answers)) {
		if (what == 'C')
			calls();
		else if (what == 'R' || what == 'W')
			memory(what);
		else
			fail("unknown word");
	}
	return 0;
}
