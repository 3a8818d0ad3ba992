// Virtual board: the Hapkit firmware in the simulator simavr, connected to a simulated paddle.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

#include "options.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct number {
	const char *name;
	size_t offset;
	double fallback, low, high;
	const char *help;
};

#define AT(field) offsetof(struct options, field)

static const struct number NUMBERS[] = {
	{"seconds", AT(seconds), INFINITY, 0, INFINITY, "board time to run [s]"},
	{"slice", AT(slice), 250e-6, 50e-6, 500e-6, "board time between two looks at the clock [s]"},
	{"answer-timeout", AT(answer_timeout), 1.0, 1e-3, 3600, "real time lockstep waits for an answer [s]"},
	{"await", AT(awaited), 0x82, 0, 255, "identifier of the frames that are answered; 0: all of them"},
	{"log-period", AT(log_period), 0, 0, 10, "period of the log [s]; 0: at every conversion"},
	{"mass", AT(mass), 0.044, 1e-6, 10, "mass at the handle [kg]"},
	{"viscous", AT(viscous), 0.5, 0, 100, "viscous friction at the handle [N s/m]"},
	{"coulomb", AT(coulomb), 0.10, 0, 100, "Coulomb friction at the handle [N]"},
	{"stop", AT(stop), INFINITY, 1e-3, INFINITY, "end stops at +- this position [m]; none by default"},
	{"position", AT(position), 0, -1, 1, "position at the start [m]"},
	{"velocity", AT(velocity), 0, -10, 10, "velocity at the start [m/s]"},
	{"handle-radius", AT(handle_radius), 0.090, 1e-3, 1, "sector axis to handle [m]"},
	{"pulley-radius", AT(pulley_radius), 0.005, 1e-4, 1, "motor pulley [m]"},
	{"sector-radius", AT(sector_radius), 0.074, 1e-3, 1, "sector drum [m]"},
	{"torque", AT(torque), 0.0183, 0, 1, "motor torque at full duty [N m]"},
	{"direction", AT(direction), 1, -1, 1, "sign of the force while the direction pin is high"},
	{"pins", AT(pins), 5, 3, 5, "5: the motor is on D5 and D8; 3: on D3 and D12"},
	{"motor-power", AT(motor_power), 2, 0.2, 5, "power of the duty with which the torque grows"},
	{"dead-band", AT(dead_band), 0, 0, 254, "duty of 255 below which the motor does not turn"},
	{"counts", AT(counts), 0, 0, 65536, "sensor counts from one repeat to the next; 0: 921, 16384, 48"},
	{"lowest", AT(lowest), 51, 0, 1023, "converter value at the beginning of a half turn"},
	{"magnet", AT(magnet), 300, -1e6, 1e6, "sensor counts at position 0"},
	{"sensor-sign", AT(sensor_sign), 1, -1, 1, "-1: the magnet is turned round"},
	{"sensor-absent", AT(sensor_absent), 0, 0, 1, "1: nothing answers on the SPI bus"},
	{"spi-flip", AT(spi_flip), 0, 0, 1, "probability that a bit of an AS5048A's answer is turned"},
	{"seed", AT(seed), 0, 0, 1e15, "of everything that goes wrong by chance"},
	{"to-drop", AT(to.drop), 0, 0, 1, "probability that a byte to the board is lost"},
	{"to-flip", AT(to.flip), 0, 0, 1, "probability that one of its bits is turned"},
	{"to-insert", AT(to.insert), 0, 0, 1, "probability that a random byte comes before it"},
	{"to-burst", AT(to.burst), 0, 0, 1, "probability that random bytes begin to replace what is sent"},
	{"to-length", AT(to.length), 20, 1, 1e6, "bytes that such a burst replaces"},
	{"from-drop", AT(from.drop), 0, 0, 1, "the same from the board"},
	{"from-flip", AT(from.flip), 0, 0, 1, ""},
	{"from-insert", AT(from.insert), 0, 0, 1, ""},
	{"from-burst", AT(from.burst), 0, 0, 1, ""},
	{"from-length", AT(from.length), 20, 1, 1e6, ""},
	{"latency", AT(latency), 0, 0, 1, "latency timer of the USB chip [s]; 0: none, every frame at once"},
	{"sensor-stuck", AT(misreading.stuck), 0, 0, 1, "1: the reading stands still"},
	{"sensor-noise", AT(misreading.noise), 0, 0, 1000, "standard deviation of a reading [counts]"},
	{"sensor-jump", AT(misreading.jump), 0, 0, 1, "probability of a reading half a turn off or out of range"},
};
enum { NUMBER_COUNT = sizeof NUMBERS / sizeof *NUMBERS };

