// Tables in flash, which the chip reads with special instructions.
#pragma once

#include <stdint.h>

#ifdef __AVR__
#include <avr/pgmspace.h>
#else
#define PROGMEM
#endif

namespace flash {

template <class T>
inline T read(const T* at) {
#ifdef __AVR__
  T value;
  memcpy_P(&value, at, sizeof value);
  return value;
#else
  return *at;
#endif
}

}  // namespace flash
