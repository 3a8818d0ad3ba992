// The memory that keeps its bytes without power. eeprom_avr.cpp is the chip's; the tests bring their own.
#pragma once

#include <stdint.h>

namespace eeprom {

constexpr uint8_t kErased = 0xff;  // what a byte holds that was never written

// Whether the last write has come to its end. Until then, nothing else may be asked.
bool ready();

uint8_t read(uint16_t at);

// Begin to write a byte, which takes 3.4 ms; a power cut during it leaves any value in this byte alone.
void write(uint16_t at, uint8_t byte);

}  // namespace eeprom