static void usage(FILE *to)
{
	fprintf(to, "usage: virtual_board FIRMWARE.elf|.hex [options]\n"
	            "  --paced             board time follows the clock (default)\n"
	            "  --lockstep          as fast as the computer answers, never ahead of it; a lone delimiter is an answer\n"
	            "  --turns             says `turn SECONDS BYTES` after every answered frame or 20 ms, waits for `go BYTES`\n"
	            "  --fast              as fast as it goes, waiting for nobody\n"
	            "  --control           commands on standard input; its end ends the program\n"
	            "  --script FILE       commands by board time, lines `time command`\n"
	            "  --link PATH         keep a symbolic link on the serial port\n"
	            "  --log FILE          truth log\n"
	            "  --sensor KIND       mr (default), as5048a, quadrature\n"
	            "  --eeprom FILE       keeps the EEPROM from run to run\n"
	            "  --bootloader FILE   .hex run after a reset; opening the port resets, speeds must agree\n");
	for (int i = 0; i < NUMBER_COUNT; i++)
		fprintf(to, "  --%-17s %s (%g)\n", NUMBERS[i].name, NUMBERS[i].help, NUMBERS[i].fallback);
}

static void wrong(const char *what, const char *which)
{
	fprintf(stderr, "virtual_board: %s %s\n", what, which);
	exit(2);
}

static bool take_number(struct options *o, const char *name, const char *text)
{
	for (int i = 0; i < NUMBER_COUNT; i++) {
		const struct number *n = &NUMBERS[i];
		if (strcmp(name, n->name) != 0)
			continue;
		char *end = NULL;
		double value = text ? strtod(text, &end) : NAN;
		if (!text || end == text || *end || !(value >= n->low && value <= n->high)) {
			fprintf(stderr, "virtual_board: --%s goes from %g to %g, not %s\n", name, n->low, n->high,
			        text ? text : "nothing");
			exit(2);
		}
		*(double *)((char *)o + n->offset) = value;
		return true;
	}
	return false;
}

static bool take_word(struct options *o, const char *name)
{
	if (strcmp(name, "paced") == 0)
		o->mode = PACED;
	else if (strcmp(name, "lockstep") == 0)
		o->mode = LOCKSTEP;
	else if (strcmp(name, "turns") == 0)
		o->mode = TURNS, o->control = true;
	else if (strcmp(name, "fast") == 0)
		o->mode = FAST;
	else if (strcmp(name, "control") == 0)
		o->control = true;
	else
		return false;
	return true;
}

static bool take_path(struct options *o, const char *name, const char *text)
{
	const char **place = strcmp(name, "link") == 0     ? &o->link
	                     : strcmp(name, "log") == 0    ? &o->log
	                     : strcmp(name, "script") == 0 ? &o->script
	                     : strcmp(name, "bootloader") == 0 ? &o->bootloader
	                     : strcmp(name, "eeprom") == 0 ? &o->eeprom
	                                                   : NULL;
	if (!place)
		return false;
	if (!text)
		wrong("a path has to follow", name);
	*place = text;
	return true;
}

static bool take_sensor(struct options *o, const char *name, const char *text)
{
	if (strcmp(name, "sensor") != 0)
		return false;
	if (!text || !sensor_named(text, &o->sensor))
		wrong("--sensor is mr, as5048a or quadrature, not", text ? text : "nothing");
	return true;
}

struct options options_read(int argc, char **argv)
{
	struct options o = {.mode = PACED};
	for (int i = 0; i < NUMBER_COUNT; i++)
		*(double *)((char *)&o + NUMBERS[i].offset) = NUMBERS[i].fallback;
	for (int i = 1; i < argc; i++) {
		const char *word = argv[i];
		if (strcmp(word, "--help") == 0) {
			usage(stdout);
			exit(0);
		}
		if (strncmp(word, "--", 2) != 0) {
			if (o.firmware)
				wrong("one firmware only, not also", word);
			o.firmware = word;
		} else if (!take_word(&o, word + 2)) {
			const char *text = i + 1 < argc ? argv[i + 1] : NULL;
			if (!take_sensor(&o, word + 2, text) && !take_path(&o, word + 2, text) &&
			    !take_number(&o, word + 2, text))
				wrong("no such option:", word);
			i++;
		}
	}
	if (!o.firmware) {
		usage(stderr);
		exit(2);
	}
	return o;
}
