// This file is included before machine.cpp and counts the operations that are run.
#pragma once

#include <stdint.h>

void machine_count(uint8_t opcode);

#define MACHINE_COUNT(opcode) machine_count(opcode)
