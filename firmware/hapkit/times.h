// Converts an integer to float and multiplies it by a positive factor, in 1.5 times the time of a float
// multiplication.
#pragma once

#include <stdint.h>

#ifdef __AVR__
extern "C" float times(int32_t value, float factor);
#else
inline float times(int32_t value, float factor) { return static_cast<float>(value) * factor; }
#endif
