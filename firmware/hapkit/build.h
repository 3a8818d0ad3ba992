// Name of this build, at most 16 characters, and its laws; the Makefile passes a fingerprint of the sources.
#pragma once

#ifndef HAPKIT_BUILD
#define HAPKIT_BUILD "arduino-ide"
#endif

// All laws fit the chip only with the Makefile's options, which the Arduino IDE cannot be given: there it is
// these. mass_spring_damper and puck are left out; both have room in place of friction and cat.
// The numbers are the bits of the choices, as laws/table.h has them.
#define HAPKIT_LAWS(LAW)                                                                \
  LAW(free, 0x0) LAW(spring, 0x0) LAW(wall, 0x18) LAW(damping, 0x0) LAW(friction, 0x1)  \
  LAW(hard_surface, 0x8) LAW(bump_valley, 0x1c) LAW(texture, 0x1) LAW(button, 0x0)      \
  LAW(detents, 0x0) LAW(cat, 0x80)
