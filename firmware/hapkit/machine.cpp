#include "machine.h"

#include "functions.h"

namespace machine {

// A build with bounded runs redefines this macro to count operations.
#ifndef MACHINE_COUNT
#define MACHINE_COUNT(opcode)
#endif

alignas(4) uint8_t arena[kArena];

// machine_avr.S is the version for the chip. A test on the chip renames this version and compares both.
#ifndef __AVR__
#define HAPKIT_RUN run
#endif
#ifdef HAPKIT_RUN

namespace {

uint16_t word(const uint8_t* at) { return static_cast<uint16_t>(at[0] | at[1] << 8); }

uint8_t outcome(float a, float b) { return a < b ? 1 : a == b ? 2 : a > b ? 4 : 8; }

}  // namespace

float HAPKIT_RUN(float x, float v) {
  float* const slot = slots();
  const uint8_t* back[kMostCalls];
  uint16_t counter[kMostCounters];
  uint8_t depth = 0;
  float a = x;
  slot[0] = x;
  slot[1] = v;
  for (const uint8_t* at = program.main + 1;;) {
    const uint8_t opcode = *at++;
    MACHINE_COUNT(opcode);
    switch (opcode) {
      case kReturn:
        if (depth == 0) return a;
        at = back[--depth];
        continue;
      case kCall:
        back[depth++] = at + 2;
        at = program.code + word(at) + 1;
        continue;
      case kJump: at += 1 + at[0]; continue;
      case kFarJump: at += 2 + word(at); continue;
      case kLoop:
        counter[at[0]] = word(at + 1);
        at += 3;
        continue;
      case kNext:
        at += 3;
        if (--counter[at[-3]]) at -= word(at - 2);
        continue;
      case kNegate: a = -a; continue;
      case kAbsolute: a = functions::magnitude(a); continue;
      case kSqrt: a = functions::sqrt(a); continue;
      case kFloor: a = functions::floor(a); continue;
      case kCeil: a = functions::ceil(a); continue;
      case kTruncate: a = functions::trunc(a); continue;
      case kSin: a = functions::sin(a); continue;
      case kCos: a = functions::cos(a); continue;
      case kTan: a = functions::tan(a); continue;
      case kAsin: a = functions::asin(a); continue;
      case kAcos: a = functions::acos(a); continue;
      case kAtan: a = functions::atan(a); continue;
      case kExp: a = functions::exp(a); continue;
      case kExpm1: a = functions::expm1(a); continue;
      case kLog: a = functions::log(a); continue;
      case kLog1P: a = functions::log1p(a); continue;
      case kSinh: a = functions::sinh(a); continue;
      case kCosh: a = functions::cosh(a); continue;
      case kTanh: a = functions::tanh(a); continue;
      default: break;
    }
    if (opcode >= kTest) {
      at += outcome(a, 0.0f) & opcode ? 1 + at[0] : 1;
      continue;
    }
    float* const first = slot + *at++;
    const float s = *first;
    if (opcode >= kCompare) {
      at += outcome(a, s) & opcode ? 1 + at[0] : 1;
      continue;
    }
    switch (opcode) {
      case kLoad: a = s; break;
      case kStore: *first = a; break;
      case kLoadAt:
      case kStoreAt:
        if (!(s >= 0.0f && s < at[1])) return NAN;
        if (opcode == kLoadAt) {
          a = slot[at[0] + static_cast<uint8_t>(s)];
        } else {
          slot[at[0] + static_cast<uint8_t>(s)] = a;
        }
        at += 2;
        break;
      case kAdd: a = functions::sum(a, s); break;
      case kSubtract: a = functions::sum(a, -s); break;
      case kSubtractFrom: a = functions::sum(s, -a); break;
      case kMultiply: a = functions::product(a, s); break;
      case kDivide:
        if (functions::is_zero(s)) return NAN;
        a = functions::quotient(a, s);
        break;
      case kDivideInto:
        if (functions::is_zero(a)) return NAN;
        a = functions::quotient(s, a);
        break;
      case kMinimum: a = s < a ? s : a; break;
      case kMaximum: a = s > a ? s : a; break;
      case kFloorDivide:
        if (functions::is_zero(s)) return NAN;
        a = functions::floor_divide(a, s);
        break;
      case kModulo:
        if (functions::is_zero(s)) return NAN;
        a = functions::modulo(a, s);
        break;
      case kRemainder:
        if (functions::is_zero(s)) return NAN;
        a = functions::remainder(a, s);
        break;
      case kPower: a = functions::power(a, s); break;
      case kAtan2: a = functions::atan2(a, s); break;
      case kHypot: a = functions::hypot(a, s); break;
      case kCopysign: a = functions::signed_as(a, s); break;
    }
  }
}

#endif

}  // namespace machine
